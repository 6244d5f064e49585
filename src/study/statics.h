// Static equilibria of a specimen: a minimum of the energy, found without time.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/energy/energy.h"

namespace deformable_sim::study {

struct Equilibrium {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;  // largest unbalanced force over the largest force there is
};

struct StaticsSettings {
  double tolerance = 1e-8;    // of the residual
  int iterations = 2000;      // at most
  double longest_move = 0.0;  // m, of a node in one iteration; 0: no limit
};

/// Minimises the sum of energies over the coordinates that are not held, by Newton's method with the exact Hessian,
/// shifted by a multiple of the identity wherever it is not positive definite or promises more than it keeps
/// (Levenberg-Marquardt): the energy falls at every step, so that buckled states are found, not unstable straight ones.
///
/// held: 3 n, one flag a coordinate. force_scale (N): a force that is not small, beside the reactions.
/// Not good at: terms without an energy (drag, dampers), and contact.
Equilibrium settle(const std::vector<std::unique_ptr<Energy>>& energies, const std::vector<char>& held,
                   double force_scale, const StaticsSettings& settings, State* state);

/// Sum of the energies' forces at a state with v = 0, N.
Nodes forces_of(const std::vector<std::unique_ptr<Energy>>& energies, const State& state);

}  // namespace deformable_sim::study
