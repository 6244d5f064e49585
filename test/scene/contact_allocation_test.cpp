// A warm step of bodies that touch takes no memory from the heap.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/count_allocations.h"

namespace deformable_sim::test {
namespace {

constexpr int kWarmSteps = 80, kSteps = 40;  // of 0.01 s

std::string sheet(const char* name, const char* pose) {
  return std::string("  - cloth: {name: ") + name + ", touches: all, size: [0.3, 0.3], cells: [10, 10], pose: {" +
         pose +
         "}, contact_radius: 0.0015, bending: quadratic, material: {areal_density: 0.3, membrane_stiffness: 300, "
         "bending_rigidity: 1.0e-5, damping: 0.0005}}\n";
}

/// On itself: a sheet that stands on its edge falls into folds. On another: one falls on another. Rope on cloth.
std::vector<std::pair<std::string, std::string>> scenes() {
  const std::string low = sheet("low", "position: [0, 0, 0.003]");
  return {
      {"itself", sheet("sheet", "position: [0, 0, 0.16], rpy: [1.5, 0, 0.2]")},
      {"another", low + sheet("high", "position: [0.05, 0.03, 0.06], rpy: [0.3, 0.1, 0.4]")},
      {"rope", low + "  - rope: {name: rope, touches: all, length: 0.4, segments: 40, pose: {position: [0, 0, 0.03], "
                     "rpy: [0, 0.1, 0.3]}, material: {diameter: 0.006, linear_density: 0.05, axial_stiffness: 500, "
                     "bend_stiffness: 1, damping: 0.0002}}\n"}};
}

class WarmContact : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Schemes, WarmContact,
                         testing::Values("integrator: implicit_euler", "integrator: bdf2, linear_solver: multigrid",
                                         "integrator: tr_bdf2", "integrator: substepped_verlet"),
                         [](const auto& info) { return std::to_string(info.index); });

TEST_P(WarmContact, BetweenBodiesAllocatesNothing) {
  // Bodies that have met go on moving on one another: contacts come and go.
  for (const auto& [name, bodies] : scenes()) {
    const auto world =
        build_world(load_scene_text("step: {solver: manual, dt: 0.01, " + std::string(GetParam()) + "}\nbodies:\n" +
                                        bodies + "colliders:\n  - plane: {name: floor}\n",
                                    "test"));
    for (int k = 0; k < kWarmSteps; ++k) ASSERT_TRUE(world->step().ok);
    const long taken = count_allocations([&] {
      for (int k = 0; k < kSteps; ++k) world->step();
    });
    EXPECT_EQ(taken, 0) << name;
    const auto reports = world->contact_reports();
    EXPECT_TRUE(std::any_of(reports.begin(), reports.end(), [](const auto& r) { return r.other >= 0; })) << name;
  }
}

}  // namespace
}  // namespace deformable_sim::test
