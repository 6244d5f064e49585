// Points that fly, fall and slide in meshes that are not convex, plane by plane.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/contact_finder.h"
#include "support/collider_meshes.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

constexpr double kDt = 0.01;
constexpr double kRadius = 0.001;

Collider mesh_collider(const TriangleMesh& mesh) {
  Collider c = test::collider("mesh", Shape::Type::kMesh, Vec3::Zero(), Pose::Identity());
  c.shapes[0].mesh = make_collider_meshes(mesh)[0];
  return c;
}

Vec3 random_vector(std::mt19937* random) {
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  return Vec3(in(*random), in(*random), in(*random));
}

/// Moves x to where no plane is behind it, one plane after the other; what is left undone is below 1e-7 m.
void push_out(const ContactConstraints& contacts, Nodes* x) {
  for (int round = 0; round < 3000; ++round) {
    double worst = 0.0;
    for (const ContactConstraint& c : contacts) {
      const double gap = c.normal.dot(x->col(c.node[0])) - c.offset;
      worst = std::max(worst, -gap);
      if (gap < 0.0) x->col(c.node[0]) -= gap * c.normal;
    }
    if (worst < 1e-7) return;
  }
}

struct Flight {
  explicit Flight(const TriangleMesh& given) : mesh(given), collider(mesh_collider(given)) {
    const Eigen::AlignedBox3d box = collider.shapes[0].mesh->box();
    Nodes x(3, 60);
    for (int i = 0; i < x.cols();) {
      const Vec3 p = box.center() + 0.7 * box.sizes().cwiseProduct(random_vector(&random));
      if (test::brute_distance(p, mesh) > 0.0) x.col(i++) = p;
    }
    model = test::points_model(x, 0.01, Vec3::Zero());
    model->bodies[0].contact_radius = kRadius;
    finder = std::make_unique<ContactFinder>(model.get());
    finder->set_colliders({collider});
    state = model->initial;
    roles.assign(60, NodeRole::kFree);
  }

  /// Throws every point anew at up to `speed` (m/s) and turns the mesh by `angle` about an axis through its corner.
  void step(double speed, double angle) {
    const Pose begin = collider.world_from_collider;
    collider.world_from_collider = test::at(0, 0, 0, angle, Vec3(1, 2, 3)) * begin;
    for (int i = 0; i < 60; ++i) state.v.col(i) = speed * random_vector(&random);
    const Nodes before = state.x;
    double extra = 0.0;
    for (int attempt = 0; attempt < 20; ++attempt) {
      contacts.clear();
      finder->find(state, kDt, {{begin, collider.world_from_collider}}, roles, extra, &contacts);
      Nodes after = before + kDt * state.v;
      push_out(contacts, &after);
      state.x = after;
      const double missed = finder->missed_motion(before, after);
      if (missed == 0.0) return;
      extra += missed;
      state.x = before;
    }
    FAIL() << "the reach was never wide enough";
  }

  double deepest() const {
    double depth = 0.0;
    for (int i = 0; i < 60; ++i) {
      const Vec3 local = collider.world_from_collider.inverse() * Vec3(state.x.col(i));
      depth = std::max(depth, -test::brute_distance(local, mesh));
    }
    return depth;
  }

  std::mt19937 random{21};
  TriangleMesh mesh;
  Collider collider;
  std::shared_ptr<Model> model;
  std::unique_ptr<ContactFinder> finder;
  State state;
  std::vector<NodeRole> roles;
  ContactConstraints contacts;
};

struct Case {
  const char* name;
  TriangleMesh (*mesh)();
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class FlightIn : public testing::TestWithParam<Case> {};

TEST_P(FlightIn, NeverEntersTheMesh) {
  // Outside at the start of a step and above all planes at its end: outside. Walls are 2 or 3 mm, ways up to 50 mm.
  Flight flight(GetParam().mesh());
  size_t planes = 0;
  for (int k = 0; k < 60; ++k) {
    flight.step(k % 2 ? 3.0 : 0.3, k % 3 ? 0.0 : 0.02);
    planes += flight.contacts.size();
    ASSERT_EQ(flight.deepest(), 0.0) << "after step " << k;
    EXPECT_EQ(flight.finder->penetration(flight.state.x, {{Pose::Identity(), flight.collider.world_from_collider}},
                                         flight.contacts),
              0.0);
  }
  EXPECT_GT(planes, 300u);
}

INSTANTIATE_TEST_SUITE_P(Every, FlightIn,
                         testing::Values(Case{"l_body", [] { return test::l_mesh(); }},
                                         Case{"thin_channel", [] { return test::channel_mesh(); }},
                                         Case{"thin_bowl", [] { return test::round_mesh(0.1, 8, 20, 0.003); }},
                                         Case{"plate", [] { return test::box_mesh(0.2, 0.15, 0.002); }}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(MeshContact, HoldsAPointInACornerByBothFaces) {
  // The corner of the L at (40, 40): planes x = 40 mm + r and y = 40 mm + r.
  const Vec3 p(0.042, 0.043, 0.04);
  auto model = test::points_model(Nodes(p), 0.01, Vec3::Zero());
  model->bodies[0].contact_radius = kRadius;
  ContactFinder finder(model.get());
  finder.set_colliders({mesh_collider(test::l_mesh())});
  State state = model->initial;
  state.v.col(0) = Vec3(-1, -1, 0);
  ContactConstraints contacts;
  finder.find(state, kDt, {PoseStep()}, {NodeRole::kFree}, 0.0, &contacts);
  ASSERT_EQ(contacts.size(), 2u);
  for (const ContactConstraint& c : contacts) EXPECT_NEAR(c.offset, 0.041, 1e-12);
  EXPECT_NEAR(std::abs(contacts[0].normal.dot(contacts[1].normal)), 0.0, 1e-12);
  EXPECT_NEAR(contacts[0].normal.z(), 0.0, 1e-12);
}

TEST(MeshContact, KeepsAPointOnItsSideOfAThinWall) {
  // Wall of 2 mm: 1.5 mm deep the far side is nearer, but the point came from within the channel.
  auto model = test::points_model(Nodes(Vec3(0.05, 0.0025, 0.1)), 0.01, Vec3::Zero());
  model->bodies[0].contact_radius = kRadius;
  ContactFinder finder(model.get());
  finder.set_colliders({mesh_collider(test::channel_mesh())});
  State state = model->initial;
  ContactConstraints contacts;
  const auto find = [&] {
    contacts.clear();
    finder.find(state, kDt, {PoseStep()}, {NodeRole::kFree}, 0.0, &contacts);
  };
  find();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].normal.y(), 1.0, 1e-12);
  state.x(1, 0) = 0.0005;
  find();
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].normal.y(), 1.0, 1e-12);
  EXPECT_NEAR(contacts[0].offset, 0.003, 1e-12);
  finder.forget_sides();
  find();
  EXPECT_LT(contacts[0].normal.y(), 0.0);
}

}  // namespace
}  // namespace deformable_sim
