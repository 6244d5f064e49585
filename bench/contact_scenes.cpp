#include "contact_scenes.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

const char* const kSheetStep = "step: {integrator: bdf2, linear_solver: multigrid, dt: 0.016666666666666666}\n";

/// "cells: [...]" and all else of the sheet but where it is.
std::string sheet(int nodes, const std::string& pose) {
  const int side = std::max(4, static_cast<int>(std::lround(std::sqrt(static_cast<double>(nodes)))));
  std::ostringstream text;
  text << kSheetStep << "air: {damping: 0.5}\nbodies:\n  - cloth: {name: sheet, touches: all, size: [1, 1], cells: ["
       << side - 1 << ", " << side - 1 << "], pose: {" << pose << "}, bending: quadratic, contact_radius: 0.001, "
       << "friction: 0.4, material: {areal_density: 0.2, membrane_stiffness: 1.0e+3, bending_rigidity: 1.0e-5, "
       << "damping: 0.002, bending_damping: 0.01}}\n";
  return text.str();
}

/// A link of a robot: turned about z, 0.16 m long, with a waist. 1,200 triangles.
TriangleMesh link_mesh() {
  constexpr int kAround = 24, kAlong = 24;
  TriangleMesh mesh;
  mesh.rest.resize(3, kAround * (kAlong + 1) + 2);
  for (int i = 0; i <= kAlong; ++i) {
    const double z = -0.08 + 0.16 * i / kAlong;
    const double radius = 0.035 - 0.012 * std::cos(M_PI * z / 0.08);
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * M_PI * k / kAround;
      mesh.rest.col(i * kAround + k) = Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  const int bottom = kAround * (kAlong + 1), top = bottom + 1, last = kAlong * kAround;
  mesh.rest.col(bottom) = Vec3(0, 0, -0.08);
  mesh.rest.col(top) = Vec3(0, 0, 0.08);
  for (int k = 0; k < kAround; ++k) {
    const int next = (k + 1) % kAround;
    for (int i = 0; i < last; i += kAround) {
      mesh.triangles.push_back({i + k, i + next, i + kAround + next});
      mesh.triangles.push_back({i + k, i + kAround + next, i + kAround + k});
    }
    mesh.triangles.push_back({bottom, next, k});
    mesh.triangles.push_back({top, last + k, last + next});
  }
  return mesh;
}

Shape obstacle_shape(int k, const std::shared_ptr<const ColliderMesh>& link) {
  Shape shape;
  if (k % 7 == 3) {
    shape.type = Shape::Type::kMesh;
    shape.mesh = link;
    shape.collider_from_shape = Pose(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX()));
  } else if (k % 3 == 0) {
    shape.type = Shape::Type::kSphere;
    shape.size = Vec3(0.05, 0, 0);
  } else if (k % 3 == 1) {
    shape.type = Shape::Type::kBox;
    shape.size = Vec3(0.08, 0.08, 0.1);
  } else {
    shape.type = Shape::Type::kCapsule;
    shape.size = Vec3(0.03, 0.1, 0);
    shape.collider_from_shape = Pose(Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitY()));
  }
  return shape;
}

void must(const Reply& reply) {
  if (reply.status.code != Code::kOk) throw InputError(reply.status.message);
}

}  // namespace

void ContactScene::command() {
  const double dt = world->settings().dt, at = world->time() + dt;
  for (const Mover& m : movers) {
    const double phase = std::sin(m.rate * std::min(at, m.stop));
    must(world->apply(command::MoveCollider{
        m.name, Eigen::Translation3d(phase * m.swing) * m.home * Eigen::AngleAxisd(m.turn * phase, Vec3::UnitZ()),
        dt}));
  }
  if (pull == 0.0) return;
  for (const GraspReport& grasp : world->grasp_reports()) {
    const double way = (grasp.name == "pin_rope_end_0" ? -1.0 : 1.0) * pull * dt;
    must(world->apply(command::MoveGrasp{grasp.name, Eigen::Translation3d(way, 0, 0) * grasp.world_from_grasp, dt}));
  }
}

ContactScene draped_sheet(int nodes) {
  ContactScene scene;
  scene.world = build(sheet(nodes, "position: [0, 0, 0.1]"));
  const auto link = make_collider_meshes(link_mesh()).front();
  for (int k = 0; k < 20; ++k) {
    Collider c;
    c.name = "obstacle_" + std::to_string(k);
    c.shapes = {obstacle_shape(k, link)};
    const Vec3 place(-0.4 + 0.2 * (k % 5), -0.36 + 0.24 * (k / 5), -0.03 * (k % 4));
    c.world_from_collider = Pose(Eigen::Translation3d(place));
    must(scene.world->apply(command::AddCollider{c}));
    const double up = k % 2 == 0 ? 0.008 : -0.008;
    scene.movers.push_back({c.name, c.world_from_collider, Vec3(0.03, 0.01, up), 0.1, 3.0});
  }
  return scene;
}

ContactScene crumpled_sheet(int nodes) {
  ContactScene scene;
  // The lowest corner is 1 cm above the plane.
  scene.world =
      build(sheet(nodes, "position: [0, 0, 0.712], rpy: [1.45, 0.7, 0.1]") + "colliders:\n  - plane: {name: floor}\n");
  for (int k = 0; k < 4; ++k) {
    const Pose turn(Eigen::AngleAxisd(0.5 * M_PI * k, Vec3::UnitZ()));
    Collider c;
    c.name = "wall_" + std::to_string(k);
    Shape shape;
    shape.size = Vec3(0.04, 2.0, 1.6);
    c.shapes = {shape};
    c.world_from_collider = turn * Eigen::Translation3d(0.8, 0, 0.8);
    must(scene.world->apply(command::AddCollider{c}));
    // In to 0.28 m from the middle, where they stay.
    scene.movers.push_back({c.name, c.world_from_collider, turn * Vec3(-0.5, 0, 0), 0.0, 1.0, 0.5 * M_PI});
  }
  return scene;
}

ContactScene knotted_rope(int segments) {
  constexpr double kSegment = 0.005, kStrands = 0.0048;  // m: half the distance of the strands, 8 mm thick
  const double ring = segments * kSegment / (4.0 * M_PI);
  std::ostringstream text;
  text.precision(17);
  text << "step: {integrator: implicit_euler, dt: 0.0041666666666666666}\nair: {damping: 0.5}\nbodies:\n"
       << "  - rope: {name: rope, touches: all, pose: {position: [0, 0, 0.01]}, segments: " << segments
       << ", friction: 0.3, pins: [end_0, end_1], material: {diameter: 0.008, linear_density: 0.05, axial_stiffness: "
       << "2000}, path: [";
  const int points = 4 * segments;
  // Cut open over the length of four segments.
  const double gap = 4.0 / segments;
  for (int k = 0; k <= points; ++k) {
    const double t = 4.0 * M_PI * (gap / 2.0 + (1.0 - gap) * k / points), turn = 7.5 * t;
    const double r = ring + kStrands * std::cos(turn);
    text << (k > 0 ? ", [" : "[") << r * std::cos(t) << ", " << r * std::sin(t) << ", " << kStrands * std::sin(turn)
         << "]";
  }
  text << "]}\ncolliders:\n  - plane: {name: table}\n";
  ContactScene scene;
  scene.world = build(text.str());
  scene.pull = 0.1;
  return scene;
}

}  // namespace bench
}  // namespace deformable_sim
