// Trajectories of grasps, and copies of worlds on which they are tried.
#include "deformable_sim/scene/rollout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/trajectory_follower.h"

namespace deformable_sim {
namespace {

Pose at(double x, double y, double z, double angle = 0.0) {
  Pose pose = Pose::Identity();
  pose.translate(Vec3(x, y, z));
  pose.rotate(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
  return pose;
}

const char* kTowel = R"(step: {integrator: symplectic_euler, dt: 0.001}
bodies:
  - cloth: {name: towel, size: [0.2, 0.2], cells: [5, 5], pose: {position: [0, 0, 0.5]}, material: {damping: 0.0005}}
grasps:
  - {name: left, body: towel, select: {feature: corner_0}}
  - {name: right, body: towel, select: {feature: corner_1}}
air: {damping: 2}
)";

SceneSpec towel() {
  return load_scene_text(kTowel, "s.yaml");
}

Pose where(const World& world, const std::string& grasp) {
  const std::vector<GraspReport> grasps = world.grasp_reports();
  return find_held(grasps, grasp)->world_from_grasp;
}

TEST(TrajectoryPlayers, GoStraightAndTurnEvenly) {
  const TrajectoryPlayer player({"left", {{1.0, at(1, 0, 0, 1.0)}, {3.0, at(1, 2, 0, 2.0)}}}, 10.0, at(0, 0, 0));
  EXPECT_TRUE(player.desired(9.0).isApprox(at(0, 0, 0)));
  EXPECT_TRUE(player.desired(10.5).isApprox(at(0.5, 0, 0, 0.5), 1e-12));
  EXPECT_TRUE(player.desired(11.5).isApprox(at(1, 0.5, 0, 1.25), 1e-12));
  EXPECT_TRUE(player.desired(99.0).isApprox(at(1, 2, 0, 2.0), 1e-12));
  EXPECT_EQ(player.end(), 13.0);
}

TEST(TrajectoryPlayers, RefuseTimesThatDoNotAscend) {
  for (const std::vector<double>& times : std::vector<std::vector<double>>{{}, {-0.1}, {0.5, 0.5}, {1.0, 0.5}, {NAN}}) {
    GraspTrajectory trajectory{"left", {}};
    for (const double time : times) trajectory.points.push_back({time, at(0, 0, 0)});
    EXPECT_THROW(check_trajectory(trajectory), InputError);
  }
  EXPECT_NO_THROW(check_trajectory({"left", {{0.0, at(0, 0, 0)}}}));
}

/// Waypoints whose times are no multiples of the step.
TEST(TrajectoryFollowers, MeetEveryPoseAtTheEndsOfSteps) {
  const auto world = build_world(towel());
  const Pose start = where(*world, "left");
  const Vec3 p = start.translation();
  TrajectoryGoal goal;
  goal.trajectories = {{"left", {{0.0505, at(p.x() + 0.01, p.y(), p.z())}, {0.1003, at(p.x(), p.y(), p.z() + 0.02)}}}};
  const TrajectoryPlayer expected(goal.trajectories[0], 0.0, start);
  TrajectoryFollower follower(goal, *world);
  int steps = 0;
  for (; !follower.progress().is_over && steps < 1000; ++steps) {
    follower.before_step(world.get());
    ASSERT_TRUE(world->step().ok);
    follower.after_step(world.get());
    EXPECT_LT((where(*world, "left").translation() - expected.desired(world->time()).translation()).norm(), 1e-12);
  }
  EXPECT_EQ(steps, 101);
  EXPECT_TRUE(follower.progress().status.ok()) << follower.progress().status.message;
  EXPECT_EQ(follower.progress().grasps[0].outcome, TrajectoryOutcome::kReached);
  EXPECT_LT(follower.progress().grasps[0].position_error, 1e-12);
}

TrajectoryGoal both_up(double seconds, double height) {
  TrajectoryGoal goal;
  goal.trajectories = {{"left", {{seconds, at(-0.1, -0.1, 0.5 + height)}}},
                       {"right", {{seconds, at(0.1, -0.1, 0.5 + height)}}}};
  return goal;
}

TrajectoryProgress follow(const TrajectoryGoal& goal, World* world, const std::function<void(int)>& meanwhile) {
  TrajectoryFollower follower(goal, *world);
  for (int k = 0; k < 5000 && !follower.progress().is_over; ++k) {
    meanwhile(k);
    follower.before_step(world);
    EXPECT_TRUE(world->step().ok);
    follower.after_step(world);
  }
  return follower.progress();
}

TEST(TrajectoryFollowers, StopAllWhenOneIsLost) {
  const auto world = build_world(towel());
  const auto progress = follow(both_up(0.2, 0.1), world.get(), [&](int k) {
    if (k == 100) world->apply(command::Release{"right"});
  });
  EXPECT_EQ(progress.status.code, Code::kUnavailable);
  EXPECT_NE(progress.status.message.find("'right' was lost"), std::string::npos);
  EXPECT_EQ(progress.grasps[0].outcome, TrajectoryOutcome::kStopped);
  EXPECT_EQ(progress.grasps[1].outcome, TrajectoryOutcome::kLost);
  const double height = where(*world, "left").translation().z();
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world->step().ok);
  EXPECT_EQ(where(*world, "left").translation().z(), height) << "it moves on";
  EXPECT_NEAR(height, 0.55, 0.002);
}

TEST(TrajectoryFollowers, GoOnWithTheOthersIfAllowed) {
  const auto world = build_world(towel());
  TrajectoryGoal goal = both_up(0.2, 0.1);
  goal.allow_partial = true;
  const auto progress = follow(goal, world.get(), [&](int k) {
    if (k == 100) world->apply(command::Release{"right"});
  });
  EXPECT_NE(progress.status.message.find("lost: right"), std::string::npos);
  EXPECT_EQ(progress.grasps[0].outcome, TrajectoryOutcome::kReached);
  EXPECT_NEAR(where(*world, "left").translation().z(), 0.6, 1e-9);
}

TEST(TrajectoryFollowers, EndWhenMaxSpeedKeepsThemTooLate) {
  const auto world = build_world(towel());
  TrajectoryGoal goal = both_up(0.1, 1.0);  // 10 m/s, where 1 m/s is allowed
  goal.time_tolerance = 0.2;
  const auto progress = follow(goal, world.get(), [](int) {});
  EXPECT_EQ(progress.status.code, Code::kTimeout);
  EXPECT_NEAR(progress.time_from_start, 0.3, 0.002);
  EXPECT_NEAR(progress.grasps[0].position_error, 0.7, 0.01);
}

TEST(TrajectoryFollowers, RefuseGraspsThatAreNotThere) {
  const auto world = build_world(towel());
  TrajectoryGoal goal;
  EXPECT_THROW(TrajectoryFollower(goal, *world), InputError);
  goal.trajectories = {{"middle", {{1.0, at(0, 0, 0)}}}};
  EXPECT_THROW(TrajectoryFollower(goal, *world), InputError);
  goal.trajectories = {{"left", {{1.0, at(0, 0, 0)}}}, {"left", {{1.0, at(0, 0, 0)}}}};
  EXPECT_THROW(TrajectoryFollower(goal, *world), InputError);
}

RolloutPlan lift_and_let_go() {
  RolloutPlan plan;
  plan.trajectories = {{"left", {{0.1, at(-0.1, -0.1, 0.6)}}}};
  plan.commands = {{0.15, command::Release{"left"}, "commands[0]"}};
  return plan;
}

const RolloutKeeper kGoOn = [] { return Status(); };

/// Explicit steps: a copy goes on to the same bits as the world itself under the same commands.
TEST(Rollouts, SeeWhatWillHappen) {
  const auto world = build_world(towel()), copy = build_world(towel());
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(world->step().ok);
  copy->restore(world->copy());
  const RolloutPlan plan = lift_and_let_go();
  Script none;
  std::vector<double> times;
  const auto note = [&](const World& now) { times.push_back(now.time()); };
  EXPECT_TRUE(play_rollout(plan, 0.3, 0.1, &none, copy.get(), note, kGoOn).status.ok());
  ASSERT_EQ(times.size(), 4u);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(times[static_cast<size_t>(k)], 0.04 + 0.1 * k, 1e-12);
  EXPECT_TRUE(play_rollout(
                  plan, 0.3, 0.0, &none, world.get(), [](const World&) {}, kGoOn)
                  .status.ok());
  EXPECT_EQ((world->state().x - copy->state().x).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(world->grasp_reports().size(), 1u);
}

TEST(Rollouts, EndAtWhatIsRefusedAndSaySo) {
  const auto world = build_world(towel());
  RolloutPlan plan;
  plan.commands = {{0.01, command::Release{"middle"}, "commands[0]"}};
  Script none;
  int samples = 0;
  const auto outcome = play_rollout(
      plan, 0.1, 0.0, &none, world.get(), [&](const World&) { ++samples; }, kGoOn);
  EXPECT_EQ(outcome.status.code, Code::kNotFound);
  EXPECT_EQ(outcome.status.message.rfind("commands[0]: ", 0), 0u);
  EXPECT_EQ(samples, 1);
  EXPECT_NEAR(world->time(), 0.01, 1e-12);
}

TEST(Rollouts, TellLostAndLimitedGraspsAndStopWhenTold) {
  const auto world = build_world(towel());
  RolloutPlan plan;
  plan.trajectories = {{"left", {{0.01, at(-0.1, -0.1, 1.5)}}}};
  plan.commands = {{0.05, command::Release{"left"}, "commands[0]"}};
  Script none;
  auto outcome = play_rollout(
      plan, 0.1, 0.0, &none, world.get(), [](const World&) {}, kGoOn);
  ASSERT_EQ(outcome.notes.size(), 2u);
  EXPECT_NE(outcome.notes[0].find("rate-limited"), std::string::npos);
  EXPECT_NE(outcome.notes[1].find("lost at 0.05 s"), std::string::npos);
  const double before = world->time();
  outcome = play_rollout(
      {}, 0.1, 0.0, &none, world.get(), [](const World&) {},
      [] {
        return Status{Code::kTimeout, ""};
      });
  EXPECT_EQ(outcome.status.code, Code::kTimeout);
  EXPECT_EQ(world->time(), before);
}

/// Whoever is copied goes on to the same bits as if it had not been: with schemes that remember much, with contact.
TEST(Rollouts, LeaveTheWorldThatIsCopiedAlone) {
  for (const std::string name : {"laundry_pile", "towel_fold", "pleated_cloth", "rubber_beam", "overhand_knot"}) {
    const SceneSpec spec = load_scene_file(find_scene(name, default_scene_dir()));
    const auto watched = build_world(spec), alone = build_world(spec);
    for (int k = 0; k < 12; ++k) {
      EXPECT_FALSE(watched->copy().empty());
      ASSERT_TRUE(watched->step().ok && alone->step().ok);
    }
    EXPECT_EQ((watched->state().x - alone->state().x).cwiseAbs().maxCoeff(), 0.0) << name;
    EXPECT_EQ((watched->state().v - alone->state().v).cwiseAbs().maxCoeff(), 0.0) << name;
  }
}

}  // namespace
}  // namespace deformable_sim
