// F39, F40, F42 for every scheme: falling keeps the shape, rest stays rest, no direction is preferred; and F37: a run
// made again is the same to the last bit. What energies alone can show is in *_null_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/four_threads.h"
#include "support/small_worlds.h"
#include "support/system.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

Mat3 some_turn() {
  return Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
}

/// A damped sheet of springs that bends, 0.3 m x 0.25 m, turned.
std::unique_ptr<System> damped_sheet(const Mat3& turn) {
  const TriangleMesh mesh = make_grid(0.3, 0.25, 4, 3);
  SheetStiffness stiffness;
  stiffness.membrane = 50.0;
  stiffness.bend = 0.05;
  stiffness.damping_time = 2e-3;
  auto sheet = std::make_unique<System>(turn * mesh.rest, sheet_masses(mesh, 0.15));
  sheet->add_springs(sheet_network(mesh, stiffness));
  return sheet;
}

/// Sweeps of schemes that make all of them.
SolverSettings settings_of(const std::string& scheme, int sweeps = 300) {
  SolverSettings settings = exact_settings(1e-11);
  if (takes_known_terms_only(scheme)) settings.newton_iterations = sweeps;
  return settings;
}

/// Steps that the scheme takes of a sheet as it is: a third of the limit of an explicit one, else 2 ms.
double step_of(const std::string& scheme, const System& sheet) {
  const double limit = make_integrator(scheme, {})->stability_limit(0.3);
  if (std::isinf(limit) || scheme == "substepped_verlet") return 2e-3;
  return 0.3 / highest_frequency(sheet.dynamics, sheet.state);
}

class SchemeNull : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, SchemeNull, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(SchemeNull, EveryNodeOfADampedSheetFallsAsTheSchemeDoes) {
  // F39: after n steps of h every node has fallen by g h^2 n (n + s) / 2, to 1e-10 m: s = 1 for the first order schemes
  // whose position takes the new velocity, -1 where it takes the old one, 0 for those that are exact for a constant
  // acceleration.
  const auto sheet = damped_sheet(some_turn());
  const Nodes start = sheet->state.x;
  sheet->add_gravity();
  const std::string& name = GetParam();
  const auto integrator = make_integrator(name, settings_of(name));
  const double dt = step_of(name, *sheet);
  const int steps = 100;
  for (int k = 0; k < steps; ++k) sheet->step(*integrator, dt);
  const bool first_order = integrator->order() == 1;
  const double s = !first_order ? 0.0 : name == "explicit_euler" ? -1.0 : 1.0;
  Nodes expected = start;
  expected.row(2).array() -= 0.5 * kGravity * dt * dt * steps * (steps + s);
  check("F39", "sheet, " + name + ", distance from its free fall, m", (sheet->state.x - expected).cwiseAbs().maxCoeff(),
        0.0, 1e-10, Tolerance::kAbsolute);
}

TEST_P(SchemeNull, ASheetAtRestStaysWhereItIs) {
  // F40: without gravity nothing moves by 1e-12 m, in 3000 steps (1e6 in the whole set).
  const int steps = verify_all() ? 1000000 : 3000;
  const auto sheet = damped_sheet(some_turn());
  const Nodes start = sheet->state.x;
  const auto integrator = make_integrator(GetParam(), settings_of(GetParam(), 10));
  const double dt = step_of(GetParam(), *sheet);
  for (int k = 0; k < steps; ++k) sheet->step(*integrator, dt);
  check("F40", "sheet, " + GetParam() + ", distance from rest after " + std::to_string(steps) + " steps, m",
        (sheet->state.x - start).cwiseAbs().maxCoeff(), 0.0, 1e-12, Tolerance::kAbsolute);
}

TEST_P(SchemeNull, ASheetMovesTheSameInATurnedFrame) {
  // F42: a sheet held by a node, bent, spinning and falling, is R times itself under R g, to 1e-6 m after 0.1 s.
  const auto play = [this](const Mat3& turn) {
    auto sheet = damped_sheet(turn);
    sheet->add(make_gravity(sheet->mass, turn * Vec3(0, 0, -kGravity))).hold(0);
    for (Eigen::Index i = 1; i < sheet->state.x.cols(); ++i)
      sheet->state.v.col(i) =
          turn * Vec3(0.3 * std::sin(3.0 * static_cast<double>(i)), 0.2, std::cos(5.0 * static_cast<double>(i)));
    const auto integrator = make_integrator(GetParam(), settings_of(GetParam()));
    const double dt = step_of(GetParam(), *damped_sheet(Mat3::Identity()));
    for (int k = 0; k * dt < 0.1; ++k) sheet->step(*integrator, dt);
    return Nodes(turn.transpose() * sheet->state.x);
  };
  const Nodes upright = play(Mat3::Identity()), turned = play(some_turn());
  EXPECT_GT((upright - damped_sheet(Mat3::Identity())->state.x).cwiseAbs().maxCoeff(), 0.01);
  check("F42", "sheet, " + GetParam() + ", difference of turned motions, m", (upright - turned).cwiseAbs().maxCoeff(),
        0.0, 1e-6, Tolerance::kAbsolute);
}

TEST_P(SchemeNull, ARunMadeAgainIsTheSameToTheLastBit) {
  // F37: a sheet large enough to be shared out falls over a ball while a hand draws at its corner: twice on one thread,
  // once on two, compared at every step.
  const FourThreads allowed;
  const auto make = [this](int threads) {
    auto world = build_world(
        load_scene_text("air: {damping: 1}\nstep: {solver: manual, dt: 0.005, integrator: " + GetParam() +
                            "}\nbodies:\n"
                            "  - cloth: {name: towel, size: [0.6, 0.6], cells: [40, 40], bending: quadratic,\n"
                            "            pose: {position: [0.01, 0.02, 0.105]}, material: {areal_density: 0.3,\n"
                            "            membrane_stiffness: 100, bending_rigidity: 1.0e-5}}\n"
                            "colliders:\n  - sphere: {name: ball, radius: 0.1}\n",
                        "again.yaml"),
        threads);
    EXPECT_TRUE(world->apply(command::Grasp{grasp_nodes("hand", "towel", {0, 1})}).status.ok());
    EXPECT_TRUE(world->apply(command::MoveGrasp{"hand", at(-0.4, -0.3, 0.2), 0.05}).status.ok());
    return world;
  };
  const auto once = make(1), again = make(1), shared = make(2);
  for (int k = 0; k < 12; ++k) {
    for (World* world : {once.get(), again.get(), shared.get()}) ASSERT_TRUE(world->step().ok);
    ASSERT_TRUE(same_state(once->state(), again->state())) << "step " << k;
    ASSERT_TRUE(same_state(once->state(), shared->state())) << "two threads, step " << k;
  }
  EXPECT_GT((once->state().x - once->model().initial.x).cwiseAbs().maxCoeff(), 0.01);
}

}  // namespace
}  // namespace deformable_sim::test
