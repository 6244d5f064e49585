// Which planes the contact search gives a step.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/error.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::collider;

constexpr double kDt = 0.01;

struct Scene {
  Scene(const Nodes& x, std::vector<Collider> given)
      : model(test::points_model(x, 0.01, Vec3(0, 0, -9.81))), colliders(given) {
    for (const Collider& c : colliders) poses.push_back({c.world_from_collider, c.world_from_collider});
    roles.assign(static_cast<size_t>(x.cols()), NodeRole::kFree);
    state = model->initial;
  }
  ContactConstraints find(double extra_reach = 0.0) {
    if (!finder) {
      finder = std::make_unique<ContactFinder>(model.get());
      finder->set_colliders(colliders);
    }
    ContactConstraints contacts;
    finder->find(state, kDt, poses, roles, extra_reach, &contacts);
    return contacts;
  }
  std::shared_ptr<Model> model;
  std::vector<Collider> colliders;
  std::vector<PoseStep> poses;
  std::vector<NodeRole> roles;
  State state;
  std::unique_ptr<ContactFinder> finder;
};

Nodes column(double x, double y, double z) {
  return Nodes(Vec3(x, y, z));
}

TEST(ContactFinder, GivesTheTangentPlaneAtTheNearestSurfacePoint) {
  // gap = n.p - offset with offset = n.q + r: sphere of radius 0.1, point 1 mm outside it, r = 0.3 mm.
  Scene s(column(0, 0.101, 0), {collider("ball", Shape::Type::kSphere, Vec3(0.1, 0, 0), at(0, 0, 0))});
  s.model->bodies[0].contact_radius = 0.0003;
  s.model->bodies[0].friction = 0.8;
  s.colliders[0].friction = 0.2;
  const ContactConstraints contacts = s.find();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR((contacts[0].normal - Vec3::UnitY()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(contacts[0].offset, 0.1003, 1e-12);
  EXPECT_NEAR(contacts[0].friction, std::sqrt(0.8 * 0.2), 1e-15);
  EXPECT_EQ(contacts[0].surface_velocity, Vec3::Zero());
  EXPECT_EQ(contacts[0].collider, 0);
}

TEST(ContactFinder, SeesNothingThatCannotBeReached) {
  // Reach = 1.25 |v| dt + g dt^2 + 2 mm: at rest 3 mm, at 2 m/s 28 mm.
  Scene s(column(0, 0, 0.02), {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))});
  EXPECT_TRUE(s.find().empty());
  s.state.v.col(0) = Vec3(0, 0, -2);
  EXPECT_EQ(s.find().size(), 1u);
}

TEST(ContactFinder, WidensItsReachByTheSurfaceMotion) {
  // A plate 20 mm away that comes 30 mm nearer in the step has to be seen by a node at rest.
  for (Shape::Type type : {Shape::Type::kBox, Shape::Type::kPlane}) {
    Scene s(column(0.1, 0, 0.02),
            {collider("c", type, Vec3(1, 1, 0.002), at(0, 0, type == Shape::Type::kBox ? -0.001 : 0))});
    s.poses[0].end.translation().z() += 0.03;
    const ContactConstraints contacts = s.find();
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].offset, 0.03, 1e-12);
    EXPECT_NEAR((contacts[0].surface_velocity - Vec3(0, 0, 3.0)).norm(), 0.0, 1e-9);
  }
}

