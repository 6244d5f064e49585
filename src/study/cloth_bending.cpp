#include "cloth_bending.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim::study {
namespace {

constexpr double kStripWidth = 0.025;  // m, of a strip along warp or weft

/// Clamps and settles an overhang of `length`; `shape` holds the last shape over its length, to start from.
Overhang hang_strip(const FabricData& fabric, const ClothModel& model, double angle, int cells, double length,
                    Nodes* shape) {
  // Two columns are held: the clamp line is in the middle of the first element.
  const double element = length / (cells - 0.5);
  const bool on_the_bias = std::abs(std::sin(2.0 * angle)) > 1e-9;
  const double width = on_the_bias ? 0.04 * length : kStripWidth;
  const int across = std::max(2, static_cast<int>(std::lround(width / element)));
  const TriangleMesh mesh = make_grid(cells * element, width, cells, std::min(across, cells));
  Specimen strip = make_sheet(mesh, fabric, model, angle);
  strip.weigh(Vec3(0, 0, -kStandardGravity), strip.node_count());
  const double clamp = -0.5 * cells * element + 0.5 * element;
  const bool continued = shape->cols() == mesh.rest.cols();
  for (int i = 0; i < strip.node_count(); ++i) {
    const Vec3 x = mesh.rest.col(i);
    if (x[0] < clamp + element) strip.hold(i);
    if (continued) strip.state.x.col(i) = Vec3(length * (*shape)(0, i) + clamp, x[1], length * (*shape)(2, i));
    if (x[0] < clamp + element) strip.state.x.col(i) = x;
  }
  StaticsSettings settings;
  settings.longest_move = 0.3 * length;
  settings.tolerance = 1e-7;
  Overhang found;
  found.settled = strip.settle(settings).converged;
  found.nodes = strip.node_count();
  *shape = strip.state.x;
  shape->row(0).array() -= clamp;
  *shape /= length;
  double tip_x = 0.0, tip_z = 0.0;
  for (int c = 0; c < mesh.cols; ++c) {
    double x = 0.0, z = 0.0;
    for (int r = 0; r < mesh.rows; ++r) {
      x += (strip.state.x(0, r * mesh.cols + c) - clamp) / mesh.rows;
      z += strip.state.x(2, r * mesh.cols + c) / mesh.rows;
    }
    found.shape.push_back({x, z});
    tip_x = x;
    tip_z = z;
  }
  found.chord = std::atan2(-tip_z, tip_x);
  return found;
}

}  // namespace

Measurement bend_strip(const FabricData& fabric, const ClothModel& model, double angle, int cells,
                       std::vector<Curve>* curves) {
  Overhang last;
  Nodes shape;
  const double guess = 2.0 * fabric.bending_length();
  const double length = overhang_at_41_5(
      guess, [&](double l) { return hang_strip(fabric, model, angle, cells, l, &shape); }, &last);
  if (curves && std::isfinite(length)) {
    curves->push_back({"cantilever, " + std::to_string(cells) + " elements", "x, m", "z, m", last.shape});
  }
  const double rigidity = fabric.areal_density * kStandardGravity * length * length * length / kGammaAt41_5;
  return {last.nodes, rigidity, 0.0};
}

Measurement twist_square(const FabricData& fabric, const ClothModel& model, int cells) {
  // m, 1/m: so flat that it does not stretch, not so flat that rounding of its stretch outweighs its bending.
  const double side = 0.02, kappa = 1e-3;
  const TriangleMesh mesh = make_grid(side, side, cells, cells);
  Specimen square = make_sheet(mesh, fabric, model);
  const double twist = fabric.bend_twist().value_or(0.5 * std::sqrt(fabric.bend_warp * fabric.bend_weft));
  const double force = 4.0 * twist * kappa;
  const int row = cells + 1, last = square.node_count() - 1;
  const std::array<int, 4> corner = {0, row - 1, last, last - row + 1};
  for (size_t k = 0; k < 4; ++k) square.load(corner[k], Vec3(0, 0, (k % 2 == 0 ? 1.0 : -1.0) * force));
  // Held against rigid motion only: nothing reacts.
  square.hold(corner[0]);
  square.hold(corner[1], 1);
  square.hold(corner[1], 2);
  square.hold(corner[3], 2);
  if (!square.settle().converged) return {square.node_count(), none(), 0.0};
  const auto z = [&](size_t k) { return square.state.x(2, corner[k]); };
  const double found = (z(0) - z(1) + z(2) - z(3)) / (side * side);  // d2w / dx dy
  return {square.node_count(), force / (4.0 * found), 0.0};
}

}  // namespace deformable_sim::study
