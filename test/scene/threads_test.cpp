// The bits of a result do not depend on the number of threads.
#include <algorithm>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/four_threads.h"

namespace deformable_sim {
namespace {

struct Case {
  const char* name;
  std::string step, bodies, rest;
  int steps;

  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.step << "\n" << c.bodies << c.rest; }
};

std::string sheet(const char* name, int nodes_x, int nodes_y, const std::string& more) {
  return std::string("  - cloth: {name: ") + name + ", size: [1.0, 0.9], cells: [" + std::to_string(nodes_x - 1) +
         ", " + std::to_string(nodes_y - 1) + "], " + more + "}\n";
}

const char* const kHanging = "pose: {position: [0, 0, 1.5], rpy: [1.5, 0, 0.1]}, pins: [corner_2, corner_3]";
const char* const kLying = "pose: {position: [0.02, 0.01, 0.26]}";
const char* const kBall = "colliders:\n  - sphere: {name: ball, radius: 0.25}\n";

std::vector<Case> cases() {
  const std::string hanging = sheet("sheet", 61, 75, kHanging), lying = sheet("sheet", 61, 75, kLying);
  const std::string explicit_double = "integrator: substepped_verlet, dt: 0.005",
                    explicit_single = explicit_double + ", precision: single",
                    bdf2 = "integrator: bdf2, linear_solver: multigrid, dt: 0.01",
                    tr_bdf2 = "integrator: tr_bdf2, linear_solver: multigrid, dt: 0.01";
  const std::string two_sheets =
      sheet("large", 61, 75, kHanging) +
      sheet("small", 21, 25, "pose: {position: [2, 0, 1.5], rpy: [1.5, 0, 0]}, pins: [corner_2]");
  const auto rope = [](const char* name, int segments) {
    return std::string("  - rope: {name: ") + name + ", length: 1.0, segments: " + std::to_string(segments) +
           ", pose: {position: [-1, 0, 1]}, pins: [end_0]}\n";
  };
  return {
      {"explicit_double", explicit_double, hanging, "", 20},
      {"explicit_single", explicit_single, hanging, "", 20},
      {"explicit_contact", explicit_single, lying, kBall, 20},
      {"bdf2", bdf2, hanging, "", 20},
      {"tr_bdf2", tr_bdf2, hanging, "", 10},
      {"large_tr_bdf2", tr_bdf2, sheet("sheet", 121, 115, kHanging), "", 4},
      {"implicit_contact", bdf2, lying, kBall, 12},
      {"two_sheets_and_a_rope", explicit_double, two_sheets + rope("rope", 20), "", 2},
      {"two_sheets_implicit", tr_bdf2, two_sheets, "", 10},
      {"ropes", "integrator: bdf2, dt: 0.005, jacobian: lagged, linear_solver: banded",
       rope("a", 300) + rope("b", 200) + rope("c", 400), "", 30},
      {"mesh", "integrator: implicit_euler, dt: 0.01",
       "  - cloth: {name: sheet, size: [0.5, 0.5], cells: [20, 20], bending: hinges, material: {bending_rigidity: "
       "1.0e-5}, pose: {position: [0, 0, 0.26]}}\n",
       kBall, 8},
  };
}

class ThreadsOf : public testing::TestWithParam<Case> {
 protected:
  std::unique_ptr<World> run(int threads) const {
    const Case& c = GetParam();
    std::unique_ptr<World> world = build_world(
        load_scene_text("step: {solver: manual, " + c.step + "}\nair: {damping: 1}\nbodies:\n" + c.bodies + c.rest,
                        "test"),
        threads);
    for (int k = 0; k < c.steps; ++k) EXPECT_TRUE(world->step().ok);
    return world;
  }
  test::FourThreads allowed_;
};

TEST_P(ThreadsOf, MoveToTheSameBits) {
  // x and v of every node after many steps, 2 ... 4 threads against one: equal, not near.
  const std::unique_ptr<World> one = run(1);
  for (int threads : {2, 3, 4}) {
    const std::unique_ptr<World> some = run(threads);
    EXPECT_TRUE((some->state().x.array() == one->state().x.array()).all()) << threads << " threads";
    EXPECT_TRUE((some->state().v.array() == one->state().v.array()).all()) << threads << " threads";
  }
}
INSTANTIATE_TEST_SUITE_P(, ThreadsOf, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

class ThreadsOfTouching : public testing::TestWithParam<const char*> {};

TEST_P(ThreadsOfTouching, BodiesMoveThemToTheSameBits) {
  // Positions, velocities and forces of contact where sheets lie on one another and a rope on them.
  const test::FourThreads allowed;
  const std::string bodies =
      sheet("low", 61, 75, "touches: all, material: {damping: 0}, pose: {position: [0.02, 0.01, 0.2515]}") +
      sheet("high", 31, 37,
            "touches: all, material: {damping: 0}, pose: {position: [0.1, 0.03, 0.2537], rpy: [0, 0, 0.3]}") +
      "  - rope: {name: rope, touches: all, length: 0.8, segments: 60, pose: {position: [0, 0, 0.2589]}, material: "
      "{diameter: 0.008, linear_density: 0.05, axial_stiffness: 1000, damping: 0}}\n";
  const auto run = [&](int threads) {
    auto world = build_world(
        load_scene_text(std::string("step: {solver: manual, ") + GetParam() + "}\nbodies:\n" + bodies + kBall, "test"),
        threads);
    while (world->time() < 0.0199) EXPECT_TRUE(world->step().ok);
    return world;
  };
  const std::unique_ptr<World> one = run(1);
  const std::vector<ContactReport> forces = one->contact_reports();
  const auto with_rope = [](const ContactReport& r) { return r.other == 2 || (r.other >= 0 && r.body == 2); };
  const auto of_sheets = [](const ContactReport& r) { return r.other == 1 && r.body == 0; };
  ASSERT_TRUE(std::any_of(forces.begin(), forces.end(), with_rope));
  ASSERT_TRUE(std::any_of(forces.begin(), forces.end(), of_sheets));
  const std::unique_ptr<World> four = run(4);
  EXPECT_TRUE((four->state().x.array() == one->state().x.array()).all());
  EXPECT_TRUE((four->state().v.array() == one->state().v.array()).all());
  const std::vector<ContactReport> same = four->contact_reports();
  ASSERT_EQ(same.size(), forces.size());
  for (size_t k = 0; k < forces.size(); ++k) EXPECT_EQ(same[k].force, forces[k].force) << k;
}
INSTANTIATE_TEST_SUITE_P(, ThreadsOfTouching,
                         testing::Values("integrator: bdf2, linear_solver: multigrid, dt: 0.01",
                                         "integrator: substepped_verlet, dt: 0.01"),
                         [](const auto& info) { return std::to_string(info.index); });

std::string scheme_detail(const std::string& bodies, int threads) {
  const std::unique_ptr<World> world = build_world(
      load_scene_text("step: {solver: manual, integrator: bdf2, linear_solver: multigrid}\nbodies:\n" + bodies, "test"),
      threads);
  EXPECT_TRUE(world->step().ok);
  for (const BillItem& item : world->bill()) {
    if (item.part == "bdf2") return item.detail;
  }
  return "no line";
}

TEST(Threads, AreNamedInTheBillWithWhatTheyFoundToDo) {
  // A sheet that is large enough, one that is not, and one thread.
  const test::FourThreads allowed;
  EXPECT_EQ(scheme_detail(sheet("large", 61, 75, kHanging), 3), "4575 nodes, on 3 threads");
  EXPECT_EQ(scheme_detail(sheet("small", 11, 9, kHanging), 3), "99 nodes, on 1 of 3 threads: nothing to share");
  EXPECT_EQ(scheme_detail(sheet("small", 11, 9, kHanging), 1), "99 nodes");
}

TEST(Threads, AreRefusedOutsideTheirRange) {
  // 1 ... 64.
  const SceneSpec scene = load_scene_text("bodies:\n" + sheet("small", 11, 9, kHanging), "test");
  for (int threads : {0, 65}) EXPECT_THROW(build_world(scene, threads), InputError);
}

}  // namespace
}  // namespace deformable_sim
