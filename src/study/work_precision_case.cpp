#include "work_precision_case.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "deformable_sim/scene/build.h"

namespace deformable_sim::work_precision {
namespace {

namespace fs = std::filesystem;

constexpr double kPiOver4 = 0.78539816339744831;
constexpr double kGravity = 9.81;  // m/s^2, of the stiffness ratio

// Its own stiffness, 1e3 N/m, is not among the others.
constexpr char kLadderScene[] = "hang_20", kLadderKey[] = "bodies[0].cloth.material.membrane_stiffness";
constexpr int kStiffnesses[] = {100,   200,   500,    2000,   5000,   10000,
                                20000, 50000, 100000, 200000, 500000, 1000000};  // N/m

// Kinds of bodies and of contact that the scenes of config/suite do not have.
constexpr const char* kShipped[] = {
    "cable_twist",       "denim_drape",          "hanging_sheet",      "jelly_lattice_springs", "napkin_on_sphere",
    "pleated_cloth",     "provot_cloth",         "rope_over_cylinder", "rubber_beam",           "soft_cube_on_table",
    "spring_steel_coil", "strain_limited_towel", "towel_on_table",     "tshirt_on_table"};

std::string kind_of(const SceneSpec& spec) {
  const auto name = [](BodyKind kind) {
    return kind == BodyKind::kRope ? "rope" : kind == BodyKind::kSoft ? "soft" : "cloth";
  };
  const BodyKind first = spec.bodies.front().kind;
  const bool same =
      std::all_of(spec.bodies.begin(), spec.bodies.end(), [first](const BodySpec& body) { return body.kind == first; });
  return same ? name(first) : "mixed";
}

/// Inverse of the strain at which the body would hang from its end, about.
double stiffness_ratio(const BodySpec& body, double extent) {
  if (body.kind == BodyKind::kRope) {
    const RopeMaterialSpec& m = body.rope_material;
    const double area = m.section ? (*m.section)[0] * (*m.section)[1] : kPiOver4 * m.diameter * m.diameter;
    const double spring = m.stretch_stiffness.value_or(0.0) * body.length / body.segments;
    const double axial = m.stretch_stiffness ? spring : m.axial_stiffness.value_or(m.youngs_modulus * area);
    return axial / (m.linear_density * kGravity * body.length);
  }
  if (body.kind == BodyKind::kSoft) {
    return body.soft.material.youngs_modulus / (body.soft.material.density * kGravity * extent);
  }
  const ClothMaterialSpec& m = body.cloth_material;
  const double membrane = m.stretch_stiffness.value_or(std::max(m.membrane()[0], m.membrane()[1]));
  return membrane / (m.areal_density * kGravity * extent);
}

class SceneCase : public Case {
 public:
  SceneCase(SceneSpec spec, std::string text, double duration) : spec_(std::move(spec)), text_(std::move(text)) {
    seconds = duration;
    title = spec_.title;
    solver = spec_.step.solver;
    jacobian_given = spec_.step.jacobian_given;
    name = spec_.file.empty() ? "scene" : fs::path(spec_.file).stem().string();
    char time[40];
    std::snprintf(time, sizeof time, "|%.17g|", duration);
    digest = digest_of(text_ + time);
    const std::shared_ptr<const Model> model = build_model(spec_);
    features.kind = kind_of(spec_);
    features.nodes = model->point_count();
    const SceneFeatures scene = features_of(spec_, *model);
    features.bodies = scene.bodies;
    features.explicit_steps = scene.explicit_steps;
    features.contact = scene.contact;
    features.strain_limits = scene.strain_limits;
    const Body& body = model->bodies.front();
    const auto x = model->initial.x.middleCols(body.first_node, body.node_count);
    features.stiffness_ratio =
        stiffness_ratio(spec_.bodies.front(), (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).maxCoeff());
  }

  std::unique_ptr<World> make(double dt, const std::string& integrator, const SolverSettings& settings) const override {
    SceneSpec spec = spec_;
    spec.step.dt = dt;
    spec.step.mode = SolverMode::kManual;
    spec.step.integrator = integrator;
    spec.step.solver = settings;
    // Nothing is left for the scene to choose.
    spec.step.solver_given = spec.step.iterations_given = spec.step.jacobian_given = true;
    return build_world(spec);
  }