TEST(ContactFinder, CarriesThePlaneWithATurningCollider) {
  // A box turning by a about x carries its top plane: n = R e_z, offset = n . R q; p moves with it by (R - I) p.
  const double a = 0.1;
  Scene s(column(0, 0.2, 0.001), {collider("table", Shape::Type::kBox, Vec3(1, 1, 1), at(0, 0, -0.5))});
  s.poses[0].end = at(0, 0, 0, a, Vec3::UnitX()) * s.poses[0].begin;
  const ContactConstraints contacts = s.find();
  ASSERT_EQ(contacts.size(), 1u);
  const Mat3 r = Eigen::AngleAxisd(a, Vec3::UnitX()).toRotationMatrix();
  EXPECT_NEAR((contacts[0].normal - r * Vec3::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(contacts[0].offset, 0.0, 1e-12);
  EXPECT_NEAR((contacts[0].surface_velocity - (r * Vec3(0, 0.2, 0.001) - Vec3(0, 0.2, 0.001)) / kDt).norm(), 0.0, 1e-9);
}

TEST(ContactFinder, LeavesHeldNodesAlone) {
  Scene s(column(0, 0, 0.0005), {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))});
  s.roles[0] = NodeRole::kHeld;
  EXPECT_TRUE(s.find().empty());
}

TEST(ContactFinder, SparesNodesBesideAGraspTheGripperOnly) {
  // A node next to a held one lies inside the finger that holds its neighbour; the table below still counts.
  Collider finger = collider("finger", Shape::Type::kBox, Vec3(0.02, 0.02, 0.02), at(0, 0, 0));
  finger.frame = "gripper";
  Scene s(column(0, 0, 0.0005), {finger, collider("table", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))});
  EXPECT_EQ(s.find().size(), 2u);
  s.roles[0] = NodeRole::kBesideHeld;
  const ContactConstraints contacts = s.find();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].collider, 1);
}

TEST(ContactFinder, LetsPointsFoundInsideOutGently) {
  // Required gap at the end of the step: min(0, gap + 0.3 m/s dt), so 50 mm deep asks for 47 mm.
  Scene s(column(0, 0, -0.05), {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))});
  ContactConstraints contacts = s.find();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].offset, -0.047, 1e-12);
  s.state.x(2, 0) = -0.001;
  contacts = s.find();
  EXPECT_NEAR(contacts[0].offset, 0.0, 1e-12);
}

TEST(ContactFinder, KeepsAPointOnItsSideOfAThinPlate) {
  // 2 mm plate: 1.5 mm below the top the bottom is nearer, but the point came from the top.
  Scene s(column(0, 0, 0.0005), {collider("plate", Shape::Type::kBox, Vec3(1, 1, 0.002), at(0, 0, -0.001))});
  EXPECT_GT(s.find()[0].normal.z(), 0.0);
  s.state.x(2, 0) = -0.0015;
  const ContactConstraints contacts = s.find();
  EXPECT_GT(contacts[0].normal.z(), 0.0);
  EXPECT_NEAR(contacts[0].offset, 0.0, 1e-12);
  // Even right through it, it is taken back, 3 mm a step.
  s.state.x(2, 0) = -0.0035;
  EXPECT_GT(s.find()[0].normal.z(), 0.0);
  EXPECT_NEAR(s.find()[0].offset, -0.0005, 1e-12);
  s.state.x(2, 0) = -0.0015;
  // Told to forget, it leaves by the nearest surface.
  s.finder->forget_sides();
  EXPECT_LT(s.find()[0].normal.z(), 0.0);
}

TEST(ContactFinder, TellsOfNodesThatMovedFurtherThanLookedFor) {
  // A node at rest 50 mm above the floor that a force carried through it within one step.
  Scene s(column(0, 0, 0.05), {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))});
  ASSERT_TRUE(s.find().empty());
  const Nodes after = column(0, 0, -0.05);
  const double missed = s.finder->missed_motion(s.state.x, after);
  ASSERT_GT(missed, 0.09);
  EXPECT_EQ(s.find(missed).size(), 1u);
  EXPECT_EQ(s.finder->missed_motion(s.state.x, after), 0.0);
  // Far from every collider nothing has to be repeated.
  s.find();
  EXPECT_EQ(s.finder->missed_motion(s.state.x, column(0, 0, 0.5)), 0.0);
}

