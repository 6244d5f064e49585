// What a choice of solver rests on.
#include <algorithm>
#include <cmath>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/sheet_stage.h"
#include "deformable_sim/scene/solver_choice.h"

namespace deformable_sim {
namespace {

constexpr double kFrame = 1.0 / 60.0;  // s
constexpr double kLeastSteps = 1e-3;   // a scene without forces has no limit
constexpr const char* kMixed = "mixed";

/// Of the start, with nothing held.
Dynamics dynamics_of(const Model& model) {
  Dynamics d;
  d.mass = &model.mass;
  if (model.mass_matrix.nonZeros() > 0) d.mass_matrix = &model.mass_matrix;
  for (const auto& energy : model.energies) d.energies.push_back(energy.get());
  d.grids = &model.grids;
  return d;
}

std::string bodies_of(const SceneSpec& spec, const Model& model) {
  const BodyKind kind = spec.bodies.front().kind;
  for (const BodySpec& body : spec.bodies) {
    if (body.kind != kind) return kMixed;
  }
  if (kind == BodyKind::kSoft) return "solid";
  if (kind == BodyKind::kRope) {
    if (model.angle_count == 0) return "rope";
    const bool all =
        std::all_of(model.bodies.begin(), model.bodies.end(), [](const Body& b) { return b.first_segment >= 0; });
    return all ? "rod" : kMixed;
  }
  return sheets_fit(dynamics_of(model)) ? kSheetOnGrid : "sheet";
}

/// Of velocity Verlet, s, at the start.
double stable_step_of(const Model& model) {
  const Dynamics d = dynamics_of(model);
  const std::unique_ptr<Integrator> scheme = make_integrator("velocity_verlet", {});
  return stable_step(*scheme, highest_frequency(d, model.initial, Effort::kRough),
                     highest_damping_rate(d, model.initial, Effort::kRough));
}

}  // namespace

SceneFeatures features_of(const SceneSpec& spec, const Model& model) {
  SceneFeatures features;
  features.bodies = bodies_of(spec, model);
  features.nodes = model.point_count();
  features.explicit_steps = std::max(kLeastSteps, kFrame / stable_step_of(model));
  features.contact = !spec.colliders.empty() || spec.robot.present ||
                     std::any_of(spec.bodies.begin(), spec.bodies.end(),
                                 [](const BodySpec& body) { return body.touches != BodyContact::kNone; });
  features.strain_limits = !model.strain_limits.empty();
  return features;
}

}  // namespace deformable_sim
