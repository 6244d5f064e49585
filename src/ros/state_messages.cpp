#include "deformable_sim/ros/state_messages.h"

#include <algorithm>

#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

std::vector<double> flat(const Nodes& nodes, const Body& body) {
  const double* begin = nodes.data() + 3 * body.first_node;
  return std::vector<double>(begin, begin + 3 * body.node_count);
}

}  // namespace

msg::BodyState body_state_message(const Snapshot& snapshot, int body, const std::string& frame_id, ros::Time stamp) {
  const Body& shape = snapshot.model->bodies[body];
  const BodyReport& report = snapshot.bodies[body];
  msg::BodyState message;
  message.header.frame_id = frame_id;
  message.header.stamp = stamp;
  message.body = shape.name;
  message.kind = static_cast<std::uint8_t>(shape.kind);
  message.positions = flat(snapshot.x, shape);
  message.velocities = flat(snapshot.v, shape);
  message.kinetic_energy = report.kinetic_energy;
  message.elastic_energy = report.elastic_energy;
  message.potential_energy = report.potential_energy;
  message.max_strain = report.max_strain;
  message.min_strain = report.min_strain;
  if (shape.first_segment >= 0) {
    const double* segments = snapshot.rods.data() + 6 * shape.first_segment;
    message.segments.assign(segments, segments + 6 * shape.line->segment_count());
  }
  message.contacts = static_cast<std::uint32_t>(std::max(0, report.contacts));
  return message;
}

geometry_msgs::Wrench wrench_message(const GraspReport& grasp) {
  const Mat3 grasp_from_world = grasp.world_from_grasp.linear().transpose();
  geometry_msgs::Wrench wrench;
  wrench.force = to_vector(grasp_from_world * grasp.force);
  wrench.torque = to_vector(grasp_from_world * grasp.torque);
  return wrench;
}

std::vector<msg::GraspState> grasp_state_messages(const Snapshot& snapshot, const std::string& frame_id,
                                                  ros::Time stamp) {
  std::vector<msg::GraspState> states;
  for (const GraspReport& grasp : snapshot.grasps) {
    msg::GraspState state;
    state.header.frame_id = frame_id;
    state.header.stamp = stamp;
    state.name = grasp.name;
    state.body = grasp.body;
    state.nodes.assign(grasp.nodes.begin(), grasp.nodes.end());
    state.state = static_cast<std::uint8_t>(grasp.phase);
    state.pose = to_message(grasp.world_from_grasp);
    state.wrench = wrench_message(grasp);
    state.load = grasp.load;
    states.push_back(std::move(state));
  }
  return states;
}

std::vector<msg::Contact> contact_messages(const Snapshot& snapshot) {
  std::vector<msg::Contact> contacts;
  for (const ContactReport& c : snapshot.contacts) {
    msg::Contact contact;
    if (c.collider >= 0) {
      const Collider& collider = snapshot.colliders[static_cast<std::size_t>(c.collider)];
      contact.collider = collider.name;
      contact.link = collider.frame;
    } else {
      contact.collider = snapshot.model->bodies[static_cast<std::size_t>(c.other)].name;
    }
    contact.body = snapshot.model->bodies[static_cast<std::size_t>(c.body)].name;
    contact.point = to_point(c.point);
    contact.normal = to_vector(c.normal);
    contact.force = to_vector(c.force);
    contact.distance = c.distance;
    contacts.push_back(std::move(contact));
  }
  return contacts;
}

}  // namespace deformable_sim
