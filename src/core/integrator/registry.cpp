// Time schemes by name.
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

struct Entry {
  const char* name;
  std::unique_ptr<Integrator> (*make)(const SolverSettings&);
  bool in_stages = false;  // of make_stage_solver, and nothing else that needs a matrix
};

constexpr Entry kEntries[] = {
    {"explicit_euler", [](const SolverSettings&) { return make_explicit_euler(); }},
    {"symplectic_euler", [](const SolverSettings&) { return make_symplectic_euler(); }},
    {"velocity_verlet", [](const SolverSettings&) { return make_velocity_verlet(); }},
    {"rk4", [](const SolverSettings&) { return make_rk4(); }},
    {"implicit_euler", [](const SolverSettings& settings) { return make_implicit_euler(settings); }, true},
    {"linear_implicit_euler", [](const SolverSettings& settings) { return make_linear_implicit_euler(settings); }},
    {"implicit_midpoint", [](const SolverSettings& settings) { return make_implicit_midpoint(settings); }},
    {"bdf2", [](const SolverSettings& settings) { return make_bdf2(settings); }, true},
    {"tr_bdf2", [](const SolverSettings& settings) { return make_tr_bdf2(settings); }, true},
    {"substepped_verlet", [](const SolverSettings& settings) { return make_substepped_verlet(settings); }},
    {"line_dual", [](const SolverSettings& settings) { return make_line_dual(settings); }},
    {"xpbd", [](const SolverSettings& settings) { return make_xpbd(settings); }},
    {"projective_dynamics", [](const SolverSettings& settings) { return make_projective_dynamics(settings); }},
};

}  // namespace

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kEntries) names.emplace_back(entry.name);
  return names;
}

bool is_in_stages(const std::string& integrator) {
  for (const Entry& entry : kEntries) {
    if (integrator == entry.name) return entry.in_stages;
  }
  return false;
}

std::unique_ptr<Integrator> make_integrator(const std::string& name, const SolverSettings& settings) {
  std::string allowed;
  for (const Entry& entry : kEntries) {
    if (name == entry.name) return entry.make(settings);
    allowed += std::string(allowed.empty() ? "" : ", ") + entry.name;
  }
  throw InputError("integrator \"" + name + "\" is unknown; allowed: " + allowed, Code::kNotFound);
}

}  // namespace deformable_sim
