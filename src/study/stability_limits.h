// The step limits of explicit schemes, measured on bodies and foretold by theory.
#pragma once

#include <string>
#include <vector>

#include "stability_subject.h"

namespace deformable_sim::stability {

/// A measured limit beside that of theory.
struct Limit {
  std::string body, integrator;
  double ratio = 0.0;     // damping ratio of the fastest motion
  double theory = 0.0;    // s: the least of the limits of all modes, stability_limit(zeta_i) / omega_i
  double fast = 0.0;      // s: that of the fastest motion, stable_step(), which worlds divide their steps by
  double measured = 0.0;  // s: half way between the longest step that stays bounded and the shortest that does not
};

/// The body at rest, without weight and drag, so that a small disturbance is a sum of its modes: a chain of 10 links
/// (rope), or a sheet of springs of 6 x 5 cells (sheet), both held at one node.
/// ratio: of the fastest motion; dampers are 2 ratio / omega_max times the stiffness, so that zeta_i = ratio omega_i /
/// omega_max.
Limit measure_limit(const std::string& body, const std::string& integrator, double ratio);

/// Explicit schemes that have a limit of their own, by name.
std::vector<std::string> limited_schemes();

/// Whether a random disturbance of 1e-9 m is larger in the second half of `steps` steps than in the first: twice the
/// mean energy.
bool grows(const Subject& subject, const std::string& integrator, double dt, int steps);

}  // namespace deformable_sim::stability
