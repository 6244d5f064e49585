// Which contacts bodies have with one another, and that they end on their own sides.
#include "deformable_sim/core/contact/body_contacts.h"

#include <gtest/gtest.h>

#include <set>

#include "support/crossings.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

constexpr double kDt = 0.01;

/// Two sheets of 2 x 2 cells of 0.1 m, one `height` (m) above the other, 2 mm of radius each.
std::shared_ptr<Model> two_sheets(double height, const Vec3& shift = Vec3::Zero()) {
  const auto mesh = std::make_shared<const TriangleMesh>(make_grid(0.2, 0.2, 2, 2));
  Nodes x(3, 18);
  x.leftCols<9>() = mesh->rest;
  x.rightCols<9>() = mesh->rest.colwise() + (shift + Vec3(0, 0, height));
  auto model = test::points_model(x, 0.01, Vec3::Zero());
  Body body = model->bodies[0];
  model->bodies.clear();
  for (int k = 0; k < 2; ++k) {
    body.name = k == 0 ? "lower" : "upper";
    body.first_node = 9 * k;
    body.node_count = 9;
    body.surface = mesh;
    body.contact_radius = 0.002;
    body.friction = k == 0 ? 0.2 : 0.8;
    body.touches = BodyContact::kAll;
    model->bodies.push_back(body);
  }
  return model;
}

ContactConstraints find(BodyContacts* contacts, const State& s) {
  ContactConstraints found;
  contacts->find(s, kDt, {}, Nodes(3, 0), &found);
  return found;
}

TEST(BodyContacts, KnowEachPlaceWhereSheetsMeetOnce) {
  // Corner above corner, edge above edge: the direction is straight up, the distance the sum of the radii.
  const auto model = two_sheets(0.0045);
  BodyContacts contacts(model.get());
  const ContactConstraints found = find(&contacts, model->initial);
  std::set<std::array<int, 4>> places;
  int corners = 0;
  for (const ContactConstraint& c : found) {
    EXPECT_TRUE(places.insert(c.node).second);
    EXPECT_NEAR(std::abs(c.normal.z()), 1.0, 1e-12);
    EXPECT_NEAR(c.offset, 0.004, 1e-12);
    EXPECT_NEAR(c.friction, std::sqrt(0.2 * 0.8), 1e-12);
    EXPECT_EQ(c.collider, -1);
    double sum = 0.0, gap = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      sum += c.weight[k];
      gap += c.weight[k] * c.normal.dot(model->initial.x.col(c.node[k]));
    }
    EXPECT_NEAR(sum, 0.0, 1e-12);
    EXPECT_NEAR(gap, 0.0045, 1e-12);
    corners += c.count == 2 ? 1 : 0;
  }
  EXPECT_EQ(corners, 9);
}

TEST(BodyContacts, SeeNothingOutOfReachAndWhatComesNear) {
  const auto model = two_sheets(0.03);
  BodyContacts contacts(model.get());
  EXPECT_TRUE(find(&contacts, model->initial).empty());
  State s = model->initial;
  s.v.rightCols<9>().row(2).setConstant(-2.0);  // 20 mm closer, 6 mm of 4 left
  EXPECT_TRUE(find(&contacts, s).empty());
  s.v.rightCols<9>().row(2).setConstant(-2.6);
  EXPECT_FALSE(find(&contacts, s).empty());
  s.v.setConstant(5.0);  // both together
  EXPECT_TRUE(find(&contacts, s).empty());
}

TEST(BodyContacts, LeaveOutWhatABodyDoesNotTouch) {
  const auto model = two_sheets(0.0045);
  model->bodies[1].touches = BodyContact::kNone;
  BodyContacts alone(model.get());
  EXPECT_TRUE(find(&alone, model->initial).empty());
  EXPECT_EQ(alone.piece_count(), 8);
}

