// Selections and the motion of grasp frames.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/grasp_set.h"
#include "deformable_sim/core/grasp/selection.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::grasp_nodes;

constexpr double kDt = 0.01;

/// Five points 10 mm apart along x.
std::shared_ptr<Model> five_points() {
  Nodes x = Nodes::Zero(3, 5);
  for (int i = 0; i < 5; ++i) x(0, i) = 0.01 * i;
  auto model = test::points_model(x, 0.01, Vec3(0, 0, -9.81));
  model->bodies[0].features = {{"end_0", {0}}, {"end_1", {4}}, {"both", {4, 0}}};
  return model;
}

std::string refusal(const std::function<void()>& act, Code* code = nullptr) {
  try {
    act();
  } catch (const InputError& e) {
    if (code != nullptr) *code = e.code();
    return e.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Selection, TakesTheNearestNodeWithinReach) {
  const auto model = five_points();
  Selection s;
  s.world_from_selection = at(0.021, 0.003, 0);
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s), std::vector<int>{2});
}

TEST(Selection, SaysHowFarTheNearestNodeIs) {
  const auto model = five_points();
  Selection s;
  s.world_from_selection = at(0, 0, 0.5);
  for (SelectionMethod method : {SelectionMethod::kNearest, SelectionMethod::kRadius, SelectionMethod::kBox}) {
    s.method = method;
    s.radius = 0.1;
    s.size = Vec3(0.1, 0.1, 0.1);
    Code code = Code::kOk;
    const std::string why = refusal([&] { select_nodes(model->bodies[0], model->initial.x, s); }, &code);
    EXPECT_TRUE(contains(why, "0.5 m")) << why;
    EXPECT_EQ(code, Code::kNotFound);
  }
}

TEST(Selection, TakesAllNodesInARadiusOrAnOrientedBox) {
  const auto model = five_points();
  Selection s;
  s.method = SelectionMethod::kRadius;
  s.world_from_selection = at(0.02, 0, 0);
  s.radius = 0.011;
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s), (std::vector<int>{1, 2, 3}));
  // 50 mm long, 2 mm wide, turned: along x it takes all, along y only the middle one.
  s.method = SelectionMethod::kBox;
  s.size = Vec3(0.05, 0.002, 0.002);
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s).size(), 5u);
  s.world_from_selection = at(0.02, 0, 0, M_PI / 2, Vec3::UnitZ());
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s), std::vector<int>{2});
}

TEST(Selection, TakesListedNodesAndNamedFeatures) {
  const auto model = five_points();
  Selection s;
  s.method = SelectionMethod::kNodes;
  s.nodes = {3, 1};
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s), (std::vector<int>{1, 3}));
  s.method = SelectionMethod::kFeature;
  s.feature = "both";
  EXPECT_EQ(select_nodes(model->bodies[0], model->initial.x, s), (std::vector<int>{0, 4}));
}

TEST(Selection, RefusesWhatItCannotTake) {
  const auto model = five_points();
  const auto why = [&](const Selection& s) {
    return refusal([&] { select_nodes(model->bodies[0], model->initial.x, s); });
  };
  Selection s;
  s.method = SelectionMethod::kNodes;
  EXPECT_TRUE(contains(why(s), "empty"));
  s.nodes = {1, 5};
  EXPECT_TRUE(contains(why(s), "0 to 4"));
  s.nodes = {-1};
  EXPECT_TRUE(contains(why(s), "0 to 4"));
  s.nodes = {1, 1};
  EXPECT_TRUE(contains(why(s), "twice"));
  s.method = SelectionMethod::kFeature;
  s.feature = "corner_9";
  EXPECT_TRUE(contains(why(s), "both, end_0, end_1"));
  s.method = SelectionMethod::kNearest;
  s.radius = -1.0;
  EXPECT_TRUE(contains(why(s), "radius"));
  s.radius = std::nan("");
  EXPECT_TRUE(contains(why(s), "radius"));
  s.radius = 0.0;
  s.world_from_selection.translation().y() = std::nan("");
  EXPECT_TRUE(contains(why(s), "pose"));
  s.world_from_selection = at(0, 0, 0);
  s.method = SelectionMethod::kRadius;
  EXPECT_TRUE(contains(why(s), "radius must be > 0"));
  s.method = SelectionMethod::kBox;
  s.size = Vec3(0.1, 0.0, 0.1);
  EXPECT_TRUE(contains(why(s), "box"));
  s.size = Vec3(0.1, -0.1, 0.1);
  EXPECT_TRUE(contains(why(s), "box"));
}