  std::unique_ptr<Case> refined(std::string* why) const override {
    SceneSpec spec = spec_;
    for (BodySpec& body : spec.bodies) {
      if (!halve(&body, why)) return nullptr;
    }
    for (const GraspSpec& grasp : spec.grasps) {
      if (grasp.request.selection.method != SelectionMethod::kNodes) continue;
      *why = "grasp '" + grasp.request.name + "' names nodes by number";
      return nullptr;
    }
    return changed(spec, "|refined", why);
  }

  std::unique_ptr<Case> other_model(std::string* why) const override {
    SceneSpec spec = spec_;
    for (BodySpec& body : spec.bodies) {
      if (body.kind != BodyKind::kCloth) {
        *why = "'" + body.name + "' is no cloth";
        return nullptr;
      }
      if (body.cloth_material.stretch_stiffness || body.cloth.strain_limit || !body.cloth.creases.empty()) {
        *why = "'" + body.name + "' has keys that only one of the models knows";
        return nullptr;
      }
      const bool membrane = body.cloth.model == ClothModel::kMembrane;
      body.cloth.model = membrane ? ClothModel::kSprings : ClothModel::kMembrane;
    }
    return changed(spec, "|other model", why);
  }

 private:
  static bool halve(BodySpec* body, std::string* why) {
    const auto refuse = [&](const std::string& reason) {
      *why = "'" + body->name + "' " + reason;
      return false;
    };
    if (body->cloth_material.stretch_stiffness || body->rope_material.stretch_stiffness) {
      return refuse("has a stiffness per spring, which depends on the mesh");
    }
    if (!body->mesh.empty()) return refuse("has a mesh of its own");
    if (body->kind == BodyKind::kSoft && !body->soft.cells) return refuse("has no cells of its own");
    if (body->kind == BodyKind::kSoft) {
      for (int& n : *body->soft.cells) n *= 2;
    }
    if (body->kind == BodyKind::kRope && body->closed)
      return refuse("is a polygon, whose refinement has other corners");
    for (int& n : body->cells) n *= 2;
    body->segments *= 2;
    return true;
  }

  std::unique_ptr<Case> changed(const SceneSpec& spec, const std::string& what, std::string* why) const {
    try {
      auto made = std::make_unique<SceneCase>(spec, text_ + what, seconds);
      made->make(1e-3, "implicit_euler", solver);
      return made;
    } catch (const InputError& error) {
      *why = error.what();
      return nullptr;
    }
  }

  SceneSpec spec_;
  std::string text_;  // of the file, the overrides and the meshes
};

}  // namespace

std::unique_ptr<Case> Case::refined(std::string* why) const {
  *why = "there is no finer one";
  return nullptr;
}

std::unique_ptr<Case> Case::other_model(std::string* why) const {
  *why = "there is no other model";
  return nullptr;
}

std::string digest_of(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  char out[20];
  std::snprintf(out, sizeof out, "%016llx", static_cast<unsigned long long>(hash));
  return out;
}

std::string content_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path + ": cannot be read", Code::kNotFound);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string suite_dir() {
  return package_dir() + "/config/suite";
}

std::vector<SuiteEntry> suite() {
  std::vector<SuiteEntry> entries;
  for (const std::string& name : scene_names(suite_dir())) entries.push_back({name, name, {}});
  for (const int stiffness : kStiffnesses) {
    const std::string value = std::to_string(stiffness);
    entries.push_back({std::string(kLadderScene) + "_" + value, kLadderScene, {{kLadderKey, value}}});
  }
  for (const char* name : kShipped) entries.push_back({name, name, {}});
  for (const std::string& name : golden_names()) entries.push_back({name, name, {}});
  return entries;
}

std::unique_ptr<Case> scene_case(const std::string& name_or_file, const std::vector<Override>& overrides,
                                 double seconds) {
  const std::vector<std::string> suite = scene_names(suite_dir());
  const bool of_suite = std::find(suite.begin(), suite.end(), name_or_file) != suite.end();
  const std::string path = find_scene(name_or_file, of_suite ? suite_dir() : default_scene_dir());
  const SceneSpec spec = load_scene_file(path, overrides);
  if (!spec.script.empty()) throw InputError(path + ": has a script, which a study does not play");
  std::string text = content_of(path);
  for (const auto& [key, value] : overrides) text += "|" + key + "=" + value;
  for (const BodySpec& body : spec.bodies) {
    if (!body.mesh.empty()) text += content_of(body.mesh);
  }
  return std::make_unique<SceneCase>(spec, text, seconds);
}

}  // namespace deformable_sim::work_precision
