// F30, F31: edges exactly parallel, sheets exactly one above the other, bodies in one place, cubes on cubes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/crossings.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

std::unique_ptr<World> world_of(const std::string& step, const std::string& bodies) {
  return build_world(load_scene_text(
      "step: {solver: manual, " + step + "}\nbodies:\n" + bodies + "colliders:\n  - plane: {name: table}\n", "test"));
}

Vec3 middle_of(const World& world, const Body& body) {
  return world.state().x.middleCols(body.first_node, body.node_count).rowwise().mean();
}

double bottom_of(const World& world, const Body& body) {
  return world.state().x.middleCols(body.first_node, body.node_count).row(2).minCoeff();
}

double top_of(const World& world, const Body& body) {
  return world.state().x.middleCols(body.first_node, body.node_count).row(2).maxCoeff();
}

void run(World* world, double seconds) {
  while (world->time() < seconds - 1e-9) {
    const StepOutcome outcome = world->step();
    ASSERT_TRUE(outcome.ok) << outcome.message;
  }
  ASSERT_TRUE(world->state().finite());
}

class DegenerateContact : public testing::TestWithParam<const char*> {
 protected:
  std::string step() const { return std::string("integrator: ") + GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(Schemes, DegenerateContact,
                         testing::Values("implicit_euler", "bdf2, linear_solver: multigrid", "tr_bdf2",
                                         "substepped_verlet"),
                         [](const auto& info) { return std::to_string(info.index); });

std::string sheet(int k, double z) {
  return "  - cloth: {name: sheet_" + std::to_string(k) + ", touches: all, size: [0.2, 0.2], cells: [6, 6], " +
         "contact_radius: 0.001, pose: {position: [0, 0, " + std::to_string(z) +
         "]}, material: {areal_density: 0.3, membrane_stiffness: 300, bending_rigidity: 1.0e-5, damping: 0.0005}}\n";
}

TEST_P(DegenerateContact, SheetsExactlyAboveEachOtherStayInOrder) {
  // F30. Four sheets of 2 mm, 2 mm apart: each edge parallel to those below, all faces in planes, in contact from the
  // start. Contacts of implicit schemes give by a fifth of their distance before a step is made again in parts.
  std::string bodies;
  for (int k = 0; k < 4; ++k) bodies += sheet(k, 0.001 + 0.002 * k);
  const auto world = world_of("dt: 0.01, " + step(), bodies);
  ASSERT_NO_FATAL_FAILURE(run(world.get(), 0.6));
  EXPECT_EQ(count_crossings(world->model(), world->state().x), 0);
  for (size_t k = 1; k < 4; ++k) {
    const Body &low = world->model().bodies[k - 1], &high = world->model().bodies[k];
    check("F30", "distance of coincident sheets on one another, m, " + step() + ", " + std::to_string(k),
          middle_of(*world, high).z() - middle_of(*world, low).z(), 0.002, 0.2);
    // No node below the sheet that was under it.
    EXPECT_GT(bottom_of(*world, high), top_of(*world, low)) << k;
    EXPECT_LT((middle_of(*world, high) - middle_of(*world, low)).head<2>().norm(), 1e-5) << k;
  }
}

TEST_P(DegenerateContact, BodiesInOnePlaceDoNotExplode) {
  // F30. Two sheets in the very same place have no direction between them: refused, or no faster than what falls 2 cm.
  try {
    const auto world = world_of("dt: 0.01, " + step(), sheet(0, 0.02) + sheet(1, 0.02));
    double fastest = 0.0;
    for (int k = 0; k < 40; ++k) {
      ASSERT_TRUE(world->step().ok);
      fastest = std::max(fastest, world->state().v.colwise().norm().maxCoeff());
    }
    EXPECT_LT(fastest, std::sqrt(2.0 * 9.81 * 0.02) + 0.3);  // contacts part at 0.3 m/s at most
  } catch (const InputError& refused) {
    EXPECT_NE(std::string(refused.what()).find("sheet_0"), std::string::npos);
  }
}

TEST(ParallelRopes, LieInAGroove) {
  // F30. Two ropes side by side on a table, d = 1 cm; a third, parallel to them, falls into the groove: its axis comes
  // to rest d sqrt(3) / 2 above theirs. They are pushed apart by no more than friction lets them: the height is
  // sqrt(d^2 - w^2) for the distance 2 w that they have. Contacts give by 2 %.
  for (const char* scheme : {"implicit_euler", "tr_bdf2", "velocity_verlet"}) {
    SCOPED_TRACE(scheme);
    const auto rope = [](const char* name, double y, double z) {
      return std::string("  - rope: {name: ") + name +
             ", touches: all, length: 0.2, segments: 10, friction: 0.5, pose: {position: [0, " + std::to_string(y) +
             ", " + std::to_string(z) +
             "]}, material: {diameter: 0.01, linear_density: 0.05, axial_stiffness: 500, damping: 0.001}}\n";
    };
    const auto world = world_of(std::string("dt: 0.005, integrator: ") + scheme,
                                rope("left", -0.005, 0.005) + rope("right", 0.005, 0.005) + rope("top", 0.0, 0.02));
    ASSERT_NO_FATAL_FAILURE(run(world.get(), 1.0));
    const Vec3 left = middle_of(*world, world->model().bodies[0]), right = middle_of(*world, world->model().bodies[1]),
               top = middle_of(*world, world->model().bodies[2]);
    const double half = 0.5 * (right.y() - left.y());
    EXPECT_NEAR(half, 0.005, 1e-4);
    check("F30", std::string("height of a rope in the groove of two parallel ones, m, ") + scheme, top.z() - left.z(),
          std::sqrt(1e-4 - half * half), 0.02);
    EXPECT_NEAR(top.y(), 0.5 * (left.y() + right.y()), 1e-5);
    EXPECT_LT(world->state().v.colwise().norm().maxCoeff(), 1e-3);
  }
}

TEST(CubeStack, StaysWhereItIs) {
  // F31. Five cubes of 5 cm on one another, 5 s: the columns are symmetric, so nothing drifts, < 1e-4 m.
  for (const char* step :
       {"dt: 0.01, integrator: implicit_euler", "dt: 0.005, integrator: bdf2", "dt: 0.01, integrator: tr_bdf2"}) {
    SCOPED_TRACE(step);
    std::string bodies;
    for (int k = 0; k < 5; ++k) {
      bodies += "  - soft: {name: cube_" + std::to_string(k) +
                ", touches: others, box: {size: [0.05, 0.05, 0.05], cells: [2, 2, 2]}, element: tetrahedron, " +
                "contact_radius: 0.0005, friction: 0.5, material: {youngs_modulus: 1.0e+5, poissons_ratio: 0.3, " +
                "density: 500}, pose: {position: [0, 0, " + std::to_string(0.0255 + 0.051 * k) + "]}}\n";
    }
    const auto world = world_of(step, bodies);
    ASSERT_NO_FATAL_FAILURE(run(world.get(), 1.0));
    std::vector<Vec3> settled;
    for (const Body& body : world->model().bodies) settled.push_back(middle_of(*world, body));
    ASSERT_NO_FATAL_FAILURE(run(world.get(), 5.0));
    double sideways = 0.0, sinking = 0.0;
    for (size_t k = 0; k < settled.size(); ++k) {
      const Vec3 now = middle_of(*world, world->model().bodies[k]);
      sideways = std::max(sideways, now.head<2>().norm());
      sinking = std::max(sinking, std::abs(now.z() - settled[k].z()));
    }
    check("F31", std::string("drift of five cubes sideways, m, ") + step, sideways, 0.0, 1e-4, Tolerance::kAbsolute);
    check("F31", std::string("drift of five cubes up or down from 1 s to 5 s, m, ") + step, sinking, 0.0, 1e-4,
          Tolerance::kAbsolute);
  }
}

}  // namespace
}  // namespace deformable_sim::test
