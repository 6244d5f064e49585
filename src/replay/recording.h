// A bag in which a session of the node was recorded.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <ros/time.h>

#include "deformable_sim/core/command.h"
#include "deformable_sim/ros/messages.h"

namespace deformable_sim {

struct RecordedState {
  std::string body;
  Nodes x, v;  // m, m/s
};

struct Recording {
  std::string topic;                               // of the records: /deformable_sim/session
  std::vector<msg::SessionRecord> records;         // in their order, none missing
  std::multimap<ros::Time, RecordedState> states;  // by stamp
};

/// `node`: whose session, where the bag has several. Throws InputError: no bag, no session in it, of another version of
/// the messages, a record that is missing, a state that is none.
Recording read_recording(const std::string& path, const std::string& node);

}  // namespace deformable_sim