TEST(ContactFinder, SkipsPointsBetweenNodesOfOneFlatFace) {
  // A mean of points above a plane is above it: on a table only the nodes cost anything.
  test::Sheet sheet;
  sheet.cells_x = sheet.cells_y = 6;
  sheet.contact_at_faces = true;
  sheet.position = Vec3(0, 0, 0.001);
  const auto model = test::sheet_model(sheet);
  ContactFinder finder(model.get());
  const auto count = [&](const Collider& c) {
    finder.set_colliders({c});
    ContactConstraints contacts;
    finder.find(model->initial, kDt, {{c.world_from_collider, c.world_from_collider}},
                std::vector<NodeRole>(static_cast<size_t>(model->node_count()), NodeRole::kFree), 0.0, &contacts);
    return contacts.size();
  };
  EXPECT_EQ(count(collider("table", Shape::Type::kBox, Vec3(2, 2, 1), at(0, 0, -0.5, 0.3, Vec3::UnitZ()))), 49u);
  // Over an edge the points between count: 0.1 m wide strip under a 0.5 m sheet of 83 mm cells.
  EXPECT_GT(count(collider("strip", Shape::Type::kBox, Vec3(2, 0.1, 1), at(0, 0, -0.5))), 7u);
}

TEST(ContactFinder, KeepsPointsBetweenNodesOverAnEdge) {
  // One node on the table, its neighbour beyond the rim may slide down past it: the middle of their edge needs a plane,
  // although the surface points of both nodes lie on one face.
  test::Sheet sheet;
  sheet.size_x = sheet.size_y = 0.015;
  sheet.cells_x = sheet.cells_y = 1;
  sheet.contact_at_faces = true;
  sheet.position = Vec3(-0.0025, 0, 0.0015);
  const auto model = test::sheet_model(sheet);
  const Collider table = collider("table", Shape::Type::kBox, Vec3(1, 1, 1), at(-0.5, 0, -0.5));
  ContactFinder finder(model.get());
  finder.set_colliders({table});
  State state = model->initial;
  state.v.row(2).setConstant(-0.5);
  ContactConstraints contacts;
  finder.find(state, kDt, {{table.world_from_collider, table.world_from_collider}},
              std::vector<NodeRole>(4, NodeRole::kFree), 0.0, &contacts);
  int between = 0;
  for (const ContactConstraint& c : contacts) between += c.count > 1 ? 1 : 0;
  // Of 5 edges 3 cross the rim (x = 0), and so do both faces; the edge on the table is implied.
  EXPECT_GE(between, 5);
}

TEST(ContactFinder, MeasuresTheDeepestPointOfTheWholeSheet) {
  // A 20 mm edge lying on a 50 mm sphere sinks by its sagitta, R - sqrt(R^2 - (s/2)^2), in the middle.
  test::Sheet sheet;
  sheet.size_x = sheet.size_y = 0.02;
  sheet.cells_x = sheet.cells_y = 1;
  const auto model = test::sheet_model(sheet);
  Nodes x = model->initial.x;
  // Put every corner on the sphere: the centre of the diagonal is deepest.
  const double half_diagonal = 0.01 * std::sqrt(2.0);
  x.row(2).setConstant(std::sqrt(0.05 * 0.05 - half_diagonal * half_diagonal));
  const double depth =
      measure_penetration(*model, {collider("ball", Shape::Type::kSphere, Vec3(0.05, 0, 0), at(0, 0, 0))}, x);
  EXPECT_NEAR(depth, 0.05 - x(2, 0), 1e-12);
}

TEST(ContactFinder, SplitsPointsIntoBlocksOfNeighbours) {
  test::Sheet sheet;
  const auto model = test::sheet_model(sheet);
  std::vector<ContactPoint> points;
  add_node_points(*model, 0, &points);
  const auto blocks = sort_into_blocks(model->initial.x, 32, &points);
  std::vector<int> seen(points.size(), 0);
  for (const PointBlock& b : blocks) {
    EXPECT_LE(b.last - b.first, 32);
    Eigen::AlignedBox3d box;
    for (int i = b.first; i < b.last; ++i) {
      ++seen[static_cast<size_t>(points[static_cast<size_t>(i)].node[0])];
      box.extend(position(points[static_cast<size_t>(i)], model->initial.x));
    }
    // 441 nodes at 25 mm: 32 neighbours span at most about 0.2 m.
    EXPECT_LT(box.sizes().maxCoeff(), 0.2);
  }
  for (int count : seen) EXPECT_EQ(count, 1);
}

