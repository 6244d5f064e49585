// Shape functions of the tetrahedron with a node in the middle of each edge.
#pragma once

#include <array>

#include "deformable_sim/core/element/tetrahedron.h"

namespace deformable_sim {

/// The two corners of each middle node.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges = {{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// 3 x 10, column-major: reference gradients of N_corner = l (2 l - 1), N_middle = 4 l_i l_j at the point with
/// barycentric coordinates l (of corners a, b, c, d).
constexpr std::array<double, 30> quadratic_gradients(const std::array<double, 4>& l) {
  std::array<double, 30> g{};
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::array<double, 4> slope = {-1.0, axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
    for (size_t c = 0; c < 4; ++c) g[3 * c + axis] = (4.0 * l[c] - 1.0) * slope[c];
    for (size_t m = 0; m < 6; ++m) {
      const auto i = static_cast<size_t>(kTetEdges[m][0]), j = static_cast<size_t>(kTetEdges[m][1]);
      g[3 * (m + 4) + axis] = 4.0 * (l[i] * slope[j] + l[j] * slope[i]);
    }
  }
  return g;
}

/// Ten nodes: the corners and the middles of ab, bc, ca, ad, bd, cd; four points of quadrature, exact for polynomials
/// of degree two [Zienkiewicz 2013]. Strain is linear inside: bending is not locked with one element through the
/// thickness. Not good at: explicit schemes, whose step limit is less than half of that of linear elements with the
/// same nodes.
struct QuadraticShape {
  static constexpr int kPoints = 10;
  static constexpr int kQuadrature = 4;
  /// Barycentric coordinates of a point of quadrature: (5 + 3 sqrt 5) / 20 at its corner, (5 - sqrt 5) / 20 elsewhere.
  static constexpr double kNear = 0.58541019662496845446, kFar = 0.13819660112501051518;
  static constexpr std::array<std::array<double, 30>, 4> kGradients = {
      quadratic_gradients({kNear, kFar, kFar, kFar}), quadratic_gradients({kFar, kNear, kFar, kFar}),
      quadratic_gradients({kFar, kFar, kNear, kFar}), quadratic_gradients({kFar, kFar, kFar, kNear})};
};

using QuadraticTetrahedron = SolidTetrahedron<QuadraticShape>;

}  // namespace deformable_sim
