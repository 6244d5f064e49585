// Shapes compared whatever way they have turned and moved, and shapes at random.
#pragma once

#include <random>

#include "deformable_sim/core/element/solid_stress.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim::test {

/// Largest distance between a shape and the closest rigid copy of another one (Procrustes).
inline double distance_from_rigid_copy(const Nodes& x, const Nodes& rest) {
  const Vec3 center = x.rowwise().mean(), rest_center = rest.rowwise().mean();
  const Mat3 rotation = polar_rotation((x.colwise() - center) * (rest.colwise() - rest_center).transpose());
  return ((x.colwise() - center) - rotation * (rest.colwise() - rest_center)).colwise().norm().maxCoeff();
}

/// Anywhere in a cube of side 1 around the origin.
inline Nodes random_nodes(Eigen::Index count, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  return Nodes::NullaryExpr(3, count, [&] { return uniform(generator); });
}

}  // namespace deformable_sim::test
