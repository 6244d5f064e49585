#include "cloth_plane.h"

#include <cmath>

#include "deformable_sim/core/error.h"

namespace deformable_sim::study {
namespace {

constexpr double kStrain = 1e-6;  // small enough that every law is linear to 1e-5
constexpr double kWidth = 0.05;   // m

void keep_in_plane(Specimen* sheet) {
  for (int i = 0; i < sheet->node_count(); ++i) sheet->hold(i, 2);
}

/// Slope of the displacement of one coordinate over that coordinate, in the middle third of a strip along `along`.
double slope(const Specimen& strip, int coordinate, int along, double length) {
  double n = 0, sx = 0, su = 0, sxx = 0, sxu = 0;
  for (int i = 0; i < strip.node_count(); ++i) {
    if (std::abs(strip.rest(along, i)) > length / 6.0) continue;
    const double x = strip.rest(coordinate, i), u = strip.state.x(coordinate, i) - x;
    n += 1;
    sx += x;
    su += u;
    sxx += x * x;
    sxu += x * u;
  }
  return (n * sxu - sx * su) / (n * sxx - sx * sx);
}

bool at(double value, double wanted) {
  return std::abs(value - wanted) < 1e-9;
}

/// A square of side kWidth whose boundary is displaced by u = strain x.
Specimen deformed_square(const FabricData& fabric, const ClothModel& model, int cells, const Mat3& strain) {
  const TriangleMesh mesh = make_grid(kWidth, kWidth, cells, cells);
  Specimen square = make_sheet(mesh, fabric, model);
  keep_in_plane(&square);
  for (int i = 0; i < square.node_count(); ++i) {
    const Vec3 x = mesh.rest.col(i);
    square.state.x.col(i) += strain * x;
    if (at(std::abs(x[0]), 0.5 * kWidth) || at(std::abs(x[1]), 0.5 * kWidth)) square.hold(i);
  }
  square.settle();
  return square;
}

/// Virtual work of the boundary's reactions on u = direction x, per area and per unit of `direction`: N/m.
double stress_on(const Specimen& square, const Mat3& direction) {
  if (!square.settled()) return none();
  const Nodes reactions = square.reactions();
  double work = 0.0;
  for (int i = 0; i < square.node_count(); ++i) work += reactions.col(i).dot(direction * Vec3(square.rest.col(i)));
  return work / (kWidth * kWidth);
}

}  // namespace

Traction pull_strip(const FabricData& fabric, const ClothModel& model, Along along, int cells_across) {
  const int axis = along == Along::kWarp ? 0 : 1, across = 1 - axis;
  const double length = 5.0 * kWidth;
  const TriangleMesh mesh = along == Along::kWarp ? make_grid(length, kWidth, 5 * cells_across, cells_across)
                                                  : make_grid(kWidth, length, cells_across, 5 * cells_across);
  Specimen strip = make_sheet(mesh, fabric, model);
  keep_in_plane(&strip);
  for (int i = 0; i < strip.node_count(); ++i) {
    const double x = mesh.rest(axis, i);
    strip.state.x(axis, i) += kStrain * x;
    if (!at(std::abs(x), 0.5 * length)) continue;
    strip.hold(i, axis);  // the ends may contract: rollers, but for one node that keeps the strip in place
    if (at(x, -0.5 * length) && at(mesh.rest(across, i), -0.5 * kWidth)) strip.hold(i, across);
  }
  if (!strip.settle().converged) return {strip.node_count(), none(), none()};
  const Nodes reactions = strip.reactions();
  double force = 0.0;
  for (int i = 0; i < strip.node_count(); ++i) {
    if (at(mesh.rest(axis, i), 0.5 * length)) force += reactions(axis, i);
  }
  const double extension = slope(strip, axis, axis, length);
  return {strip.node_count(), force / kWidth / extension, -slope(strip, across, axis, length) / extension};
}

Measurement shear_square(const FabricData& fabric, const ClothModel& model, int cells) {
  Mat3 direction = Mat3::Zero();
  direction(0, 1) = 1.0;  // u_x = gamma y
  const Specimen square = deformed_square(fabric, model, cells, kStrain * direction);
  return {square.node_count(), stress_on(square, direction) / kStrain, 0.0};
}

Measurement compress_square(const FabricData& fabric, const ClothModel& model, int cells) {
  Mat3 direction = Mat3::Zero();
  direction(0, 0) = direction(1, 1) = -1.0;
  const Specimen square = deformed_square(fabric, model, cells, kStrain * direction);
  // The mean pressure (s11 + s22) / 2 over the area's loss 2 epsilon.
  return {square.node_count(), stress_on(square, direction) / (4.0 * kStrain), 0.0};
}

Measurement pull_on_the_bias(const FabricData& fabric, const ClothModel& model, int cells) {
  const TriangleMesh mesh = make_grid(kWidth, kWidth, cells, cells);
  Specimen square = make_sheet(mesh, fabric, model);
  keep_in_plane(&square);
  const Vec3 d(std::sqrt(0.5), std::sqrt(0.5), 0.0);
  const double stress = kStrain * fabric.traction_bias(), half = 0.5 * kWidth, side = kWidth / cells;
  for (int i = 0; i < square.node_count(); ++i) {
    for (int axis = 0; axis < 2; ++axis) {
      const double x = mesh.rest(axis, i), along = mesh.rest(1 - axis, i);
      if (!at(std::abs(x), half)) continue;
      // Traction s d (d.n) on an edge of normal n: half a side's worth at a corner.
      const double width = at(std::abs(along), half) ? 0.5 * side : side;
      square.load(i, (x > 0.0 ? 1.0 : -1.0) * stress * width * d[axis] * d);
    }
  }
  const int corner = 0, next = cells;  // along x from it
  square.hold(corner);
  square.hold(next, 1);
  if (!square.settle().converged) return {square.node_count(), none(), 0.0};
  // From corner to corner, along d.
  const Vec3 diagonal = mesh.rest.col(square.node_count() - 1) - mesh.rest.col(0);
  const Vec3 moved = square.state.x.col(square.node_count() - 1) - square.state.x.col(0) - diagonal;
  return {square.node_count(), stress / (moved.dot(d) / diagonal.norm()), 0.0};
}

}  // namespace deformable_sim::study
