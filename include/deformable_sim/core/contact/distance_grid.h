// Signed distances at the points of a regular grid: a cheap first answer to how far a surface is.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Two bounds of a signed distance, m.
struct DistanceBounds {
  double low = 0.0;
  double high = 0.0;
};

/// The surface may be as sharp as it likes: a signed distance changes by at most the way gone,
///
///   |d(p) - d(c)| <= |p - c|,
///
/// so that the value at the nearest grid point c bounds it to sqrt(3)/2 = 0.87 spacings at worst, and no contact within
/// reach is ever missed. What is near is asked for exactly, elsewhere. Values are stored in single precision, and the
/// bounds are widened by its rounding.
class DistanceGrid {
 public:
  /// The signed distance at a point; the surface is known to be within `reach` (m) of it.
  using Distance = std::function<double(const Vec3& p, double reach)>;
  /// Told the share that is done, 0 ... 1, layer by layer.
  using Progress = std::function<void(double done)>;

  DistanceGrid() = default;
  /// Lays about kPoints grid points over the box and some room around it.
  explicit DistanceGrid(const Eigen::AlignedBox3d& box);
  void fill(const Distance& distance, const Progress& progress);

  /// False outside the grid, which is outside the box.
  bool bounds(const Vec3& p, DistanceBounds* found) const;

  double spacing() const { return spacing_; }
  const Vec3& origin() const { return origin_; }
  const Eigen::Array3i& size() const { return size_; }
  double value(int x, int y, int z) const { return values_[index(x, y, z)]; }
  Vec3 place(int x, int y, int z) const { return origin_ + spacing_ * Vec3(x, y, z); }

  /// Values as they are in memory, x running fastest.
  const std::vector<float>& values() const { return values_; }
  /// As many values as the grid has points.
  void set_values(std::vector<float> values) { values_ = std::move(values); }

  static constexpr double kPoints = 60000.0;

 private:
  size_t index(int x, int y, int z) const {
    return static_cast<size_t>(x) +
           static_cast<size_t>(size_.x()) *
               (static_cast<size_t>(y) + static_cast<size_t>(size_.y()) * static_cast<size_t>(z));
  }

  Vec3 origin_ = Vec3::Zero();
  double spacing_ = 0.0;   // m
  double rounding_ = 0.0;  // m, of a stored value
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  std::vector<float> values_;
};

}  // namespace deformable_sim
