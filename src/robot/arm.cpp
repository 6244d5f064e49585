#include "arm.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>

namespace robot_demo {
namespace {

constexpr double kPositionTolerance = 1e-4;  // m
constexpr double kRotationTolerance = 1e-3;  // rad
constexpr int kScatteredSeeds = 50;

}  // namespace

Arm::Arm(const KDL::Tree& tree, const urdf::Model& model, const std::string& base, const std::string& tip) {
  if (!tree.getChain(base, tip, chain_)) {
    throw std::runtime_error("robot_description has no chain from link '" + base + "' to link '" + tip + "'");
  }
  std::vector<urdf::JointLimitsSharedPtr> limits;
  for (const KDL::Segment& segment : chain_.segments) {
    if (segment.getJoint().getType() == KDL::Joint::None) continue;
    const std::string& name = segment.getJoint().getName();
    const urdf::JointConstSharedPtr joint = model.getJoint(name);
    if (!joint || !joint->limits) throw std::runtime_error("joint '" + name + "' has no limits in robot_description");
    joint_names_.push_back(name);
    velocity_limit_.push_back(joint->limits->velocity);
    limits.push_back(joint->limits);
  }
  lower_.resize(chain_.getNrOfJoints());
  upper_.resize(chain_.getNrOfJoints());
  for (unsigned int i = 0; i < chain_.getNrOfJoints(); ++i) {
    lower_(i) = limits[i]->lower;
    upper_(i) = limits[i]->upper;
  }
}

KDL::Frame Arm::base_from_tip(const KDL::JntArray& q) const {
  KDL::ChainFkSolverPos_recursive forward(chain_);
  KDL::Frame frame;
  forward.JntToCart(q, frame);
  return frame;
}

std::optional<KDL::JntArray> Arm::solve(const KDL::Frame& goal, const KDL::JntArray& seed) const {
  // Metres and a tenth of a radian weigh alike: 1e-6 m, 1e-5 rad.
  Eigen::Matrix<double, 6, 1> weight;
  weight << 1, 1, 1, 0.1, 0.1, 0.1;
  KDL::ChainIkSolverPos_LMA inverse(chain_, weight, 1e-6);
  KDL::JntArray q(chain_.getNrOfJoints());
  inverse.CartToJnt(seed, goal, q);
  // The solver's return code does not tell "arrived" from "stuck": compare where the tip is.
  const KDL::Twist error = KDL::diff(base_from_tip(q), goal);
  if (error.vel.Norm() > kPositionTolerance || error.rot.Norm() > kRotationTolerance) return std::nullopt;
  for (unsigned int i = 0; i < q.rows(); ++i) q(i) = seed(i) + std::remainder(q(i) - seed(i), 2 * M_PI);
  if (!within_limits(q)) return std::nullopt;
  return q;
}

std::optional<KDL::JntArray> Arm::solve(const KDL::Frame& goal) const {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int attempt = 0; attempt <= kScatteredSeeds; ++attempt) {
    KDL::JntArray seed(chain_.getNrOfJoints());
    for (unsigned int i = 0; i < seed.rows(); ++i) {
      const double at = attempt == 0 ? 0.5 : fraction(generator);
      seed(i) = lower_(i) + at * (upper_(i) - lower_(i));
    }
    if (auto q = solve(goal, seed)) return q;
  }
  return std::nullopt;
}

bool Arm::within_limits(const KDL::JntArray& q) const {
  for (unsigned int i = 0; i < q.rows(); ++i) {
    if (q(i) < lower_(i) || q(i) > upper_(i)) return false;
  }
  return true;
}

}  // namespace robot_demo
