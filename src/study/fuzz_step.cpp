// Time stepping and air of scenes made at random.
#include <algorithm>

#include "fuzz_parts.h"

namespace deformable_sim::fuzz {
namespace {

void draw_auto(Random* r, Tree* step) {
  if (r->chance(0.4)) return;  // the defaults
  if (r->chance(0.3)) (*step)["solver"] = "auto";
  if (r->chance(0.5))
    (*step)["accuracy"] =
        r->chance(0.6) ? Tree(r->pick({"interactive", "engineering", "reference"})) : Tree(r->decades(1e-4, 0.1));
  if (r->chance(0.3)) (*step)["budget"] = r->decades(0.01, 100.0);
  if (r->chance(0.4)) (*step)["dt"] = r->decades(1e-4, 0.1);
}

const std::vector<std::string> kExplicit{"explicit_euler", "symplectic_euler", "velocity_verlet", "rk4",
                                         "substepped_verlet"};

bool is_explicit(const std::string& scheme) {
  return std::find(kExplicit.begin(), kExplicit.end(), scheme) != kExplicit.end();
}

/// Schemes that the bodies can have.
std::vector<std::string> schemes(const Drawing& d) {
  std::vector<std::string> names{"implicit_euler", "linear_implicit_euler", "implicit_midpoint", "bdf2", "tr_bdf2"};
  const auto all = [&d](auto test) { return std::all_of(d.bodies.begin(), d.bodies.end(), test); };
  names.insert(names.end(), kExplicit.begin(), kExplicit.end());
  if (all([](const DrawnBody& b) { return b.springs_only; })) {
    const std::vector<std::string> dual{"line_dual", "xpbd", "projective_dynamics"};
    names.insert(names.end(), dual.begin(), dual.end());
  }
  if (!all([](const DrawnBody& b) { return !b.consistent_mass; })) {
    names = {"implicit_euler", "implicit_midpoint", "bdf2", "tr_bdf2"};
  }
  return names;
}

void draw_manual(Drawing* d, Tree* step) {
  Random& r = d->random;
  if (r.chance(0.3)) (*step)["solver"] = "manual";
  const std::string scheme = r.pick(schemes(*d));
  (*step)["integrator"] = scheme;
  // Explicit schemes divide a long step into very many parts: seldom, for it costs what a hundred scenes do.
  const bool divides = is_explicit(scheme) && r.chance(0.9);
  if (divides || r.chance(0.8)) (*step)["dt"] = r.chance(0.05) ? r.decades(1e-6, 1e-4) : r.decades(3e-4, 0.1);
  if (divides) (*step)["dt"] = r.decades(1e-5, 3e-3);
  if (r.chance(0.5)) (*step)["linear_solver"] = r.pick({"cg", "direct", "banded", "multigrid"});
  if (r.chance(0.4)) (*step)["newton_iterations"] = static_cast<int>(r.decades(1.0, 60.0));
  if (r.chance(0.4)) (*step)["tolerance"] = r.decades(1e-6, 100.0);
  if (r.chance(0.3)) (*step)["linear_tolerance"] = r.decades(1e-8, 0.5);
  if (r.chance(0.2)) (*step)["linear_iterations"] = static_cast<int>(r.decades(1.0, 1000.0));
  if (r.chance(0.2)) (*step)["precision"] = "single";
  if (r.chance(0.2)) (*step)["fraction_of_limit"] = r.uniform(0.1, 0.95);
  if (r.chance(0.2)) (*step)["jacobian"] = r.pick({"projected", "lagged", "axial"});
}

}  // namespace

void draw_air(Drawing* d) {
  Random& r = d->random;
  if (r.chance(0.65)) return;
  Tree air;
  if (r.chance(0.5)) air["drag_coefficient"] = r.decades(0.01, 10.0);
  if (r.chance(0.5)) {
    const double speed = r.decades(0.1, 30.0);
    const std::array<double, 3> turn = d->turn();
    air["wind"] = Tree(std::array<double, 3>{speed * turn[0] / 3.0, speed * turn[1] / 3.0, speed * turn[2] / 3.0});
    if (r.chance(0.4)) air["gust_amplitude"] = r.uniform(0.0, 1.0);
    if (r.chance(0.2)) air["gust_frequency"] = r.decades(0.1, 100.0);
  }
  if (r.chance(0.5)) air["damping"] = r.decades(1e-2, 1e3);
  if (r.chance(0.2)) air["density"] = r.decades(0.1, 2e3);
  if (!air.empty()) d->result.scene["air"] = air;
}

void draw_step(Drawing* d) {
  Random& r = d->random;
  if (r.chance(0.1)) d->result.scene["grasp_max_speed"] = r.decades(0.1, 100.0);
  Tree step;
  if (r.chance(0.45)) {
    draw_auto(&r, &step);
  } else {
    draw_manual(d, &step);
  }
  if (!step.empty()) d->result.scene["step"] = step;
}

}  // namespace deformable_sim::fuzz
