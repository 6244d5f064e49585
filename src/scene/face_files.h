// Polygons from OBJ, STL and PLY files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesh_text.h"

namespace deformable_sim {

/// Polygons as they stand in a file. Throws InputError where the file claims or holds more than the limits.
class Faces {
 public:
  static constexpr std::size_t kMostPoints = 3000000;   // before points at the same place become one
  static constexpr std::size_t kMostCorners = 3000000;  // of all faces together

  using Point = std::array<float, 3>;

  void add_point(const Point& point);
  /// Corners of one face, and then end_face(). `point` may be one that follows later: check() looks.
  void add_corner(long point);
  void end_face();
  /// Corners of the face that has no end yet.
  std::size_t open_corners() const { return corners_.size() - begin(ends_.size()); }
  std::size_t point_count() const { return points_.size(); }

  /// Throws InputError when a face names a point that is not there, or has fewer than three.
  void check() const;

  const std::vector<Point>& points() const { return points_; }
  /// Cut into triangles. A quadrangle is cut at its inner corner, if it has one; a convex polygon into a fan; others of
  /// at most 64 corners at their ears. Throws InputError for more.
  std::vector<std::array<int, 3>> triangles() const;

 private:
  std::size_t begin(std::size_t face) const { return face == 0 ? 0 : ends_[face - 1]; }
  void cut(std::vector<int> polygon, std::vector<std::array<int, 3>>* out) const;

  std::vector<Point> points_;
  std::vector<long> corners_;
  std::vector<std::size_t> ends_;
};

// `bytes` is the file, `name` stands for it in messages. All throw InputError "name:line: what", or "name: what" for
// binary files. Colours, normals and texture coordinates are left out.

/// Wavefront OBJ: v and f; points and lines are refused, all other statements left out.
Faces read_obj(const std::string& bytes, const std::string& name);

/// STL, ASCII or binary.
Faces read_stl(const std::string& bytes, const std::string& name);

/// PLY, ASCII or binary of either byte order: elements vertex and face; others are left out.
Faces read_ply(const std::string& bytes, const std::string& name);

}  // namespace deformable_sim
