// Between ROS messages and core types, with the checks that anything from the network needs.
#pragma once

#include <string>

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/Vector3.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Names become topic names and tf frames: a letter, then letters, digits, underscores, at most 64 in all.
/// Throws InputError (kInvalidArgument); `what` says whose name it is.
void check_name(const std::string& what, const std::string& name);

/// Rigid transform of a message. Throws InputError when a number is not finite, a coordinate is beyond 1e6 m, or the
/// quaternion's norm is off by more than 1e-3 (all zero included); smaller errors are normalised away.
Pose to_pose(const geometry_msgs::Pose& pose, const std::string& what);

/// tf's own transforms: null when not finite or not a rotation within 1e-3.
bool to_pose(const geometry_msgs::Transform& transform, Pose* pose);

/// Throws InputError unless value is finite and >= 0.
double to_non_negative(double value, const std::string& what);

geometry_msgs::Point to_point(const Vec3& v);
geometry_msgs::Vector3 to_vector(const Vec3& v);
geometry_msgs::Pose to_message(const Pose& pose);

/// Fills any Status-like message (code, message).
template <typename StatusMessage>
void fill(const Status& status, StatusMessage* message) {
  message->code = static_cast<unsigned char>(status.code);
  message->message = status.message;
}

/// For log lines and answers: at most `limit` characters, control characters replaced, so that a hostile name cannot
/// flood or garble a terminal.
std::string printable(const std::string& text, std::size_t limit = 80);

}  // namespace deformable_sim
