#include "deformable_sim/core/topology/sheet_cut.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/polygon_cut.h"
#include "seam_bands.h"

namespace deformable_sim {
namespace {

constexpr double kSnapped = 1e-3;      // of a square: a mesh line this near to its edge is its edge
constexpr double kSeamSnapped = 0.02;  // of a band's width, likewise

struct Checker {
  double edge;
  Eigen::Vector2d origin;

  /// Of a point that is not on an edge.
  Paint at(const Vec3& p) const {
    if (edge == 0.0) return Paint::kPlain;
    const auto number = [&](int axis) { return std::floor((p[axis] - origin[axis]) / edge); };
    return std::fmod(std::abs(number(0) + number(1)), 2.0) < 0.5 ? Paint::kPlain : Paint::kChecker;
  }
};

/// Cuts the triangles of a mesh one after the other. Corners of polygons are weights of the triangle's three points.
class Cutter {
 public:
  Cutter(const TriangleMesh& mesh, const SheetPattern& pattern)
      : mesh_(mesh), pattern_(pattern), checker_{pattern.checker, mesh.rest.topRows<2>().rowwise().minCoeff()} {
    if (pattern.seams > 0.0) bands_ = seam_bands(mesh, pattern.seams, 8 * kMaxCuts);
  }

  SheetCut run() {
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) cut_triangle(t);
    for (const std::array<int, 3>& edge : border_edges(mesh_)) cut_rim(edge);
    return std::move(result_);
  }

 private:
  CutPolygon cut_at(const Polygon& polygon, const Vec3& normal, double offset, double tolerance) const {
    return cut(polygon, corners_.transpose() * normal, offset, tolerance);
  }

  void cut_triangle(size_t t) {
    triangle_ = mesh_.triangles[t];
    for (int k = 0; k < 3; ++k) corners_.col(k) = mesh_.rest.col(triangle_[static_cast<size_t>(k)]);
    std::vector<Polygon> left{{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}};
    if (!bands_.of_triangle.empty()) {
      // First bands that reach along all of the triangle, for those take no more than one cut.
      for (const bool whole : {true, false}) {
        for (const int b : bands_.of_triangle[t]) {
          const SeamBand& band = bands_.bands[static_cast<size_t>(b)];
          if (reaches_along(band) == whole) take_band(band, &left);
        }
      }
    }
    for (const Polygon& polygon : left) take_squares(polygon, 0);
  }

  bool reaches_along(const SeamBand& band) const {
    for (size_t k : {2, 3}) {
      if ((corners_.transpose() * band.bounds[k].normal).minCoeff() < band.bounds[k].offset) return false;
    }
    return true;
  }

  void take_band(const SeamBand& band, std::vector<Polygon>* left) {
    std::vector<Polygon> remaining;
    for (Polygon& polygon : *left) {
      std::vector<Polygon> outside;
      Polygon inside = polygon;
      for (const HalfSpace& bound : band.bounds) {
        CutPolygon parts = cut_at(inside, bound.normal, bound.offset, kSeamSnapped * pattern_.seams);
        inside = std::move(parts.inside);
        if (!parts.outside.empty()) outside.push_back(std::move(parts.outside));
        if (inside.empty()) break;
      }
      if (inside.empty()) {
        remaining.push_back(std::move(polygon));
        continue;
      }
      add(inside, Paint::kSeam);
      for (Polygon& part : outside) remaining.push_back(std::move(part));
    }
    *left = std::move(remaining);
  }

