#include "plan.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace robot_demo {
namespace {

KDL::Frame frame_of(const Goal& goal) {
  const Eigen::Quaterniond& q = goal.orientation;
  const Eigen::Vector3d& p = goal.position;
  return KDL::Frame(KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()), KDL::Vector(p.x(), p.y(), p.z()));
}

[[noreturn]] void refuse(const Motion& motion, size_t i, const std::string& arm, const std::string& what) {
  throw std::runtime_error("motion: steps[" + std::to_string(i) + "] '" + motion.steps[i].phase + "', arm '" + arm +
                           "': " + what);
}

std::string pose_text(const Goal& goal, const std::string& frame) {
  std::ostringstream out;
  out.precision(3);
  out << "position [" << goal.position.x() << ", " << goal.position.y() << ", " << goal.position.z() << "] m in '"
      << frame << "'";
  return out.str();
}

/// Throws for the first waypoint that is out of reach from anywhere: a clearer word than what goes wrong on the way
/// there.
void check_waypoints(const Motion& motion, const std::string& name, const Arm& arm) {
  for (size_t i = 0; i < motion.steps.size(); ++i) {
    const Goal& goal = motion.steps[i].goals.at(name);
    if (!arm.solve(frame_of(goal))) {
      refuse(motion, i, name, "cannot reach " + pose_text(goal, motion.frame) + " with this orientation");
    }
  }
}

/// Joint positions of one arm along the motion, one row a sample.
std::vector<std::vector<double>> solve_arm(const Motion& motion, const std::string& name, const Arm& arm,
                                           const std::vector<size_t>& step_end, double rate) {
  std::vector<std::vector<double>> rows;
  KDL::JntArray q;
  for (size_t i = 0; i < motion.steps.size(); ++i) {
    const size_t begin = i == 0 ? 0 : step_end[i - 1] + 1;
    for (size_t sample = begin; sample <= step_end[i]; ++sample) {
      const double s = i == 0 ? 0 : static_cast<double>(sample - step_end[i - 1]) / rate;
      const Goal goal = interpolate(motion, name, i, std::min(s, motion.steps[i].duration));
      const auto solution = rows.empty() ? arm.solve(frame_of(goal)) : arm.solve(frame_of(goal), q);
      if (!solution) {
        refuse(motion, i, name, "cannot pass " + pose_text(goal, motion.frame) + " on the way there");
      }
      for (unsigned int k = 0; k < solution->rows() && !rows.empty(); ++k) {
        const double speed = std::abs((*solution)(k)-q(k)) * rate;
        if (speed > arm.velocity_limit(k)) {
          refuse(motion, i, name,
                 "needs " + std::to_string(speed) + " rad/s of joint '" + arm.joint_names()[k] + "', limit " +
                     std::to_string(arm.velocity_limit(k)) + ": give it more time");
        }
      }
      q = *solution;
      rows.emplace_back(q.data.data(), q.data.data() + q.rows());
    }
  }
  return rows;
}

}  // namespace

Plan make_plan(const Motion& motion, const std::map<std::string, Arm>& arms, const urdf::Model& model, double rate) {
  Plan plan;
  for (const Step& step : motion.steps) {
    const size_t before = plan.step_end.empty() ? 0 : plan.step_end.back();
    plan.step_end.push_back(before + static_cast<size_t>(std::lround(step.duration * rate)));
  }
  plan.positions.resize(plan.step_end.back() + 1);

  for (const auto& [name, spec] : motion.arms) {
    const Arm& arm = arms.at(name);
    check_waypoints(motion, name, arm);
    const auto rows = solve_arm(motion, name, arm, plan.step_end, rate);
    plan.joint_names.insert(plan.joint_names.end(), arm.joint_names().begin(), arm.joint_names().end());
    for (size_t k = 0; k < rows.size(); ++k) {
      plan.positions[k].insert(plan.positions[k].end(), rows[k].begin(), rows[k].end());
    }
    for (const std::string& finger : spec.fingers) {
      const urdf::JointConstSharedPtr joint = model.getJoint(finger);
      if (!joint || !joint->limits)
        throw std::runtime_error("motion: robot_description has no finger joint '" + finger + "'");
      plan.joint_names.push_back(finger);
      size_t i = 0;
      for (size_t sample = 0; sample < plan.positions.size(); ++sample) {
        while (sample > plan.step_end[i]) ++i;
        const double s = i == 0 ? 0 : static_cast<double>(sample - plan.step_end[i - 1]) / rate;
        const double half = interpolate(motion, name, i, std::min(s, motion.steps[i].duration)).opening / 2;
        if (half < joint->limits->lower || half > joint->limits->upper) {
          refuse(motion, i, name,
                 "opening " + std::to_string(2 * half) + " m is beyond joint '" + finger + "', at most " +
                     std::to_string(2 * joint->limits->upper) + " m");
        }
        plan.positions[sample].push_back(half);
      }
    }
  }
  return plan;
}

}  // namespace robot_demo
