// One arm of a robot described by a URDF: forward and inverse kinematics with KDL.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <urdf/model.h>
#include <kdl/chain.hpp>
#include <kdl/frames.hpp>
#include <kdl/jntarray.hpp>
#include <kdl/tree.hpp>

namespace robot_demo {

class Arm {
 public:
  /// The joints between two links. Throws std::runtime_error when the links are not connected or a joint has no limits.
  Arm(const KDL::Tree& tree, const urdf::Model& model, const std::string& base, const std::string& tip);

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  double velocity_limit(size_t joint) const { return velocity_limit_[joint]; }  // rad/s

  KDL::Frame base_from_tip(const KDL::JntArray& q) const;

  /// The joint angles (rad) nearest to `seed` that bring the tip to a pose, within limits; nothing when there are none.
  std::optional<KDL::JntArray> solve(const KDL::Frame& base_from_tip, const KDL::JntArray& seed) const;

  /// The same without a seed: starts from the middle of the ranges, then from scattered points.
  std::optional<KDL::JntArray> solve(const KDL::Frame& base_from_tip) const;

 private:
  bool within_limits(const KDL::JntArray& q) const;

  KDL::Chain chain_;
  std::vector<std::string> joint_names_;
  KDL::JntArray lower_, upper_;  // rad
  std::vector<double> velocity_limit_;
};

}  // namespace robot_demo
