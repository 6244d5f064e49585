// Which constant links act in every part of an explicit step, and which in every few.
#pragma once

#include <vector>

#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Links of bending are soft beside springs, all but the few where a crooked mesh has short edges and light nodes.
/// Those with |k_ij| (m_i m_j)^(-1/2) above `fastest` (1/s^2) act in every part; all others in every `together` parts,
/// with the impulse of all of them [Hairer 2006, VIII.4], as long as these are not further apart than `longest` (s).
///
/// lambda being a bound of the eigenvalues of what is left, c the links' damping and t the time between two impulses:
///   t lambda^(1/2) <= 0.15  what swings is followed,
///   t c lambda <= 0.25      what decays too: beyond 1 it would grow,
///   t <= c                  where impulses come about as often as springs swing, every pi / t, they may feed that
///                           motion at a rate of lambda t / (2 pi), and damping takes c lambda.
/// Without damping all links act in every part.
struct LinkSplit {
  double fastest = 0.0;
  int together = 1;
  double longest = 0.0;
};

/// The split with which parts of length `part` (s) have the fewest links to go through. mass: kg of all nodes.
LinkSplit split_links(const std::vector<const ConstantLinks*>& links, const Eigen::VectorXd& mass, double part);

}  // namespace deformable_sim
