#include "motion.h"

#include <cmath>
#include <set>
#include <stdexcept>

namespace robot_demo {
namespace {

using XmlRpc::XmlRpcValue;
using Vector8 = Eigen::Matrix<double, 8, 1>;  // position, quaternion x y z w, opening

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  throw std::runtime_error("motion: " + where + ": " + what);
}

double number(XmlRpcValue v, const std::string& where) {
  if (v.getType() == XmlRpcValue::TypeInt) return static_cast<int>(v);
  if (v.getType() == XmlRpcValue::TypeDouble && std::isfinite(static_cast<double>(v))) return static_cast<double>(v);
  refuse(where, "must be a finite number");
}

std::string text(XmlRpcValue v, const std::string& where) {
  if (v.getType() != XmlRpcValue::TypeString) refuse(where, "must be a string");
  return static_cast<std::string>(v);
}

Eigen::Vector3d vector(XmlRpcValue v, const std::string& where) {
  if (v.getType() != XmlRpcValue::TypeArray || v.size() != 3) refuse(where, "must be a list of three numbers");
  return {number(v[0], where), number(v[1], where), number(v[2], where)};
}

std::vector<XmlRpcValue> list(XmlRpcValue v, const std::string& where) {
  if (v.getType() != XmlRpcValue::TypeArray) refuse(where, "must be a list");
  std::vector<XmlRpcValue> items;
  for (int i = 0; i < v.size(); ++i) items.push_back(v[i]);
  return items;
}

void check_keys(XmlRpcValue v, const std::set<std::string>& allowed, const std::string& where) {
  std::string names;
  for (const std::string& name : allowed) names += (names.empty() ? "" : ", ") + name;
  if (v.getType() != XmlRpcValue::TypeStruct) refuse(where, "must have keys; allowed: " + names);
  for (const auto& item : v) {
    if (!allowed.count(item.first)) refuse(where, "unknown key '" + item.first + "'; allowed: " + names);
  }
}

ArmSpec read_arm(XmlRpcValue v, const std::string& where) {
  check_keys(v, {"tip", "fingers"}, where);
  if (!v.hasMember("tip")) refuse(where, "missing key 'tip'");
  ArmSpec arm;
  arm.tip = text(v["tip"], where + ".tip");
  if (v.hasMember("fingers")) {
    for (const XmlRpcValue& name : list(v["fingers"], where + ".fingers"))
      arm.fingers.push_back(text(name, where + ".fingers"));
  }
  return arm;
}

/// Keys that are left out keep their value from the step before.
void read_goal(XmlRpcValue v, const std::string& where, Goal* goal) {
  check_keys(v, {"position", "rpy", "opening"}, where);
  if (v.hasMember("position")) goal->position = vector(v["position"], where + ".position");
  if (v.hasMember("rpy")) {
    const Eigen::Vector3d rpy = vector(v["rpy"], where + ".rpy");
    goal->orientation = Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                        Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
  }
  if (v.hasMember("opening")) goal->opening = number(v["opening"], where + ".opening");
}

/// With `feature` the named nodes; otherwise those around the origin of follow_frame: within `radius`, or the nearest.
deformable_sim::Grasp::Request read_grasp(XmlRpcValue v, const std::string& where) {
  check_keys(v, {"name", "body", "feature", "radius", "follow_frame", "max_force"}, where);
  for (const char* key : {"name", "body", "follow_frame"}) {
    if (!v.hasMember(key)) refuse(where, std::string("missing key '") + key + "'");
  }
  deformable_sim::Grasp::Request request;
  request.name = text(v["name"], where + ".name");
  request.body = text(v["body"], where + ".body");
  request.follow_frame = text(v["follow_frame"], where + ".follow_frame");
  if (v.hasMember("max_force")) request.max_force = number(v["max_force"], where + ".max_force");

  deformable_sim::GraspSelection& selection = request.selection;
  selection.pose.header.frame_id = request.follow_frame;
  selection.pose.pose.orientation.w = 1;
  if (v.hasMember("feature")) {
    selection.method = deformable_sim::GraspSelection::FEATURE;
    selection.feature = text(v["feature"], where + ".feature");
  } else if (v.hasMember("radius")) {
    selection.method = deformable_sim::GraspSelection::RADIUS;
    selection.radius = number(v["radius"], where + ".radius");
  } else {
    selection.method = deformable_sim::GraspSelection::NEAREST;
  }
  return request;
}

Step read_step(XmlRpcValue v, const Motion& motion, const std::string& where) {
  std::set<std::string> allowed{"phase", "duration", "pass", "grasp", "release"};
  for (const auto& arm : motion.arms) allowed.insert(arm.first);
  check_keys(v, allowed, where);

  Step step;
  const bool first = motion.steps.empty();
  if (v.hasMember("phase")) step.phase = text(v["phase"], where + ".phase");
  if (v.hasMember("duration")) step.duration = number(v["duration"], where + ".duration");
  if (first ? step.duration != 0 : step.duration <= 0) {
    refuse(where + ".duration",
           first ? "the first step is where the arms start: leave it out" : "must be more than 0 s");
  }
  if (v.hasMember("pass")) {
    if (v["pass"].getType() != XmlRpcValue::TypeBoolean) refuse(where + ".pass", "must be true or false");
    step.pass = static_cast<bool>(v["pass"]);
  }
  if (!first) step.goals = motion.steps.back().goals;
  for (const auto& arm : motion.arms) {
    const std::string key = where + "." + arm.first;
    if (v.hasMember(arm.first)) {
      if (first && !(v[arm.first].hasMember("position") && v[arm.first].hasMember("rpy"))) {
        refuse(key, "the first step needs position and rpy");
      }
      read_goal(v[arm.first], key, &step.goals[arm.first]);
    } else if (first) {
      refuse(where, "missing key '" + arm.first + "': the first step places every arm");
    }
  }
  if (v.hasMember("grasp")) {
    for (const XmlRpcValue& grasp : list(v["grasp"], where + ".grasp"))
      step.grasps.push_back(read_grasp(grasp, where + ".grasp"));
  }
  if (v.hasMember("release")) {
    for (const XmlRpcValue& name : list(v["release"], where + ".release"))
      step.releases.push_back(text(name, where + ".release"));
  }
  return step;
}

/// As numbers to interpolate; of the two quaternions of a rotation the one on the side of `near`.
Vector8 numbers_of(const Goal& goal, const Eigen::Quaterniond& near) {
  Vector8 y;
  const double sign = goal.orientation.dot(near) < 0 ? -1 : 1;
  y << goal.position, sign * goal.orientation.coeffs(), goal.opening;
  return y;
}

}  // namespace

