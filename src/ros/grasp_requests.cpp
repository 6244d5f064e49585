#include "deformable_sim/ros/grasp_requests.h"

#include <climits>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

namespace {

Selection to_selection(const msg::GraspSelection& message, Frames* frames) {
  Selection selection;
  switch (message.method) {
    case msg::GraspSelection::NEAREST:
      selection.method = SelectionMethod::kNearest;
      break;
    case msg::GraspSelection::RADIUS:
      selection.method = SelectionMethod::kRadius;
      break;
    case msg::GraspSelection::BOX:
      selection.method = SelectionMethod::kBox;
      break;
    case msg::GraspSelection::NODES:
      selection.method = SelectionMethod::kNodes;
      break;
    case msg::GraspSelection::FEATURE:
      selection.method = SelectionMethod::kFeature;
      break;
    default:
      throw InputError("selection.method: " + std::to_string(message.method) +
                       ", allowed are NEAREST 0, RADIUS 1, BOX 2, NODES 3, FEATURE 4");
  }
  if (message.method <= msg::GraspSelection::BOX) {
    selection.world_from_selection = to_world_pose(message.pose, "selection.pose", frames);
  }
  selection.radius = to_non_negative(message.radius, "selection.radius");
  selection.size =
      Vec3(to_non_negative(message.size.x, "selection.size.x"), to_non_negative(message.size.y, "selection.size.y"),
           to_non_negative(message.size.z, "selection.size.z"));
  if (message.nodes.size() > kMaxNodes) throw InputError("selection.nodes: too many", Code::kOutOfRange);
  for (const std::uint32_t node : message.nodes) {
    if (node > static_cast<std::uint32_t>(INT_MAX)) {
      throw InputError("selection.nodes: " + std::to_string(node) + " is out of range", Code::kOutOfRange);
    }
    selection.nodes.push_back(static_cast<int>(node));
  }
  selection.feature = printable(message.feature);
  return selection;
}

}  // namespace

Pose to_world_pose(const geometry_msgs::PoseStamped& pose, const std::string& what, Frames* frames) {
  const Pose frame_from_pose = to_pose(pose.pose, what);
  return frames->resolve(pose.header.frame_id) * frame_from_pose;
}

command::Grasp to_grasp(const std::string& name, const std::string& body, const msg::GraspSelection& selection,
                        const std::string& follow_frame, double max_force, double max_speed, double stiffness,
                        Frames* frames) {
  command::Grasp grasp;
  GraspRequest& request = grasp.request;
  check_name("name", name);
  request.name = name;
  request.body = printable(body);
  request.max_force = to_non_negative(max_force, "max_force");
  request.max_speed = to_non_negative(max_speed, "max_speed");
  request.stiffness = to_non_negative(stiffness, "stiffness");
  request.selection = to_selection(selection, frames);
  request.follow_frame = follow_frame;
  if (!follow_frame.empty()) {
    request.has_frame = true;
    request.world_from_grasp = frames->resolve(follow_frame);
  }
  return grasp;
}

std::vector<Command> to_commands(const msg::GraspCommand& m, Frames* frames) {
  std::vector<Command> commands;
  switch (m.action) {
    case msg::GraspCommand::GRASP:
      commands.push_back(
          to_grasp(m.name, m.body, m.selection, m.follow_frame, m.max_force, m.max_speed, m.stiffness, frames));
      if (!m.target.header.frame_id.empty() && m.follow_frame.empty()) {
        commands.push_back(command::MoveGrasp{m.name, to_world_pose(m.target, "target", frames), 0.0});
      }
      break;
    case msg::GraspCommand::MOVE:
      check_name("name", m.name);
      commands.push_back(command::MoveGrasp{m.name, to_world_pose(m.target, "target", frames), 0.0});
      break;
    case msg::GraspCommand::RELEASE:
      if (!m.name.empty()) check_name("name", m.name);
      commands.push_back(command::Release{m.name});
      break;
    default:
      throw InputError("action: " + std::to_string(m.action) + ", allowed are GRASP 0, MOVE 1, RELEASE 2");
  }
  return commands;
}

}  // namespace deformable_sim
