// A sheet on a grid in motion, in the rows and the precision that its kernels work in.
#pragma once

#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/grasp/kinematics.h"
#include "deformable_sim/core/grid/sheet_rows.h"

namespace deformable_sim {

/// Positions and velocities of one sheet between the start and the end of a step.
template <class Real>
class SheetMotion {
 public:
  /// mass: kg of all nodes; held: their indices, ascending.
  SheetMotion(const GridSheet& sheet, const Eigen::VectorXd& mass, const std::vector<int>& held);

  bool contains(int node) const { return node >= rows_.first_node() && node < rows_.first_node() + rows_.node_count(); }

  /// Velocities of held nodes are those of their paths.
  void load(const Nodes& x, const Nodes& v);
  void store(Nodes* x, Nodes* v);
  void get(int node, Vec3* x, Vec3* v);
  void set(int node, const Vec3& x, const Vec3& v);

  /// v += kick (f / m + g - rate v), rate semi-implicit; x += drift v. `more`: further forces of all nodes (N), or
  /// null.
  void leap(double kick, double drift, const MassForce& everywhere, const Nodes* more);
  /// forces += weight * f of the last leap at the held nodes of this sheet; columns as in Kinematics.
  void add_held_forces(double weight, Nodes* forces);

 private:
  struct Held {
    Eigen::Index column;  // in Kinematics
    std::ptrdiff_t place;
  };
  SheetRows<Real> rows_;
  const SheetKernels<Real>& kernels_;
  XyzArray<Real> x_, v_, y_, force_, more_;
  RowArray<Real> gain_, free_;
  std::vector<Held> held_;
  std::vector<unsigned char> keeps_;  // by row: has a held node
};

extern template class SheetMotion<float>;
extern template class SheetMotion<double>;

}  // namespace deformable_sim
