// Messages that are made in more than one place: by a topic and by a service.
#pragma once

#include <string>
#include <vector>

#include <ros/time.h>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/ros/messages.h"

namespace deformable_sim {

msg::BodyState body_state_message(const Snapshot& snapshot, int body, const std::string& frame_id, ros::Time stamp);

std::vector<msg::GraspState> grasp_state_messages(const Snapshot& snapshot, const std::string& frame_id,
                                                  ros::Time stamp);

/// Of the snapshot's contacts.
std::vector<msg::Contact> contact_messages(const Snapshot& snapshot);

/// Wrench in the grasp frame, about its origin.
geometry_msgs::Wrench wrench_message(const GraspReport& grasp);

}  // namespace deformable_sim
