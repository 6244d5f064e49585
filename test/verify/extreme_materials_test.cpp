// F7, F8, F13: slivers, the whole range of materials, and a body that is soft here and a million times stiffer there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/solid_terms.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/small_worlds.h"
#include "support/solids.h"
#include "support/system.h"
#include "support/verification.h"
#include "support/watched_run.h"

namespace deformable_sim::test {
namespace {

double fastest_of(const std::string& step, const std::string& body) {
  const auto world = build_world(load_scene_text(
      "gravity: [0, 0, 0]\nstep: {solver: manual, dt: 0.01, " + step + "}\nbodies:\n  - " + body + "\n", "test"));
  double fastest = 0.0;
  for (int k = 0; k < 20; ++k) {
    EXPECT_TRUE(world->step().ok) << body;
    fastest = std::max(fastest, world->state().v.cwiseAbs().maxCoeff());
  }
  return fastest;
}

TEST(Sliver, StaysAtRestInAnyModel) {
  // F7. Triangles and tetrahedra a thousand times as long as thick, at rest, under no force: v = 0 but for the
  // round-off of rest lengths and areas over the mass, 1e-9 m/s.
  std::vector<std::string> bodies;
  const std::string sheet = "cloth: {name: sliver, size: [1, 0.001], cells: [1, 1], ";
  for (const char* model : {"springs", "provot"}) bodies.push_back(sheet + "model: " + model + "}");
  for (const SolidLaw law : kSolidLaws) {
    for (const char* bending : {"hinges", "quadratic"})
      bodies.push_back(sheet + "model: membrane, law: " + name_of(law) + ", bending: " + bending + "}");
    bodies.push_back("soft: {name: sliver, box: {size: [1, 1, 0.001], cells: [1, 1, 1]}, law: " + name_of(law) + "}");
  }
  for (const std::string& body : bodies) {
    double fastest = 0.0;
    for (const char* step : {"integrator: implicit_euler", "integrator: bdf2, linear_solver: multigrid",
                             "integrator: tr_bdf2, linear_solver: direct"})
      fastest = std::max(fastest, fastest_of(step, body));
    check("F7", body + ": largest speed, m/s", fastest, 0.0, 1e-9, Tolerance::kAbsolute);
  }
}

struct Material {
  SolidLaw law;
  double modulus, ratio, density;
};

constexpr double kLength = 0.4, kThickness = 0.1;  // m

/// A beam clamped at its left end under its weight. The keys of a scene end at nu = 0.499 and 0.1 kg/m^3.
std::unique_ptr<World> clamped_beam(const Material& material, const std::string& step, std::vector<int>* held) {
  SceneSpec spec = load_scene_text("step: {solver: manual, dt: 0.01, " + step +
                                       "}\nbodies:\n  - soft: {name: beam, box: {size: [0.4, 0.1, 0.1], cells: [4, 1, "
                                       "1]}, element: tetrahedron, law: " +
                                       name_of(material.law) + ", material: {damping: 0}}\n",
                                   "test");
  auto& values = spec.bodies[0].soft.material;
  values.youngs_modulus = material.modulus;
  values.poissons_ratio = material.ratio;
  values.density = material.density;
  auto world = build_world(spec);
  for (int i = 0; i < world->model().node_count(); ++i)
    if (world->state().x(0, i) < -0.5 * kLength + 1e-9) held->push_back(i);
  command::Grasp clamp;
  clamp.request = grasp_nodes("clamp", "beam", *held);
  EXPECT_TRUE(world->apply(clamp).status.ok());
  return world;
}

/// The largest of what may not be in any row.
struct Worst {
  double gain = 0.0, misreported = 0.0, further = 0.0;
};

void run_beam(const Material& m, const std::string& step, Worst* worst) {
  SCOPED_TRACE(name_of(m.law) + ", E " + std::to_string(m.modulus) + ", nu " + std::to_string(m.ratio) + ", rho " +
               std::to_string(m.density) + ", " + step);
  Watching watching;
  const auto world = clamped_beam(m, step, &watching.held);
  const double volume = kLength * kThickness * kThickness, seconds = 0.5;
  watching.round_off = 1e-15 * m.modulus * volume / (1.0 - 2.0 * m.ratio);
  const Watched found = watch(world.get(), seconds, watching);
  // From rest a beam under its weight swings to twice its deflection, m g L^3 / (8 E I) and shear, and a free fall is
  // the most that anything does.
  const double i = std::pow(kThickness, 4) / 12.0, mass = m.density * volume;
  const double static_sag = mass * kGravity * std::pow(kLength, 3) / (8.0 * m.modulus * i) +
                            mass * kGravity * kLength / (1.2 * m.modulus * kThickness * kThickness);
  const double reach = world->model().initial.x.colwise().norm().maxCoeff();
  const double allowed = std::min(2.2 * static_sag, 0.5 * kGravity * seconds * (seconds + 0.01));
  worst->further = std::max(worst->further, (found.furthest - reach) / (allowed + 1e-12));
  worst->gain = std::max(worst->gain, found.gain);
  worst->misreported = std::max(worst->misreported, found.misreported);
}

void run_all(const std::string& step, SolidLaw law) {
  Worst worst;
  for (const double ratio : {0.0, 0.3, 0.49, 0.4999})
    for (const double density : {1e-3, 1.0, 1e3, 1e5})
      for (const double modulus : {1e2, 1e4, 1e6, 1e8, 1e10, 1e12})
        run_beam({law, modulus, ratio, density}, step, &worst);
  const std::string what = name_of(law) + ", " + step + ", E 1e2 ... 1e12 Pa, nu 0 ... 0.4999, 1e-3 ... 1e5 kg/m^3: ";
  check("F8", what + "rise of the energy in a step, over all that moves", worst.gain, 0.0, 1e-6, Tolerance::kAbsolute);
  check("F8", what + "reported residual against that of the states", worst.misreported, 0.0, 1e-6,
        Tolerance::kAbsolute);
  EXPECT_LT(worst.further, 1.0) << what;
}

TEST(AnyMaterial, IsSteppedAndReported) {
  // F8. 96 materials; a step is solved, or its residual is reported and, far off, warned of.
  for (const SolidLaw law : {SolidLaw::kStableNeoHookean, SolidLaw::kCorotational}) {
    run_all("integrator: implicit_euler", law);
    run_all("integrator: implicit_euler, linear_solver: direct", law);
  }
}

/// A bar of two halves of 4 cells, from z = 0 down: nodes slice by slice, the middle slice shared. nu = 0.
struct TwoHalves {
  static constexpr int kSlice = 9, kCellsAlong = 4;
  static constexpr double kHalf = 0.2, kDensity = 1000.0;  // m, kg/m^3
  double upper, lower;                                     // Pa

