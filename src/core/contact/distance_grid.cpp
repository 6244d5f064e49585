#include "deformable_sim/core/contact/distance_grid.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

/// Room around the box, as a share of its longest edge: points that come near are answered before they arrive.
constexpr double kRoom = 0.05;
constexpr double kSingle = 1.2e-7;  // relative rounding of a float

}  // namespace

DistanceGrid::DistanceGrid(const Eigen::AlignedBox3d& box) {
  const Vec3 edges = box.sizes() + Vec3::Constant(2.0 * kRoom * box.sizes().maxCoeff());
  spacing_ = std::cbrt(edges.prod() / kPoints);
  size_ = (edges / spacing_).array().ceil().cast<int>() + 1;
  origin_ = box.center() - 0.5 * spacing_ * (size_ - 1).cast<double>().matrix();
  rounding_ = kSingle * spacing_ * size_.cast<double>().matrix().norm();
}

void DistanceGrid::fill(const Distance& distance, const Progress& progress) {
  values_.resize(static_cast<size_t>(size_.prod()));
  const double grid_diagonal = spacing_ * size_.cast<double>().matrix().norm();
  for (int z = 0; z < size_.z(); ++z) {
    for (int y = 0; y < size_.y(); ++y) {
      for (int x = 0; x < size_.x(); ++x) {
        // From one grid point to the next the distance grows by a spacing at most.
        const double last = x > 0   ? value(x - 1, y, z)
                            : y > 0 ? value(x, y - 1, z)
                            : z > 0 ? value(x, y, z - 1)
                                    : grid_diagonal;
        const double reach = std::abs(last) + (1.0 + 1e-9) * spacing_ + rounding_;
        values_[index(x, y, z)] = static_cast<float>(distance(place(x, y, z), reach));
      }
    }
    if (progress) progress((z + 1.0) / size_.z());
  }
}

bool DistanceGrid::bounds(const Vec3& p, DistanceBounds* found) const {
  const Vec3 at = (p - origin_) / spacing_;
  const Eigen::Array3i nearest = (at.array() + 0.5).floor().cwiseMax(-1.0).cwiseMin(1e6).cast<int>();
  if ((nearest < 0).any() || (nearest >= size_).any()) return false;
  const double away = spacing_ * (at - nearest.cast<double>().matrix()).norm() + rounding_;
  const double stored = value(nearest.x(), nearest.y(), nearest.z());
  found->low = stored - away;
  found->high = stored + away;
  return true;
}

}  // namespace deformable_sim
