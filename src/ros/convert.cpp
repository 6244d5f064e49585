#include "deformable_sim/ros/convert.h"

#include <cctype>
#include <cmath>

namespace deformable_sim {

namespace {

constexpr double kFarthest = 1e6;  // m; beyond it float32 outputs lose a decimetre
constexpr double kNormTolerance = 1e-3;
constexpr std::size_t kLongestName = 64;

}  // namespace

std::string printable(const std::string& text, std::size_t limit) {
  std::string shown;
  for (const char c : text.substr(0, limit)) shown += std::iscntrl(static_cast<unsigned char>(c)) ? '?' : c;
  return text.size() > limit ? shown + "..." : shown;
}

void check_name(const std::string& what, const std::string& name) {
  bool good = !name.empty() && name.size() <= kLongestName && std::isalpha(static_cast<unsigned char>(name[0]));
  for (const char c : name) good = good && (std::isalnum(static_cast<unsigned char>(c)) || c == '_') && !(c & 0x80);
  if (good) return;
  throw InputError(what + " '" + printable(name) + "': a letter, then letters, digits or underscores, at most " +
                   std::to_string(kLongestName) + " characters");
}

Pose to_pose(const geometry_msgs::Pose& pose, const std::string& what) {
  const Vec3 p(pose.position.x, pose.position.y, pose.position.z);
  if (!p.allFinite()) throw InputError(what + ": position is not finite");
  if (p.cwiseAbs().maxCoeff() > kFarthest) {
    throw InputError(what + ": position farther than 1e6 m", Code::kOutOfRange);
  }
  const Eigen::Quaterniond q(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z);
  if (!q.coeffs().allFinite()) throw InputError(what + ": orientation is not finite");
  const double norm = q.norm();
  if (norm == 0.0) throw InputError(what + ": orientation is all zero; no rotation is w = 1");
  if (std::abs(norm - 1.0) > kNormTolerance) {
    throw InputError(what + ": orientation has norm " + std::to_string(norm) + ", a unit quaternion is needed");
  }
  return Eigen::Translation3d(p) * q.normalized();
}

bool to_pose(const geometry_msgs::Transform& transform, Pose* pose) {
  const Vec3 p(transform.translation.x, transform.translation.y, transform.translation.z);
  const Eigen::Quaterniond q(transform.rotation.w, transform.rotation.x, transform.rotation.y, transform.rotation.z);
  if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kFarthest || !q.coeffs().allFinite()) return false;
  if (std::abs(q.norm() - 1.0) > kNormTolerance) return false;
  *pose = Eigen::Translation3d(p) * q.normalized();
  return true;
}

double to_non_negative(double value, const std::string& what) {
  if (!std::isfinite(value)) throw InputError(what + ": not finite; 0 or more is allowed");
  if (value < 0.0) throw InputError(what + ": " + std::to_string(value) + ", 0 or more is allowed", Code::kOutOfRange);
  return value;
}

geometry_msgs::Point to_point(const Vec3& v) {
  geometry_msgs::Point m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

geometry_msgs::Vector3 to_vector(const Vec3& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

geometry_msgs::Pose to_message(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  geometry_msgs::Pose m;
  m.position = to_point(pose.translation());
  m.orientation.w = q.w();
  m.orientation.x = q.x();
  m.orientation.y = q.y();
  m.orientation.z = q.z();
  return m;
}

}  // namespace deformable_sim
