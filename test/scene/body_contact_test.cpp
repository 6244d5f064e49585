// Sheets, ropes and soft bodies that touch one another and themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/crossings.h"
#include "support/folded_towel.h"

namespace deformable_sim::test {
namespace {

std::unique_ptr<World> world_of(const std::string& yaml) {
  return build_world(load_scene_text(yaml, "s.yaml"));
}

class Folder {
 public:
  explicit Folder(const std::string& solver)
      : world(world_of("step: {" + solver + R"(}
bodies:
  - cloth:
      name: towel
      touches: all
      contact_radius: 0.0015
      friction: 0.6
      size: [0.4, 0.4]
      cells: [16, 16]
      pose: {position: [0, 0, 0.002]}
      material: {areal_density: 0.3, membrane_stiffness: 300, poissons_ratio: 0.2, bending_rigidity: 5e-6}
colliders:
  - plane: {name: table}
)")) {}

  void run(double seconds) {
    const int steps = static_cast<int>(std::lround(seconds / world->settings().dt));
    for (int k = 0; k < steps; ++k) {
      const StepOutcome outcome = world->step();
      ASSERT_TRUE(outcome.ok) << outcome.message;
      if (k % 20 == 0) ASSERT_EQ(count_crossings(world->model(), world->state().x), 0) << world->time();
    }
  }
  /// Turns the nodes by half a turn about the line through `pivot` along `axis`.
  void fold(const std::vector<int>& nodes, const Vec3& pivot, const Vec3& axis) {
    command::Grasp grasp;
    grasp.request.name = "hand";
    grasp.request.body = "towel";
    grasp.request.selection.method = SelectionMethod::kNodes;
    grasp.request.has_frame = true;
    grasp.request.selection.nodes = nodes;
    ASSERT_EQ(world->apply(grasp).status.code, Code::kOk);
    constexpr int kParts = 60;  // of 0.02 s
    for (int k = 1; k <= kParts; ++k) {
      const Eigen::AngleAxisd turn(0.5 * M_PI * (1.0 - std::cos(M_PI * k / kParts)), axis);
      const Pose about = Eigen::Translation3d(pivot) * turn * Eigen::Translation3d(-pivot);
      world->apply(command::MoveGrasp{"hand", about, 0.02});
      run(0.02);
    }
    world->apply(command::Release{"hand"});
    run(1.5);
  }
  std::unique_ptr<World> world;
};

class FoldedTwice : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(BodyContact, FoldedTwice,
                         testing::Values("integrator: implicit_euler, dt: 0.005",
                                         "integrator: tr_bdf2, linear_solver: multigrid, dt: 0.01",
                                         "integrator: substepped_verlet, dt: 0.01", "accuracy: engineering"),
                         [](const auto& info) { return std::to_string(info.index); });

TEST_P(FoldedTwice, ATowelKeepsFourLayersInOrder) {
  // The four quarters lie on one another as they were laid down, and lie still.
  Folder f(GetParam());
  ASSERT_NO_FATAL_FAILURE(f.fold({16 * 17, 16 * 17 + 8, 16 * 17 + 16}, Vec3(0, 0, 0.005), Vec3::UnitX()));
  ASSERT_NO_FATAL_FAILURE(f.fold({16, 4 * 17 + 16, 12 * 17 + 16, 16 * 17 + 16}, Vec3(0, 0, 0.009), -Vec3::UnitY()));
  const Nodes& x = f.world->state().x;
  int whole = 0;
  for (double px = -0.25; px < 0.1; px += 0.013) {
    for (double py = -0.3; py < 0.1; py += 0.013) {
      const std::vector<int> quarters = quarters_at(f.world->model(), x, px, py);
      EXPECT_TRUE(std::is_sorted(quarters.begin(), quarters.end())) << px << ", " << py;
      whole += quarters == std::vector<int>{0, 1, 2, 3} ? 1 : 0;
    }
  }
  EXPECT_GE(whole, 20);  // points 13 mm apart: 34 cm^2 or more of four layers
  EXPECT_LT(f.world->snapshot().bodies[0].kinetic_energy, 1e-5);
  // Where the two creases cross, four layers bend twice within a cell: within three cells of there, and nowhere else, a
  // thread that friction holds around them may be stretched further.
  const Nodes& rest = f.world->model().bodies[0].surface->rest;
  for (const StrainEdge& e : f.world->model().bodies[0].strain_edges) {
    if (rest.col(e.node[0]).cwiseAbs().maxCoeff() < 0.08) continue;
    EXPECT_LT((x.col(e.node[0]) - x.col(e.node[1])).norm(), 1.04 * e.rest_length) << e.node[0];
  }
}

TEST(BodyContact, NothingCrossesAtAnySpeed) {
  // Sheets, ropes and a soft body thrown at one another at up to 60 m/s, a metre a step: every edge against every
  // triangle after every step, every rope against every other within it. Beyond 20 m/s, torn to twice their size, a
  // world may come to its end of parts and stay where it was.
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const char* const kSchemes[] = {"integrator: implicit_euler", "integrator: tr_bdf2, linear_solver: multigrid",
                                  "integrator: substepped_verlet", "integrator: implicit_euler, linear_solver: direct",
                                  "integrator: bdf2"};
  for (int trial = 0; trial < 5; ++trial) {
    const std::string scheme = kSchemes[trial % 5];
    SCOPED_TRACE(std::to_string(trial) + " " + scheme);
    const auto world = world_of("step: {" + scheme + R"(, dt: 0.0166666667}
bodies:
  - cloth: {name: a, touches: all, size: [0.3, 0.3], cells: [5, 5]}
  - cloth: {name: b, touches: all, size: [0.3, 0.3], cells: [5, 5], pose: {position: [0, 0, 0.2], rpy: [0.3, 0.1, 0]}}
  - rope: {name: c, touches: all, length: 0.5, segments: 12, pose: {position: [0, 0.02, 0.1], rpy: [0, 0.1, 0.4]}}
  - rope: {name: d, touches: all, length: 0.5, segments: 12, pose: {position: [0, 0, -0.1], rpy: [0, -0.1, 1.9]}}
  - soft: {name: e, touches: all, box: {size: [0.1, 0.1, 0.1], cells: [2, 2, 2]}, pose: {position: [0, 0, 0.4]}}
)");
    const double fastest = trial % 2 == 0 ? 20.0 : 60.0;
    for (const Body& body : world->model().bodies) {
      command::SetBodyState set;
      set.body = body.name;
      set.x = world->state().x.middleCols(body.first_node, body.node_count);
      const Vec3 toward = -set.x.rowwise().mean() + 0.1 * Vec3(unit(generator), unit(generator), unit(generator));
      set.v = (fastest * toward.normalized()).replicate(1, body.node_count);
      for (Eigen::Index i = 0; i < set.v.size(); ++i) set.v.data()[i] += 0.1 * fastest * unit(generator);
      ASSERT_EQ(world->apply(set).status.code, Code::kOk);
    }
    for (int k = 0; k < 6; ++k) {
      const Nodes before = world->state().x;
      const StepOutcome outcome = world->step();
      if (fastest < 21.0) ASSERT_TRUE(outcome.ok) << outcome.message;
      ASSERT_EQ(count_crossings(world->model(), world->state().x), 0) << "step " << k << " at " << fastest << " m/s";
      if (world->snapshot().substeps == 1) {
        ASSERT_EQ(count_passages(world->model(), before, world->state().x), 0) << "step " << k;
      }
    }
  }
}

TEST(BodyContact, AnOverhandKnotTightensAndHolds) {
  // 0.85 m of rope with a knot in it, its ends drawn 0.72 m apart: a rope without a knot would hang loose, this one
  // pulls, and still does half a second later. No segment has passed through another.
  const auto world = world_of(R"(step: {integrator: implicit_euler, dt: 0.004}
gravity: [0, 0, 0]
bodies:
  - rope:
      name: rope
      touches: all
      segments: 60
      path: [[-0.2, 0, 0], [-0.04, 0, 0], [0.06, 0.03, 0.012], [0.04, 0.08, 0], [-0.04, 0.08, -0.012],
             [-0.05, 0.03, 0.012], [0.0, 0.0, 0.024], [0.02, 0.03, -0.014], [0.04, 0.06, 0.03], [0.24, 0.06, 0.0]]
      material: {diameter: 0.008, linear_density: 0.05, axial_stiffness: 2000}
      friction: 0.5
      pins: [end_0, end_1]
)");
  const Nodes start = world->state().x;
  Nodes before = start;
  for (int k = 0; k < 475; ++k) {
    if (k % 25 == 0 && k < 350) {
      for (const int end : {0, 1}) {
        Pose target = Pose::Identity();
        target.translation() = start.col(60 * end) + Vec3((end == 1 ? 1.0 : -1.0) * 0.01 * (k / 25 + 1), 0, 0);
        world->apply(command::MoveGrasp{"pin_rope_end_" + std::to_string(end), target, 0.1});
      }
    }
    ASSERT_TRUE(world->step().ok);
    ASSERT_EQ(count_passages(world->model(), before, world->state().x), 0) << world->time();
    before = world->state().x;
    const Snapshot shot = world->snapshot();
    EXPECT_LT(shot.bodies[0].max_strain, 0.03) << world->time();
    if (k >= 350) EXPECT_GT(shot.grasps[0].force.norm(), 3.0) << world->time();
  }
  EXPECT_GT((before.col(60) - before.col(0)).norm(), 0.71);
}

std::string refusal(const std::string& yaml) {
  try {
    world_of(yaml);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(BodyContact, RefusesWhatCrossesAtTheStartAndPathsThatAreNone) {
  const std::string rope = "bodies:\n  - rope: {name: a, touches: all, ";
  EXPECT_EQ(refusal(R"(bodies:
  - cloth: {name: a, touches: others, cells: [4, 4], pose: {position: [0.01, 0.02, 0]}}
  - cloth: {name: b, touches: others, cells: [4, 4], pose: {rpy: [1.2, 0.1, 0]}}
)")
                .find("s.yaml:3: bodies[1]: 'a' and 'b' cross near ("),
            0u);
  EXPECT_EQ(refusal("bodies:\n  - cloth: {name: a, touches: some}\n").find("s.yaml:2: bodies[0].cloth.touches"), 0u);
  EXPECT_EQ(refusal(rope + "path: [[0, 0, 0]]}\n").find("s.yaml:2: bodies[0].rope.path: needs two points"), 0u);
  EXPECT_EQ(refusal(rope + "path: [[0, 0, 0], [1, 0, 0], [1, 0, 0]]}\n").find("s.yaml:2: bodies[0].rope.path[2]"), 0u);
  EXPECT_EQ(refusal(rope + "model: rod, path: [[0, 0, 0], [1, 0, 0]]}\n").find("s.yaml:2: bodies[0].rope.path"), 0u);
  EXPECT_NE(refusal(rope + "length: 2, path: [[0, 0, 0], [1, 0, 0]]}\n"), "");
  EXPECT_EQ(refusal(rope + "path: [[0, 0, 0], [1, 0, 0]]}\n"), "");
}

TEST(BodyContact, LaysARopeAlongItsPath) {
  // 1 m along x, then 1 m up: nodes every quarter metre.
  const auto world = world_of("bodies:\n  - rope: {name: a, segments: 8, path: [[0, 0, 0], [1, 0, 0], [1, 0, 1]]}\n");
  for (int i = 0; i < 9; ++i) {
    const Vec3 expected(std::min(0.25 * i, 1.0), 0.0, std::max(0.0, 0.25 * i - 1.0));
    EXPECT_LT((world->state().x.col(i) - expected).norm(), 1e-12) << i;
  }
  EXPECT_LT(std::abs(world->snapshot().bodies[0].max_strain), 1e-12);
}

}  // namespace
}  // namespace deformable_sim::test
