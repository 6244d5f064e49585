// A sheet on a grid in motion, in the rows and the precision that its kernels work in.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/grasp/kinematics.h"
#include "deformable_sim/core/grid/bands.h"
#include "deformable_sim/core/grid/motion_rows.h"
#include "deformable_sim/core/grid/position_unit.h"

namespace deformable_sim {

/// Positions and velocities of one sheet between the start and the end of a step. In single precision positions are
/// counted from the middle of the sheet, in 2^31 units for what a node can reach within the step; a sheet that has
/// become much faster than that is given back as not a number, so that the step is taken again in parts.
template <class Real>
class SheetMotion {
 public:
  /// mass: kg of all nodes; held: their indices, ascending; workers: null is one thread.
  SheetMotion(const GridSheet& sheet, const Eigen::VectorXd& mass, const std::vector<int>& held,
              SimdLevel level = simd_level(), const Workers* workers = nullptr);

  bool contains(int node) const { return node >= rows_.first_node() && node < rows_.first_node() + rows_.node_count(); }

  /// dt: s, of the step that begins. Velocities of held nodes are those of their paths.
  void load(const Nodes& x, const Nodes& v, double dt);
  void store(Nodes* x, Nodes* v);
  void get(int node, Vec3* x, Vec3* v);
  void set(int node, const Vec3& x, const Vec3& v);

  /// v += kick (f / m + g - rate v), rate semi-implicit; x += drift v. `more`: further forces of all nodes (N), or
  /// null.
  void leap(double kick, double drift, const MassForce& everywhere, const Nodes* more);
  /// forces += weight * f of the last leap at the held nodes of this sheet; columns as in Kinematics.
  void add_held_forces(double weight, Nodes* forces);

 private:
  using Position = typename MotionPosition<Real>::Type;
  static constexpr bool kCounts = PositionUnit<Real>::kCounts;
  struct Held {
    Eigen::Index column;  // in Kinematics
    std::ptrdiff_t place;
  };
  MotionLeap<Real> numbers();
  void put(std::ptrdiff_t place, std::ptrdiff_t own, const Vec3& x, const Vec3& v);

  const MotionKernels<Real>& kernels_;
  MotionRows<Real> rows_;
  const BandLoop bands_;
  RowArray<Position> x_, start_;
  RowArray<Real> v_, y_, bent_, force_, more_, gain_, passed_;
  std::array<RowArray<Real>, 3> row_;
  PositionUnit<Real> unit_;
  double longest_;  // m, of the springs at rest
  std::vector<Held> held_;
  std::vector<unsigned char> keeps_;  // by row: has a held node
};

extern template class SheetMotion<float>;
extern template class SheetMotion<double>;

}  // namespace deformable_sim