  std::shared_ptr<Model> model() const {
    auto made = std::make_shared<Model>();
    const TetMesh half = make_box(Vec3(0.1, 0.1, kHalf), {2, 2, kCellsAlong});
    const auto n = half.rest.cols(), all = 2 * n - kSlice;
    made->initial.x.resize(3, all);
    made->mass = Eigen::VectorXd::Zero(all);
    for (const Eigen::Index first : {Eigen::Index(0), n - kSlice}) {
      // From the lower end up, so that the upper half comes last.
      made->initial.x.middleCols(first, n) = half.rest.colwise() + Vec3(0, 0, (first == 0 ? -1.5 : -0.5) * kHalf);
      made->mass.segment(first, n) += solid_masses(half, kDensity);
      made->energies.push_back(make_solid(half, solid_material(SolidLaw::kHooke, first == 0 ? lower : upper, 0.0), 0.0,
                                          static_cast<int>(first)));
    }
    made->initial.v = Nodes::Zero(3, all);
    made->energies.push_back(make_gravity(made->mass, made->gravity));
    made->energies.push_back(make_mass_damping(made->mass, 5.0));
    Body body;
    body.name = "bar";
    body.kind = BodyKind::kSoft;
    body.node_count = static_cast<int>(all);
    made->bodies.push_back(body);
    return made;
  }
};

TEST(SoftAndStiff, SagAsSpringsInSeries) {
  // F13. A bar of two halves, a million times stiffer the one than the other, hangs from its upper end. In one
  // dimension the middle sags by (W_lower + W_upper / 2) L / (E_upper A), whichever half is the soft one: 1 %.
  const std::vector<std::pair<std::string, SolverSettings::Linear>> solvers = {
      {"direct", SolverSettings::Linear::kDirect},
      {"cg", SolverSettings::Linear::kConjugateGradient},
      {"multigrid", SolverSettings::Linear::kMultigrid}};
  for (const bool soft_above : {true, false}) {
    const TwoHalves halves{soft_above ? 1e5 : 1e11, soft_above ? 1e11 : 1e5};
    const double expected = 1.5 * TwoHalves::kDensity * kGravity * TwoHalves::kHalf * TwoHalves::kHalf / halves.upper;
    for (const auto& [name, linear] : solvers) {
      const auto model = halves.model();
      const int top = model->node_count() - TwoHalves::kSlice, middle = (model->node_count() - TwoHalves::kSlice) / 2;
      Watching watching;
      for (int i = top; i < model->node_count(); ++i) watching.held.push_back(i);
      WorldSettings settings;
      settings.solver.linear = linear;
      World world(model, settings, {}, {grasp_nodes("clamp", "bar", watching.held)});
      watching.round_off = 1e-15 * 1e11 * 2.0 * TwoHalves::kHalf * 0.01;
      const Watched found = watch(&world, 4.0, watching);
      const std::string what = std::string(soft_above ? "soft" : "stiff") + " half above, " + name;
      const double sag = -(world.state().x - model->initial.x).row(2).segment(middle, TwoHalves::kSlice).mean();
      check("F13", what + ": sag of the middle, m", sag, expected, 0.01);
      check("F13", what + ": rise of the energy in a step, over all that moves", found.gain, 0.0, 1e-6,
            Tolerance::kAbsolute);
      check("F13", what + ": reported residual against that of the states", found.misreported, 0.0, 1e-6,
            Tolerance::kAbsolute);
      if (linear == SolverSettings::Linear::kDirect) EXPECT_EQ(found.unsolved, 0);
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
