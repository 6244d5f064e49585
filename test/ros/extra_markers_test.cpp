// Shadows, the legend of colours, and arrows of contact forces.
#include <gtest/gtest.h>

#include <cstdlib>

#include "deformable_sim/ros/body_colors.h"
#include "deformable_sim/ros/contact_drawing.h"
#include "deformable_sim/ros/legend_drawing.h"
#include "deformable_sim/ros/rigid_drawing.h"
#include "deformable_sim/ros/shadow_drawing.h"
#include "ros/drawn_scene.h"

namespace deformable_sim {
namespace {

using visualization_msgs::Marker;

Vec3 position(const geometry_msgs::Point& p) {
  return {p.x, p.y, p.z};
}

Collider plane(const std::string& name, const Pose& pose) {
  Collider collider;
  collider.name = name;
  collider.shapes.resize(1);
  collider.shapes[0].type = Shape::Type::kPlane;
  collider.world_from_collider = pose;
  return collider;
}

Collider box(const std::string& name, const Vec3& size, const Vec3& middle) {
  Collider collider = plane(name, Pose(Eigen::Translation3d(middle)));
  collider.shapes[0].type = Shape::Type::kBox;
  collider.shapes[0].size = size;
  return collider;
}

/// A sheet of 1 x 1 m at a height, tilted by hand.
void add_high_sheet(DrawnScene* scene, double height) {
  scene->add_sheet(4);
  scene->snapshot.x.row(2).setLinSpaced(height, height + 0.3);
}

double area(const Marker& marker) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < marker.points.size(); i += 3) {
    const Vec3 a = position(marker.points[i]), b = position(marker.points[i + 1]), c = position(marker.points[i + 2]);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

TEST(Shadow, OfEveryNodeIsUnderItOnThePlane) {
  DrawnScene scene;
  add_high_sheet(&scene, 0.5);
  scene.snapshot.colliders.push_back(plane("floor", Pose(Eigen::Translation3d(0.2, 0.1, -0.25))));
  const Marker marker = shadow_marker(scene.snapshot, 0);
  const TriangleMesh& mesh = *scene.model->bodies[0].surface;
  ASSERT_EQ(marker.points.size(), 3 * mesh.triangles.size());
  for (std::size_t i = 0; i < marker.points.size(); ++i) {
    const Vec3 node = scene.snapshot.x.col(mesh.triangles[i / 3][i % 3]);
    EXPECT_NEAR((position(marker.points[i]) - Vec3(node.x(), node.y(), -0.25 + kShadowLift)).norm(), 0.0, 1e-12);
  }
  EXPECT_GT(marker.color.a, 0.0f);
  EXPECT_LT(marker.color.a, 1.0f);
  EXPECT_EQ(marker.colors.size(), 0u);
}

TEST(Shadow, FallsAlongGravityWhereverThatPoints) {
  // Gravity along +x onto the plane x = 2, whose outer side looks back.
  DrawnScene scene;
  add_high_sheet(&scene, 0.0);
  scene.model->gravity = Vec3(3.0, 0.0, 0.0);
  Pose wall = Pose(Eigen::Translation3d(2, 0, 0));
  wall.linear() = Eigen::AngleAxisd(-M_PI / 2, Vec3::UnitY()).toRotationMatrix();
  scene.snapshot.colliders.push_back(plane("wall", wall));
  const Marker marker = shadow_marker(scene.snapshot, 0);
  const TriangleMesh& mesh = *scene.model->bodies[0].surface;
  ASSERT_EQ(marker.points.size(), 3 * mesh.triangles.size());
  for (std::size_t i = 0; i < marker.points.size(); ++i) {
    const Vec3 node = scene.snapshot.x.col(mesh.triangles[i / 3][i % 3]);
    EXPECT_NEAR((position(marker.points[i]) - Vec3(2.0 - kShadowLift, node.y(), node.z())).norm(), 0.0, 1e-9);
  }
}

TEST(Shadow, IsCutAtTheEdgeOfATableAndGoesOnBelow) {
  // Of 1 m^2 half is over a table of 0.5 x 3 m; the rest falls on the floor beside it, none under it.
  DrawnScene scene;
  add_high_sheet(&scene, 0.9);
  scene.snapshot.colliders.push_back(plane("floor", Pose::Identity()));
  scene.snapshot.colliders.push_back(box("table", Vec3(0.53, 3.0, 0.1), Vec3(-0.265, 0.0, 0.7)));
  const Marker marker = shadow_marker(scene.snapshot, 0);
  EXPECT_NEAR(area(marker), 1.0, 1e-9);
  double above = 0.0;
  for (std::size_t i = 0; i + 2 < marker.points.size(); i += 3) {
    const Vec3 a = position(marker.points[i]), b = position(marker.points[i + 1]), c = position(marker.points[i + 2]);
    const bool table = a.z() > 0.5;
    EXPECT_NEAR(a.z(), (table ? 0.75 : 0.0) + kShadowLift, 1e-12);
    EXPECT_EQ(((a + b + c) / 3.0).x() < 0.0, table);
    above += table ? 0.5 * (b - a).cross(c - a).norm() : 0.0;
  }
  EXPECT_NEAR(above, 0.5, 1e-9);
}

TEST(Shadow, IsNoneAboveTheBodyOnSlopesAndWithoutGravity) {
  DrawnScene scene;
  add_high_sheet(&scene, 0.5);
  EXPECT_EQ(shadow_marker(scene.snapshot, 0).points.size(), 0u);
  Pose pose(Eigen::Translation3d(0, 0, 2));
  scene.snapshot.colliders = {plane("ceiling", pose)};
  EXPECT_EQ(shadow_marker(scene.snapshot, 0).points.size(), 0u);
  pose = Eigen::AngleAxisd(0.1, Vec3::UnitX());
  scene.snapshot.colliders = {plane("slope", pose)};
  EXPECT_EQ(shadow_marker(scene.snapshot, 0).points.size(), 0u);
  scene.snapshot.colliders = {plane("floor", Pose::Identity())};
  EXPECT_GT(shadow_marker(scene.snapshot, 0).points.size(), 0u);
  scene.model->gravity.setZero();
  EXPECT_EQ(shadow_marker(scene.snapshot, 0).points.size(), 0u);
}

TEST(Shadow, OfARopeIsAsWideAsItsTube) {
  // 1 m long, 20 mm thick, hanging askew: the band is as long as it looks from above.
  DrawnScene scene;
  scene.add_rod(5, 0.0);
  for (int node = 0; node < 6; ++node) scene.snapshot.x(2, node) = 0.3 + 0.05 * node;
  scene.snapshot.colliders.push_back(plane("floor", Pose::Identity()));
  const Marker marker = shadow_marker(scene.snapshot, 0);
  EXPECT_NEAR(area(marker), 1.0 * 0.02, 1e-12);
  for (const auto& point : marker.points) EXPECT_NEAR(std::abs(point.y), 0.01, 1e-12);
}

TEST(Shadow, OfASoftBodyIsDrawnOnce) {
  DrawnScene scene;
  const TetMesh cube = make_box(Vec3::Ones(), {2, 2, 2});
  Body& body = scene.add("cube", cube.rest);
  body.surface = std::make_shared<TriangleMesh>(boundary_of(cube));
  body.volume = std::make_shared<TetMesh>(cube);
  scene.snapshot.colliders.push_back(plane("floor", Pose(Eigen::Translation3d(0, 0, -3))));
  EXPECT_NEAR(area(shadow_marker(scene.snapshot, 0)), 1.0, 1e-9);
}

OutputSpec colored_by(const std::string& what) {
  OutputSpec outputs;
  outputs.color_by = what;
  return outputs;
}

DrawnScene started_sheet() {
  DrawnScene scene;
  scene.add_sheet(4);
  scene.model->initial.x = scene.snapshot.x;
  return scene;
}

TEST(Legend, SaysTheRangeInUse) {
  const DrawnScene scene = started_sheet();
  const auto numbers = [&scene](const OutputSpec& outputs) {
    std::vector<std::string> texts;
    for (const Marker& marker : legend_markers(scene.snapshot, outputs)) {
      if (marker.type == Marker::TEXT_VIEW_FACING) texts.push_back(marker.text);
    }
    return texts;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(numbers(colored_by("body")), Texts());
  OutputSpec outputs = colored_by("strain");
  outputs.strain_range = 0.07;
  EXPECT_EQ(numbers(outputs), (Texts{"-0.07", "0", "0.07", "strain"}));
  EXPECT_NEAR(std::atof(numbers(outputs)[2].c_str()), outputs.strain_range, 1e-12);
  outputs = colored_by("stress");
  outputs.stress_range = 2.5e5;
  EXPECT_EQ(numbers(outputs), (Texts{"-250 kPa", "0", "250 kPa", "stress"}));
  EXPECT_EQ(numbers(colored_by("velocity")), (Texts{"0", "0.5 m/s", "1 m/s", "velocity"}));
}

TEST(Legend, OfContactIsTwiceTheMeanForceAndRedThere) {
  DrawnScene scene = started_sheet();
  scene.snapshot.contact_force = Eigen::VectorXf::Zero(25);
  scene.snapshot.contact_force[3] = 1.0f;
  scene.snapshot.contact_force[7] = 3.0f;
  scene.snapshot.contact_force[8] = 4.0f;
  scene.snapshot.contact_force[9] = 4.0f;
  const OutputSpec outputs = colored_by("contact");
  const ColorScale scale = color_scale(scene.snapshot, outputs);
  EXPECT_EQ(scale.low, 0.0);
  EXPECT_NEAR(scale.high, 2.0 * 12.0 / 4.0, 1e-6);
  const std::vector<Color> colors = body_colors(scene.snapshot, scene.model->bodies[0], outputs);
  EXPECT_NEAR((colors[7] - scale_color(0.5f)).norm(), 0.0f, 1e-6f);
  EXPECT_EQ(legend_markers(scene.snapshot, outputs)[3].text, "6 N");
}

TEST(Legend, BarHasTheColoursOfItsNumbers) {
  const DrawnScene scene = started_sheet();
  OutputSpec outputs = colored_by("strain");
  outputs.legend_position = Vec3(1.0, 2.0, 3.0);
  outputs.legend_height = 0.6;
  const std::vector<Marker> markers = legend_markers(scene.snapshot, outputs);
  ASSERT_EQ(markers.size(), 5u);
  const Marker& bar = markers[0];
  ASSERT_EQ(bar.points.size(), bar.colors.size());
  double low = 1e9, high = -1e9;
  for (std::size_t i = 0; i < bar.points.size(); i += 6) {
    double foot = 1e9, top = -1e9;
    for (std::size_t k = i; k < i + 6; ++k) {
      foot = std::min(foot, bar.points[k].z);
      top = std::max(top, bar.points[k].z);
    }
    // The colour at the middle of a band is that of the strain there.
    const Color wanted = scale_color(static_cast<float>(2.0 * (0.5 * (foot + top) - 3.0) / 0.6 - 1.0));
    EXPECT_NEAR((Color(bar.colors[i].r, bar.colors[i].g, bar.colors[i].b) - wanted).norm(), 0.0f, 1e-5f);
    low = std::min(low, foot);
    high = std::max(high, top);
  }
  EXPECT_NEAR(low, 3.0, 1e-12);
  EXPECT_NEAR(high, 3.6, 1e-12);
  // Numbers stand at the height of their values, and each marker has an id of its own.
  EXPECT_NEAR(markers[1].pose.position.z, 3.0, 1e-12);
  EXPECT_NEAR(markers[2].pose.position.z, 3.3, 1e-12);
  EXPECT_NEAR(markers[3].pose.position.z, 3.6, 1e-12);
  for (std::size_t i = 0; i < markers.size(); ++i) EXPECT_EQ(markers[i].id, static_cast<int>(i));
}

TEST(Legend, StandsBesideTheBodiesByItself) {
  const DrawnScene scene = started_sheet();
  const Marker bar = legend_markers(scene.snapshot, colored_by("strain"))[0];
  for (const auto& point : bar.points) EXPECT_LT(point.x, -0.5);
  for (const auto& point : bar.points) EXPECT_GT(point.y, 0.5);
}

TEST(Legend, KeepsThreeDigits) {
  EXPECT_EQ(number_text(0.0, "N"), "0");
  EXPECT_EQ(number_text(0.123456, ""), "0.123");
  EXPECT_EQ(number_text(1234.0, ""), "1.23e+03");
  EXPECT_EQ(number_text(1234.0, "N"), "1.23 kN");
  EXPECT_EQ(number_text(-1e12, "Pa"), "-1e+03 GPa");
  EXPECT_EQ(number_text(999.9, "Pa"), "1 kPa");
}

/// Shafts are the first two of six points.
Vec3 sum_of_shafts(const Marker& marker) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i + 5 < marker.points.size(); i += 6) {
    sum += position(marker.points[i + 1]) - position(marker.points[i]);
  }
  return sum;
}

TEST(ContactArrows, AreForcesTimesTheScaleFromWhereTheyAct) {
  DrawnScene scene = started_sheet();
  scene.add("other", Nodes::Zero(3, 3));
  scene.model->initial.x = scene.snapshot.x;
  Vec3 total = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    ContactReport contact;
    contact.collider = 0;
    contact.point = Vec3(0.1 * k, 0.2, 0.0);
    contact.force = Vec3(0.1, -0.2 * k, 1.0 + k);
    total += contact.force;
    scene.snapshot.contacts.push_back(contact);
  }
  const double scale = 0.03;
  const Marker marker = contact_marker(scene.snapshot, 0, scale);
  EXPECT_EQ(marker.type, Marker::LINE_LIST);
  ASSERT_EQ(marker.points.size(), 4u * 6u);
  for (std::size_t k = 0; k < 4; ++k) {
    const ContactReport& contact = scene.snapshot.contacts[k];
    const Vec3 from = position(marker.points[6 * k]), tip = position(marker.points[6 * k + 1]);
    EXPECT_NEAR((from - contact.point).norm(), 0.0, 1e-12);
    EXPECT_NEAR((tip - from).norm(), scale * contact.force.norm(), 1e-12);
    EXPECT_NEAR((position(marker.points[6 * k + 2]) - tip).norm(), 0.0, 1e-12);
    EXPECT_LT((position(marker.points[6 * k + 3]) - tip).dot(contact.force), 0.0);
  }
  EXPECT_NEAR((sum_of_shafts(marker) - scale * total).norm(), 0.0, 1e-12);
  EXPECT_EQ(contact_marker(scene.snapshot, 1, scale).points.size(), 0u);
}

