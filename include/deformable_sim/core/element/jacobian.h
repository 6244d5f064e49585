// Which derivative is asked for: the exact one, or the one an implicit step can solve with.
#pragma once

namespace deformable_sim {

/// Which Jacobian a term delivers.
enum class Jacobian {
  kExact,      // df/dx and df/dv as derived; may be indefinite and, for velocity terms, unsymmetric
  kProjected,  // symmetric; -df/dx and -df/dv positive semi-definite: what an implicit step solves with
  kLagged,  // springs: as projected, with the tension at State::x_before, the start of the step; others: as projected
  kAxial,   // springs: k n n^T alone, as often published [Volino and Magnenat-Thalmann 2001]; others: as projected
};

}  // namespace deformable_sim