TEST(ColliderSet, RefusesWhatIsNotACollider) {
  const Collider good = collider("box", Shape::Type::kBox, Vec3(1, 1, 1), at(0, 0, 0));
  const auto refused = [](Collider c, const char* word) {
    ColliderSet set(5.0);
    try {
      set.add(c);
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
      EXPECT_TRUE(set.empty());
      return true;
    }
    return false;
  };
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  Collider c = good;
  c.name = "";
  EXPECT_TRUE(refused(c, "name"));
  c = good;
  c.shapes.clear();
  EXPECT_TRUE(refused(c, "shape"));
  for (double size : {0.0, -1.0, nan, inf}) {
    c = good;
    c.shapes[0].size.y() = size;
    EXPECT_TRUE(refused(c, "sizes"));
  }
  for (double friction : {-0.1, nan, inf}) {
    c = good;
    c.friction = friction;
    EXPECT_TRUE(refused(c, "friction"));
  }
  c = good;
  c.world_from_collider.translation().x() = nan;
  EXPECT_TRUE(refused(c, "pose"));
  c = good;
  c.world_from_collider.linear() *= 2.0;
  EXPECT_TRUE(refused(c, "unit quaternion"));
  c = good;
  c.shapes[0].collider_from_shape.linear().setZero();
  EXPECT_TRUE(refused(c, "unit quaternion"));
  // A capsule without a straight part is a sphere; other sizes of a sphere or plane are not read.
  EXPECT_FALSE(refused(collider("c", Shape::Type::kCapsule, Vec3(0.1, 0, 0), at(0, 0, 0)), ""));
  EXPECT_TRUE(refused(collider("c", Shape::Type::kCylinder, Vec3(0.1, 0, 0), at(0, 0, 0)), "cylinder"));
  EXPECT_FALSE(refused(collider("c", Shape::Type::kSphere, Vec3(0.1, 0, 0), at(0, 0, 0)), ""));
}

TEST(ColliderSet, SpreadsAFastMoveOverSteps) {
  // 1 m at 5 m/s takes 0.2 s = 20 steps of 10 ms, and the caller is told.
  ColliderSet set(5.0);
  set.add(collider("box", Shape::Type::kBox, Vec3(1, 1, 1), at(0, 0, 0)));
  EXPECT_NE(set.move("box", at(1, 0, 0), 0.0, kDt).find("5 m/s"), std::string::npos);
  std::vector<PoseStep> steps;
  for (int i = 0; i < 20; ++i) {
    set.advance(kDt, &steps);
    EXPECT_NEAR((steps[0].end.translation() - steps[0].begin.translation()).norm(), 0.05, 1e-12);
  }
  EXPECT_NEAR((set.colliders()[0].world_from_collider.translation() - Vec3(1, 0, 0)).norm(), 0.0, 1e-12);
  // A move that fits goes through at once and without a note.
  EXPECT_EQ(set.move("box", at(1.01, 0, 0), 0.0, kDt), "");
  set.advance(kDt, &steps);
  EXPECT_EQ(set.colliders()[0].world_from_collider.translation(), Vec3(1.01, 0, 0));
}

TEST(ColliderSet, NamesTheCollidersThereAre) {
  ColliderSet set(5.0);
  set.add(collider("table", Shape::Type::kBox, Vec3(1, 1, 1), at(0, 0, 0)));
  EXPECT_THROW(set.add(collider("table", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))), InputError);
  try {
    set.remove("tabel");
    FAIL();
  } catch (const InputError& e) {
    EXPECT_EQ(e.code(), Code::kNotFound);
    EXPECT_NE(std::string(e.what()).find("table"), std::string::npos);
  }
}

}  // namespace
}  // namespace deformable_sim
