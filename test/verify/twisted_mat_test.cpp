// F17: a mat twisted into a strand at long steps, and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/crossings.h"
#include "support/small_worlds.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kStep = 0.04;                 // s
constexpr double kRate = 72.0 * M_PI / 180.0;  // rad/s, of either end
constexpr int kAlong = 16, kAcross = 8;        // cells

class TwistedMat : public testing::TestWithParam<const char*> {
 protected:
  void hold_ends() {
    for (const bool left : {true, false}) {
      std::vector<int> nodes;
      for (int j = 0; j <= kAcross; ++j) nodes.push_back((kAlong + 1) * j + (left ? 0 : kAlong));
      command::Grasp grasp;
      grasp.request = grasp_nodes(left ? "left" : "right", "mat", nodes);
      grasp.request.has_frame = true;
      grasp.request.max_speed = 5.0;
      ASSERT_TRUE(world_->apply(grasp).status.ok());
    }
  }
  void turn_ends(double angle) {
    for (const bool left : {true, false}) {
      const Pose turn = at(0, 0, 0, left ? angle : -angle, Vec3::UnitX());
      ASSERT_TRUE(world_->apply(command::MoveGrasp{left ? "left" : "right", turn, kStep}).status.ok());
    }
    const StepOutcome outcome = world_->step();
    ASSERT_TRUE(outcome.ok) << outcome.message;
    ASSERT_TRUE(world_->state().finite());
  }
  double area() const {
    double sum = 0.0;
    const Nodes& x = world_->state().x;
    for (const auto& t : world_->model().bodies[0].surface->triangles)
      sum += 0.5 * Vec3(x.col(t[1]) - x.col(t[0])).cross(Vec3(x.col(t[2]) - x.col(t[0]))).norm();
    return sum;
  }
  std::unique_ptr<World> world_;
};

INSTANTIATE_TEST_SUITE_P(Schemes, TwistedMat, testing::Values("implicit_euler", "tr_bdf2, linear_solver: multigrid"),
                         [](const auto& info) { return std::to_string(info.index); });

TEST_P(TwistedMat, NeverCrossesItselfAndLiesFlatAgain) {
  // Ends 0.4 m apart turn against each other by 72 degrees a second, at h = 0.04 s, until they are two turns apart,
  // then back. No edge is ever in a face; at the end the area is that of the start within 1 %, for nothing is left but
  // what the last vibrations stretch.
  world_ =
      build_world(load_scene_text(std::string("gravity: [0, 0, 0]\nair: {damping: 2}\nstep: {solver: manual, dt: ") +
                                      std::to_string(kStep) + ", integrator: " + GetParam() + R"(}
bodies:
  - cloth: {name: mat, touches: all, size: [0.4, 0.2], cells: [16, 8], contact_radius: 0.001, friction: 0.3,
            bending: quadratic, material: {areal_density: 0.3, membrane_stiffness: 500, bending_rigidity: 1.0e-5}}
)",
                                  "test"));
  ASSERT_NO_FATAL_FAILURE(hold_ends());
  const double flat = area();
  const int steps = static_cast<int>(std::lround(2.0 * M_PI / kRate / kStep));
  double thinnest = 1.0;
  for (int k = 1; k <= 2 * steps + 25; ++k) {
    ASSERT_NO_FATAL_FAILURE(turn_ends(kRate * kStep * std::max(0, k <= steps ? k : 2 * steps - k)));
    EXPECT_EQ(count_crossings(world_->model(), world_->state().x), 0) << k;
    if (k != steps) continue;
    const Nodes& x = world_->state().x;
    for (int j = 0; j <= kAcross; ++j) {
      const auto node = static_cast<Eigen::Index>((kAlong + 1) * j + kAlong / 2);
      thinnest = j == 0 ? x.col(node).tail<2>().norm() : std::max(thinnest, x.col(node).tail<2>().norm());
    }
  }
  EXPECT_LT(thinnest, 0.05);  // m, half the width in the middle, 0.1 when flat: it was a strand
  check("F17", std::string("area of a mat twisted by two turns and back over that before, ") + GetParam(),
        area() / flat, 1.0, 0.01);
}

}  // namespace
}  // namespace deformable_sim::test