Motion read_motion(XmlRpcValue tree) {
  check_keys(tree, {"frame", "arms", "steps"}, "file");
  for (const char* key : {"frame", "arms", "steps"}) {
    if (!tree.hasMember(key)) refuse("file", std::string("missing key '") + key + "'");
  }
  Motion motion;
  motion.frame = text(tree["frame"], "frame");
  if (tree["arms"].getType() != XmlRpcValue::TypeStruct) refuse("arms", "must have a key for each arm");
  for (const auto& arm : tree["arms"]) motion.arms[arm.first] = read_arm(arm.second, "arms." + arm.first);
  for (const XmlRpcValue& step : list(tree["steps"], "steps")) {
    motion.steps.push_back(read_step(step, motion, "steps[" + std::to_string(motion.steps.size()) + "]"));
  }
  if (motion.steps.empty()) refuse("steps", "must have at least one");
  return motion;
}

Goal interpolate(const Motion& motion, const std::string& arm, size_t i, double s) {
  const std::vector<Step>& steps = motion.steps;
  const Eigen::Quaterniond& near = steps[i].goals.at(arm).orientation;
  if (i == 0) return steps[0].goals.at(arm);
  const auto at = [&](size_t k) { return numbers_of(steps[k].goals.at(arm), near); };
  // Through a waypoint at the mean speed of both sides; at rest at any other.
  const auto speed = [&](size_t k) -> Vector8 {
    if (!steps[k].pass || k + 1 >= steps.size()) return Vector8::Zero();
    return (at(k + 1) - at(k - 1)) / (steps[k].duration + steps[k + 1].duration);
  };
  const double duration = steps[i].duration;
  const double u = s / duration;
  const double u3 = u * u * u, u4 = u3 * u, u5 = u4 * u;
  // Quintic Hermite with no acceleration at the ends.
  const Vector8 y = at(i - 1) + (at(i) - at(i - 1)) * (10 * u3 - 15 * u4 + 6 * u5) +
                    speed(i - 1) * duration * (u - 6 * u3 + 8 * u4 - 3 * u5) +
                    speed(i) * duration * (-4 * u3 + 7 * u4 - 3 * u5);
  Goal goal;
  goal.position = y.head<3>();
  goal.orientation.coeffs() = y.segment<4>(3).normalized();
  goal.opening = y(7);
  return goal;
}

}  // namespace robot_demo