TEST(GraspSet, RefusesBadRequestsAndKeepsWhatItHas) {
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  set.add(grasp_nodes("left", "points", {0, 1}), model->initial);
  const auto why = [&](const GraspRequest& r, Code expected) {
    Code code = Code::kOk;
    const std::string text = refusal([&] { set.add(r, model->initial); }, &code);
    EXPECT_EQ(code, expected) << text;
    EXPECT_EQ(set.reports().size(), 1u);
    EXPECT_EQ(set.kinematics().node, (std::vector<int>{0, 1}));
    return text;
  };
  EXPECT_TRUE(contains(why(grasp_nodes("", "points", {3}), Code::kInvalidArgument), "name"));
  EXPECT_TRUE(contains(why(grasp_nodes("left", "points", {3}), Code::kAlreadyExists), "exists"));
  EXPECT_TRUE(contains(why(grasp_nodes("right", "rope", {3}), Code::kNotFound), "there are: points"));
  EXPECT_TRUE(contains(why(grasp_nodes("right", "points", {1, 2}), Code::kUnavailable),
                       "node 1 of 'points' is held by grasp 'left'"));
  for (double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    GraspRequest r = grasp_nodes("right", "points", {3});
    r.max_force = bad;
    EXPECT_TRUE(contains(why(r, Code::kInvalidArgument), "max_force"));
    r = grasp_nodes("right", "points", {3});
    r.max_speed = bad;
    EXPECT_TRUE(contains(why(r, Code::kInvalidArgument), "max_speed"));
    r = grasp_nodes("right", "points", {3});
    r.stiffness = bad;
    EXPECT_TRUE(contains(why(r, Code::kInvalidArgument), "stiffness"));
    r = grasp_nodes("right", "points", {3});
    r.has_frame = true;
    r.world_from_grasp.translation().x() = std::isnan(bad) ? bad : 2e6;
    EXPECT_TRUE(contains(why(r, Code::kInvalidArgument), "pose"));
  }
}

