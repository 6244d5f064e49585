// One physical term of the equations of motion, over all the elements it applies to.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/linear/block_matrix.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

struct ConstantLinks;

/// What a term does to every node in proportion to its mass: f = m (acceleration - rate v).
struct MassForce {
  Vec3 acceleration = Vec3::Zero();  // m/s^2
  double rate = 0.0;                 // 1/s
};

/// A term of the equations of motion M dv/dt = sum of forces.
///
/// Conservative terms have an energy E(x) and the force -dE/dx; dissipative and driving terms (viscous, drag, wind)
/// have value() == 0 and only a force f(x, v).
class Energy {
 public:
  virtual ~Energy() = default;

  /// Short stable name for the bill, for example "stretch springs".
  virtual std::string name() const = 0;
  /// Number of elements, for the bill.
  virtual int element_count() const = 0;
  /// Stored energy (J); 0 for a dissipative term.
  virtual double value(const State& s) const = 0;
  /// f += force (N) at (x, v, time).
  virtual void add_force(const State& s, Nodes* f) const = 0;

  /// Node pairs that the Jacobian couples; the diagonal is always there.
  virtual void add_pattern(std::vector<std::array<int, 2>>* pairs) const = 0;
  /// Looks up, once, where this term's blocks lie. Called before the first add_jacobian; never by explicit schemes.
  virtual void bind(const BlockMatrix& matrix) = 0;
  /// A -= dx * df/dx + dv * df/dv.
  virtual void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const = 0;

  /// Whether the energy may be below 0, as that of a pressure. Else what motion can gain is bounded by what is stored,
  /// and a step by which it gains more is made again.
  virtual bool may_be_negative() const { return false; }

  /// Of terms that are nothing but a MassForce; null for all others.
  virtual const MassForce* mass_force() const { return nullptr; }

  /// Constant links whose derivative is this term's Jacobian, or near enough to it for Newton's matrix; null where
  /// there are none. A solver that takes them needs neither the term's blocks nor bind(). May allocate when first
  /// asked.
  virtual const ConstantLinks* constant_links() const { return nullptr; }

  /// Carries what the state remembers for this term beyond x and v to the positions at the end of a step.
  virtual void end_step(State* /*s*/) const {}
};

}  // namespace deformable_sim
