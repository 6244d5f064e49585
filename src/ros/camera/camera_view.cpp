#include "deformable_sim/ros/camera/camera_view.h"

#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

void draw_body(const Snapshot& snapshot, const Body& body, std::uint16_t id, const Pose& camera_from_world,
               DepthBuffer* buffer) {
  const TriangleMesh* surface = shown_surface(body);
  const ShownColumns shown = surface ? shown_positions(snapshot, body) : ShownColumns(snapshot.x, body);
  const Nodes x = (camera_from_world.linear() * shown.all()).colwise() + camera_from_world.translation();
  if (surface) {
    buffer->draw_triangles(x, surface->triangles, id);
    return;
  }
  for (int s = 0; s < body.line->segment_count(); ++s) {
    const auto [a, b] = body.line->segment(s);
    buffer->draw_tube(x.col(a), x.col(b), body.draw_radius, id);
  }
}

}  // namespace

void draw_world(const Snapshot& snapshot, const SegmentIds::OfSnapshot& ids, const Pose& world_from_camera,
                DepthBuffer* buffer) {
  const Pose camera_from_world = world_from_camera.inverse(Eigen::Isometry);
  const std::vector<Body>& bodies = snapshot.model->bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    draw_body(snapshot, bodies[i], ids.bodies[i], camera_from_world, buffer);
  }
  for (std::size_t i = 0; i < snapshot.colliders.size(); ++i) {
    const Collider& collider = snapshot.colliders[i];
    const Pose camera_from_collider = camera_from_world * collider.world_from_collider;
    for (const Shape& shape : collider.shapes) {
      buffer->draw_shape(shape, camera_from_collider * shape.collider_from_shape, ids.colliders[i]);
    }
  }
}

}  // namespace deformable_sim