TEST(ContactArrows, OfTwoBodiesAreOpposite) {
  DrawnScene scene = started_sheet();
  scene.add("other", Nodes::Zero(3, 3));
  ContactReport contact;
  contact.other = 1;
  contact.force = Vec3(0, 0, 2);
  scene.snapshot.contacts.push_back(contact);
  const Vec3 on_first = sum_of_shafts(contact_marker(scene.snapshot, 0, 1.0));
  EXPECT_NEAR((on_first - contact.force).norm(), 0.0, 1e-12);
  EXPECT_NEAR((sum_of_shafts(contact_marker(scene.snapshot, 1, 1.0)) + on_first).norm(), 0.0, 1e-12);
}

TEST(ContactArrows, ByThemselvesAreAFifthOfTheSceneAtMost) {
  DrawnScene scene = started_sheet();  // 1 m large
  EXPECT_TRUE(std::isfinite(contact_arrow_scale(scene.snapshot, OutputSpec())));
  for (const double force : {1.0, 8.0}) {
    ContactReport contact;
    contact.force = Vec3(force, 0, 0);
    scene.snapshot.contacts.push_back(contact);
  }
  EXPECT_NEAR(contact_arrow_scale(scene.snapshot, OutputSpec()), 0.2 / 8.0, 1e-12);
  OutputSpec outputs;
  outputs.contact_scale = 0.5;
  EXPECT_EQ(contact_arrow_scale(scene.snapshot, outputs), 0.5);
}

}  // namespace
}  // namespace deformable_sim
