// Nodes that any springs and constant links join in motion, in the packets and the precision that kernels work in.
#pragma once

#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/grid/mesh_packets.h"
#include "deformable_sim/core/grid/position_unit.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

/// Positions and velocities between the start and the end of a step, as SheetMotion has them of a grid.
///
/// Slow links (LinkSplit) need not act in every leap. Their damping takes the velocity in the middle of their impulse,
/// as far as the impulse before, within the step, foretells it.
template <class Real>
class MeshMotion {
 public:
  /// mass: kg of all nodes; held: their indices, ascending.
  MeshMotion(const SpringTerms& terms, const Eigen::VectorXd& mass, const std::vector<int>& held,
             const LinkSplit& split, SimdLevel level = simd_level());

  bool contains(int node) const { return packets_.index(node) >= 0; }
  bool has_links() const { return packets_.has_links(); }

  /// dt: s, of the step that begins. Velocities of held nodes are those of their paths.
  void load(const State& s, double dt);
  void store(Nodes* x, Nodes* v);
  void get(int node, Vec3* x, Vec3* v);
  void set(int node, const Vec3& x, const Vec3& v);

  /// v += kick (f / m + g - rate v) + slow_kick slow links / m, rate semi-implicit; x += drift v. `more`: further
  /// forces of all nodes (N), or null. impulses += what all this gives the held nodes (N s); columns as in Kinematics.
  void leap(double kick, double slow_kick, double drift, const MassForce& everywhere, const Nodes* more,
            Nodes* impulses);

 private:
  using Position = typename MotionPosition<Real>::Type;
  struct Held {
    Eigen::Index column;  // in Kinematics
    std::ptrdiff_t place;
  };
  MeshLeap<Real> numbers();
  void bend(const MeshEntries<Real>& links, double kick, double half, MeshLeap<Real> leap, Nodes* impulses);
  void add_held_forces(double weight, Nodes* impulses) const;
  void find_bent(const State& s);
  void mark_fast();

  const MeshKernels<Real>& kernels_;
  MeshPackets<Real> packets_;
  std::vector<const Energy*> link_terms_;
  RowArray<Position> x_, x_points_, start_;
  RowArray<Real> v_, v_points_, y_points_, bent_, rate_, gain_, more_, force_;
  PositionUnit<Real> unit_;
  double longest_ = 0.0;  // m, of the springs at rest
  std::vector<Held> held_;
  std::vector<unsigned char> keeps_;  // by packet: has a held node
  std::vector<unsigned char> leans_;  // by packet: a fast link wants its y
  State mine_;                        // single precision: these nodes at the start
  State still_;                       // single precision: the start without velocities
  Nodes bending_;                     // and the links' forces there
};

extern template class MeshMotion<float>;
extern template class MeshMotion<double>;

}  // namespace deformable_sim
