// Folds a towel with a two-armed robot: the example of how a robot stack uses deformable_sim.
//
// The simulation is told nothing about the robot but tf frames. This node plays a motion (parameter ~motion, see
// config/demo) as joint states; robot_state_publisher turns them into tf; and at the waypoints that say so it calls the
// simulation's services `grasp` (with follow_frame: the gripper's frame) and `release`.
//
//   robot_demo           plays the motion once, then holds still
//   robot_demo --check   only says whether the robot can do it
//
// Exit codes: 0 told to end, 1 the simulation refused or did not answer, 2 the motion or the robot was refused.
#include <algorithm>
#include <iostream>

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/String.h>
#include <kdl_parser/kdl_parser.hpp>

#include "deformable_sim/Release.h"
#include "plan.h"

namespace {

using namespace robot_demo;

constexpr double kRate = 100.0;  // Hz, of the joint states
constexpr int kGraspAttempts = 3;
constexpr double kGraspPause = 0.5;  // s, between attempts

class Demo {
 public:
  Demo(const Motion& motion, const Plan& plan) : motion_(motion), plan_(plan), private_("~") {
    const std::string simulation = private_.param<std::string>("simulation", "deformable_sim");
    deadline_ = private_.param("timeout", 30.0);
    joint_states_ = node_.advertise<sensor_msgs::JointState>("joint_states", 10);
    phase_ = private_.advertise<std_msgs::String>("phase", 10, true);
    grasp_ = node_.serviceClient<deformable_sim::Grasp>(simulation + "/grasp");
    release_ = node_.serviceClient<deformable_sim::Release>(simulation + "/release");
  }

  /// Plays the motion, then holds still until it is told to end. False when the simulation refused.
  bool run() {
    if (!wait_for_simulation()) return false;
    size_t sample = 0;
    for (size_t i = 0; i < motion_.steps.size(); ++i) {
      // From where the last step ended: what grasping took is not made up for by moving faster.
      const ros::Time start = ros::Time::now();
      const size_t begin = sample;
      while (sample < plan_.step_end[i]) {
        wait_a_sample();
        if (!ros::ok()) return false;
        const double elapsed = (ros::Time::now() - start).toSec();
        sample = std::min(begin + static_cast<size_t>(std::max(0.0, elapsed) * kRate), plan_.step_end[i]);
        show(sample);
      }
      if (!arrive(motion_.steps[i], sample)) return false;
    }
    while (ros::ok()) {
      show(sample);
      wait_a_sample();
    }
    return true;
  }

 private:
  void show(size_t sample) {
    sensor_msgs::JointState message;
    message.header.stamp = ros::Time::now();
    message.name = plan_.joint_names;
    message.position = plan_.positions[sample];
    joint_states_.publish(message);
    ros::spinOnce();
  }

  /// One sample of ROS time, which may be simulated.
  void wait_a_sample() { ros::Duration(1.0 / kRate).sleep(); }

  bool wait_for_simulation() {
    // Wall time: without the simulation there may be no clock. The robot is shown where it starts.
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(deadline_);
    const bool wait_for_listener = private_.param("wait_for_listener", false);
    while (ros::ok() && ros::WallTime::now() < end) {
      if (grasp_.exists() && release_.exists() && (!wait_for_listener || phase_.getNumSubscribers() > 0)) return true;
      show(0);
      ros::WallDuration(1.0 / kRate).sleep();
    }
    if (ros::ok()) {
      ROS_ERROR("No service %s after %.0f s: is the simulation running?", grasp_.getService().c_str(), deadline_);
    }
    return false;
  }

  /// What a waypoint asks for when it is reached.
  bool arrive(const Step& step, size_t sample) {
    for (const auto& request : step.grasps) {
      if (!grasp(request, sample)) return false;
    }
    for (const std::string& name : step.releases) {
      if (!release(name)) return false;
    }
    if (!step.phase.empty()) {
      ROS_INFO("%s", step.phase.c_str());
      std_msgs::String message;
      message.data = step.phase;
      phase_.publish(message);
    }
    return true;
  }

  bool grasp(const deformable_sim::Grasp::Request& request, size_t sample) {
    deformable_sim::Grasp call;
    call.request = request;
    for (int attempt = 1; attempt <= kGraspAttempts && ros::ok(); ++attempt) {
      call.request.selection.pose.header.stamp = ros::Time(0);  // the latest pose of the frame
      if (!grasp_.call(call)) {
        ROS_ERROR("%s did not answer", grasp_.getService().c_str());
        return false;
      }
      if (call.response.status.code == deformable_sim::Status::OK) {
        ROS_INFO("Grasp '%s' holds %zu nodes of '%s'", request.name.c_str(), call.response.nodes.size(),
                 request.body.c_str());
        return true;
      }
      ROS_WARN("Grasp '%s' refused (attempt %d of %d): %s", request.name.c_str(), attempt, kGraspAttempts,
               call.response.status.message.c_str());
      for (int k = 0; k < kGraspPause * kRate && ros::ok(); ++k) {
        wait_a_sample();
        show(sample);
      }
    }
    if (ros::ok()) {
      ROS_ERROR("Giving up: grasp '%s' was refused; letting go of everything", request.name.c_str());
      release("");
    }
    return false;
  }

  /// An empty name lets go of everything.
  bool release(const std::string& name) {
    deformable_sim::Release call;
    call.request.name = name;
    if (!release_.call(call)) {
      ROS_ERROR("%s did not answer", release_.getService().c_str());
      return false;
    }
    if (call.response.status.code == deformable_sim::Status::OK) return true;
    ROS_ERROR("Release of '%s' refused: %s", name.c_str(), call.response.status.message.c_str());
    return false;
  }

  const Motion& motion_;
  const Plan& plan_;
  ros::NodeHandle node_, private_;
  double deadline_ = 0;  // s
  ros::Publisher joint_states_, phase_;
  ros::ServiceClient grasp_, release_;
};

Motion load_motion() {
  XmlRpc::XmlRpcValue tree;
  if (!ros::param::get("~motion", tree)) {
    throw std::runtime_error("parameter ~motion is missing: load a file of config/demo into it with rosparam");
  }
  return read_motion(tree);
}

Plan plan_motion(const Motion& motion) {
  urdf::Model model;
  KDL::Tree tree;
  if (!model.initParam("robot_description") || !kdl_parser::treeFromUrdfModel(model, tree)) {
    throw std::runtime_error("parameter robot_description is missing or no URDF");
  }
  std::map<std::string, Arm> arms;
  for (const auto& [name, spec] : motion.arms) arms.emplace(name, Arm(tree, model, motion.frame, spec.tip));
  return make_plan(motion, arms, model, kRate);
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "robot_demo");
  ros::NodeHandle node;
  try {
    const Motion motion = load_motion();
    const Plan plan = plan_motion(motion);
    if (argc > 1 && std::string(argv[1]) == "--check") {
      std::cout << "reachable: " << motion.steps.size() << " steps, " << plan.positions.size() / kRate << " s, "
                << plan.joint_names.size() << " joints\n";
      return 0;
    }
    return Demo(motion, plan).run() ? 0 : 1;
  } catch (const std::runtime_error& error) {
    ROS_ERROR("%s", error.what());
    return 2;
  }
}