  /// Columns of squares, then each column's rows.
  void take_squares(Polygon polygon, int axis) {
    if (axis == 2 || checker_.edge == 0.0) {
      Vec3 middle = Vec3::Zero();
      for (const Vec3& weights : polygon) middle += corners_ * weights / static_cast<double>(polygon.size());
      add(polygon, checker_.at(middle));
      return;
    }
    const double edge = checker_.edge, origin = checker_.origin[axis];
    double least = 1e300, most = -1e300;
    for (const Vec3& weights : polygon) {
      const double at = corners_.row(axis).dot(weights);
      least = std::min(least, at);
      most = std::max(most, at);
    }
    const double last = std::floor((most - origin) / edge - kSnapped);
    for (double line = std::floor((least - origin) / edge + kSnapped) + 1.0; line <= last; line += 1.0) {
      CutPolygon parts = cut_at(polygon, Vec3::Unit(axis), origin + line * edge, kSnapped * edge);
      polygon = std::move(parts.inside);
      if (!parts.outside.empty()) take_squares(std::move(parts.outside), axis + 1);
      if (polygon.empty()) return;
    }
    take_squares(std::move(polygon), axis + 1);
  }

  int corner(const Vec3& weights) {
    for (int k = 0; k < 3; ++k) {
      if (weights[k] == 1.0) return triangle_[static_cast<size_t>(k)];
    }
    result_.extras.push_back({triangle_, weights});
    return static_cast<int>(mesh_.rest.cols() + static_cast<Eigen::Index>(result_.extras.size())) - 1;
  }

  void add(const Polygon& polygon, Paint paint) {
    std::vector<int> corners;
    for (const Vec3& weights : polygon) corners.push_back(corner(weights));
    for (size_t k = 2; k < corners.size(); ++k) {
      result_.pieces.push_back({{corners[0], corners[k - 1], corners[k]}, paint});
    }
    if (result_.pieces.size() > mesh_.triangles.size() + kMaxCuts) {
      throw InputError(
          "cuts the sheet into more than " + std::to_string(kMaxCuts) + " pieces; larger squares are allowed",
          Code::kOutOfRange);
    }
  }

  void cut_rim(const std::array<int, 3>& edge) {
    const Vec3 a = mesh_.rest.col(edge[0]), b = mesh_.rest.col(edge[1]);
    if (pattern_.seams > 0.0 || checker_.edge == 0.0) {
      result_.rims.push_back({{edge[0], edge[1]}, pattern_.seams > 0.0 ? Paint::kSeam : Paint::kPlain});
      return;
    }
    std::vector<double> places{0.0, 1.0};
    for (int axis = 0; axis < 2; ++axis) {
      const double from = (a[axis] - checker_.origin[axis]) / checker_.edge;
      const double to = (b[axis] - checker_.origin[axis]) / checker_.edge;
      const double last = std::floor(std::max(from, to) - kSnapped);
      for (double line = std::floor(std::min(from, to) + kSnapped) + 1.0; line <= last; line += 1.0) {
        places.push_back((line - from) / (to - from));
      }
    }
    std::sort(places.begin(), places.end());
    triangle_ = {edge[0], edge[1], edge[1]};
    int before = edge[0];
    for (size_t k = 1; k < places.size(); ++k) {
      const int end = corner(Vec3(1.0 - places[k], places[k], 0.0));
      const double t = 0.5 * (places[k - 1] + places[k]);
      result_.rims.push_back({{before, end}, checker_.at(inward((1.0 - t) * a + t * b, edge[2]))});
      before = end;
    }
  }

  /// A point just inside the triangle.
  Vec3 inward(const Vec3& at, int triangle) const {
    const std::array<int, 3>& t = mesh_.triangles[static_cast<size_t>(triangle)];
    const Vec3 middle = (mesh_.rest.col(t[0]) + mesh_.rest.col(t[1]) + mesh_.rest.col(t[2])) / 3.0;
    const double step = 2.0 * kSnapped * checker_.edge;
    return at + std::min(1.0, step / (middle - at).norm()) * (middle - at);
  }

  const TriangleMesh& mesh_;
  SheetPattern pattern_;
  Checker checker_;
  SeamBands bands_;
  SheetCut result_;
  std::array<int, 3> triangle_{};  // being cut, and where its corners are at rest
  Mat3 corners_;
};

}  // namespace

SheetCut cut_sheet(const TriangleMesh& mesh, const SheetPattern& pattern) {
  return Cutter(mesh, pattern).run();
}

}  // namespace deformable_sim