TEST(GraspSet, MovesItsNodesRigidly) {
  // target = T(t) local: frame at the origin turning 90 degrees about z in 1 s, linear and slerped.
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  GraspRequest r = grasp_nodes("g", "points", {4, 2});
  r.has_frame = true;
  set.add(r, model->initial);
  Kinematics k = set.kinematics();
  EXPECT_EQ(k.node, (std::vector<int>{2, 4}));
  EXPECT_EQ(set.move("g", at(0.1, 0, 0, M_PI / 2, Vec3::UnitZ()), 1.0, kDt), "");
  for (int i = 1; i <= 100; ++i) {
    set.advance(kDt, model->initial, &k);
    const double u = 0.01 * i;
    const Pose pose = at(0.1 * u, 0, 0, u * M_PI / 2, Vec3::UnitZ());
    EXPECT_NEAR((k.target.col(0) - pose * Vec3(0.02, 0, 0)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((k.target.col(1) - pose * Vec3(0.04, 0, 0)).norm(), 0.0, 1e-12);
  }
  set.advance(kDt, model->initial, &k);
  EXPECT_NEAR((k.target.col(1) - Vec3(0.1, 0.04, 0)).norm(), 0.0, 1e-12);
  EXPECT_FALSE(set.reports()[0].speed_limited);
}

TEST(GraspSet, LimitsAJumpToItsMaxSpeed) {
  // 10 m at 0.5 m/s: no held node moves more than 5 mm in 10 ms, however the frame turns; 20 s to go.
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  GraspRequest r = grasp_nodes("g", "points", {0, 4});
  r.max_speed = 0.5;
  set.add(r, model->initial);
  Kinematics k = set.kinematics();
  const std::string note = set.move("g", at(10, 0, 0, 3.0, Vec3(0, 1, 1)), 0.0, kDt);
  EXPECT_TRUE(contains(note, "rate-limited to 0.5 m/s")) << note;
  Nodes before(3, 2);
  before.col(0) = model->initial.x.col(0);
  before.col(1) = model->initial.x.col(4);
  double way = 0.0;
  for (int i = 0; i < 300; ++i) {
    set.advance(kDt, model->initial, &k);
    for (int j = 0; j < 2; ++j) EXPECT_LE((k.target.col(j) - before.col(j)).norm(), 0.005 + 1e-9);
    EXPECT_TRUE(set.reports()[0].speed_limited);
    way += (k.target.col(0) - before.col(0)).norm();
    before = k.target;
  }
  EXPECT_GT(way, 1.4);
}

TEST(GraspSet, HoldsStillWhileItsFrameIsMissing) {
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  set.add(grasp_nodes("g", "points", {2}), model->initial);
  Kinematics k = set.kinematics();
  set.move("g", at(1, 0, 0), 1.0, kDt);
  set.advance(kDt, model->initial, &k);
  set.set_waiting("g", true);
  const Vec3 held = k.target.col(0);
  for (int i = 0; i < 10; ++i) set.advance(kDt, model->initial, &k);
  EXPECT_EQ(Vec3(k.target.col(0)), held);
  EXPECT_EQ(set.reports()[0].phase, GraspPhase::kWaitingForFrame);
  EXPECT_FALSE(set.move("g", at(1, 0, 0), 1.0, kDt).empty());
  set.set_waiting("g", false);
  set.advance(kDt, model->initial, &k);
  EXPECT_GT(k.target(0, 0), held.x());
  EXPECT_EQ(set.reports()[0].phase, GraspPhase::kHolding);
}

TEST(GraspSet, RefusesBadMovesAndUnknownNames) {
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  set.add(grasp_nodes("g", "points", {2}), model->initial);
  Pose bad = at(0, 0, 0);
  bad.translation().x() = std::nan("");
  EXPECT_TRUE(contains(refusal([&] { set.move("g", bad, 0.0, kDt); }), "finite"));
  EXPECT_TRUE(contains(refusal([&] { set.move("g", at(0, 0, 0), -1.0, kDt); }), "duration"));
  EXPECT_TRUE(contains(refusal([&] { set.move("h", at(0, 0, 0), 0.0, kDt); }), "there are: g"));
  EXPECT_TRUE(contains(refusal([&] { set.release("h"); }), "there are: g"));
  EXPECT_TRUE(contains(refusal([&] { set.set_waiting("h", true); }), "there are: g"));
}

TEST(GraspSet, ReportsTheWrenchOfTheBodyOnTheGripper) {
  // Newton's third law: force = -sum reactions, torque = -sum (x - o) x reaction.
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  GraspRequest r = grasp_nodes("g", "points", {2, 4});
  r.has_frame = true;
  set.add(r, model->initial);
  Kinematics k = set.kinematics();
  set.advance(kDt, model->initial, &k);
  k.reaction.col(0) = Vec3(0, 0, 3);
  k.reaction.col(1) = Vec3(0, 1, 0);
  set.clear_wrenches();
  for (int part = 0; part < 2; ++part) set.measure(k, model->initial, 0.5);
  const GraspReport report = set.reports()[0];
  EXPECT_NEAR((report.force - Vec3(0, -1, -3)).norm(), 0.0, 1e-15);
  // (0.02,0,0) x (0,0,-3) = (0, 0.06, 0); (0.04,0,0) x (0,-1,0) = (0, 0, -0.04).
  EXPECT_NEAR((report.torque - Vec3(0, 0.06, -0.04)).norm(), 0.0, 1e-15);
}

TEST(GraspSet, PullsSoftlyWithItsStiffnessSharedBetweenNodes) {
  // Two nodes, k = 100 N/m together: both 1 cm below their targets pull with 1 N down on the gripper.
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  GraspRequest r = grasp_nodes("g", "points", {2, 4});
  r.stiffness = 100.0;
  set.add(r, model->initial);
  EXPECT_TRUE(set.kinematics().node.empty());
  ASSERT_EQ(set.springs().size(), 1u);
  State s = model->initial;
  s.x.row(2).array() -= 0.01;
  Kinematics k = set.kinematics();
  set.advance(kDt, model->initial, &k);
  set.measure(k, s, 1.0);
  EXPECT_NEAR((set.reports()[0].force - Vec3(0, 0, -1)).norm(), 0.0, 1e-12);
  Nodes f = Nodes::Zero(3, 5);
  set.springs()[0]->add_force(s, &f);
  EXPECT_NEAR((f.rowwise().sum() - Vec3(0, 0, 1)).norm(), 0.0, 1e-12);
}

TEST(GraspSet, SlipsWhenOverloadedAndMayBeTakenAgain) {
  const auto model = five_points();
  GraspSet set(model.get(), 1.0);
  GraspRequest r = grasp_nodes("g", "points", {2});
  r.max_force = 2.0;
  set.add(r, model->initial);
  Kinematics k = set.kinematics();
  k.reaction.col(0) = Vec3(0, 0, 1.9);
  set.measure(k, model->initial, 1.0);
  EXPECT_FALSE(set.slip_overloaded());
  EXPECT_NEAR(set.reports()[0].load, 0.95, 1e-12);
  set.clear_wrenches();
  k.reaction.col(0) = Vec3(0, 0, 2.1);
  set.measure(k, model->initial, 1.0);
  EXPECT_TRUE(set.slip_overloaded());
  EXPECT_EQ(set.reports()[0].phase, GraspPhase::kSlipped);
  EXPECT_GT(set.reports()[0].load, 1.0);
  EXPECT_TRUE(set.kinematics().node.empty());
  EXPECT_TRUE(contains(refusal([&] { set.move("g", at(0, 0, 0), 0.0, kDt); }), "slipped"));
  EXPECT_TRUE(contains(refusal([&] { set.set_waiting("g", true); }), "slipped"));
  EXPECT_EQ(set.add(r, model->initial), std::vector<int>{2});
  ASSERT_EQ(set.reports().size(), 1u);
  EXPECT_EQ(set.reports()[0].phase, GraspPhase::kHolding);
}

TEST(FrameMotion, ReachesItsTargetExactly) {
  FrameMotion motion(at(0, 0, 0));
  const Pose target = at(0.3, -0.1, 0.2, 1.0, Vec3(1, 1, 0));
  motion.move_to(target, 0.5);
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(motion.advance(kDt, 10.0, 0.1));
  EXPECT_EQ(motion.pose().matrix(), target.matrix());
  EXPECT_FALSE(motion.moving());
}

}  // namespace
}  // namespace deformable_sim