TEST(BodyContacts, KeepApartWhatATimeSchemeLetsThrough) {
  // The upper sheet is put 50 mm below the lower one, 30 mm above which it was: it ends above. The moves have no
  // momentum together, and the velocities are those of the ways that were made.
  const auto model = two_sheets(0.03, Vec3(0.013, 0.027, 0));
  for (int node = 0; node < 18; ++node) model->mass[node] = 0.01 * (1.0 + 0.1 * node);
  BodyContacts contacts(model.get());
  find(&contacts, model->initial);
  State s = model->initial;
  s.x.rightCols<9>().row(2).array() -= 0.08;
  s.v.rightCols<9>().row(2).setConstant(-8.0);
  const Nodes before = model->initial.x, passed = s.x;
  EXPECT_EQ(contacts.keep_apart(before, model->mass.cwiseInverse(), kDt, &s), 0.0);
  EXPECT_GT(s.x(2, 13), s.x(2, 4));
  EXPECT_EQ(test::count_crossings(*model, s.x), 0);
  EXPECT_LT((s.v - (s.x - before) / kDt).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT((s.x - passed).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT(((s.x - passed) * model->mass).norm(), 1e-9 * 0.08 * model->mass.sum());
}

TEST(BodyContacts, PassNothingThroughHeldNodes) {
  // The lower sheet is held: it stays, and the upper one ends above it.
  const auto model = two_sheets(0.03, Vec3(0.013, 0.027, 0));
  BodyContacts contacts(model.get());
  find(&contacts, model->initial);
  State s = model->initial;
  s.x.rightCols<9>().row(2).array() -= 0.08;
  Eigen::VectorXd inverse_mass = model->mass.cwiseInverse();
  inverse_mass.head<9>().setZero();
  EXPECT_EQ(contacts.keep_apart(model->initial.x, inverse_mass, kDt, &s), 0.0);
  EXPECT_EQ(s.x.leftCols<9>(), model->initial.x.leftCols<9>());
  EXPECT_EQ(test::count_crossings(*model, s.x), 0);
  EXPECT_GT(s.x(2, 13), 0.0003);
}

TEST(BodyContacts, ComeNoNearerThanWhereTheyStillHaveADirection) {
  // Pressed down step after step, each of which may halve the distance: after 40 of them it would be nothing.
  const auto model = two_sheets(0.03, Vec3(0.013, 0.027, 0));
  BodyContacts contacts(model.get());
  State s = model->initial;
  Eigen::VectorXd inverse_mass = model->mass.cwiseInverse();
  inverse_mass.head<9>().setZero();
  for (int k = 0; k < 60; ++k) {
    const Nodes before = s.x;
    find(&contacts, s);
    s.x.rightCols<9>().row(2).array() -= 0.004;
    EXPECT_EQ(contacts.keep_apart(before, inverse_mass, kDt, &s), 0.0);
    ASSERT_EQ(test::count_crossings(*model, s.x), 0) << k;
  }
  EXPECT_GT(s.x(2, 13), 0.9e-6);
  EXPECT_LT(s.x(2, 13), 2e-6);
}

TEST(BodyContacts, NameWhatCrosses) {
  const auto model = two_sheets(0.05, Vec3(0.013, 0.027, 0));
  BodyContacts contacts(model.get());
  Nodes x = model->initial.x;
  EXPECT_EQ(contacts.find_crossing(x), "");
  x(2, 13) = -0.02;  // the middle of the upper one
  EXPECT_EQ(contacts.find_crossing(x).find("'lower' and 'upper' cross near ("), 0u);
  x = model->initial.x;
  x.col(0) = Vec3(0.06, 0.075, 0.02);  // a corner folded over the opposite cell and through it
  x.col(1) = Vec3(0.07, 0.04, -0.02);
  EXPECT_EQ(contacts.find_crossing(x).find("'lower' crosses itself near ("), 0u);
  x = model->initial.x;
  x.rightCols<9>() = x.leftCols<9>();
  EXPECT_EQ(contacts.find_crossing(x).find("'lower' and 'upper' are in one place near ("), 0u);
}

}  // namespace
}  // namespace deformable_sim
