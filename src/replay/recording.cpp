#include "recording.h"

#include <algorithm>
#include <set>

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

const std::string kSession = "/session";
const std::string kState = "/state";

template <class Message>
boost::shared_ptr<Message> read(const rosbag::MessageInstance& instance) {
  auto message = instance.instantiate<Message>();
  if (!message) throw InputError(instance.getTopic() + ": recorded with messages of another version of the package");
  return message;
}

Nodes to_nodes(const std::vector<double>& values, const std::string& topic) {
  if (values.size() % 3 != 0) throw InputError(topic + ": a state of which a third is missing");
  return Eigen::Map<const Nodes>(values.data(), 3, static_cast<Eigen::Index>(values.size() / 3));
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The topic of the session that is wanted.
std::string session_topic(const rosbag::Bag& bag, const std::string& node) {
  std::set<std::string> topics;
  rosbag::View view(bag, rosbag::TypeQuery("deformable_sim/SessionRecord"));
  for (const rosbag::ConnectionInfo* connection : view.getConnections())
    if (ends_with(connection->topic, kSession)) topics.insert(connection->topic);
  if (!node.empty()) {
    const std::string topic = (node[0] == '/' ? "" : "/") + node + kSession;
    if (topics.count(topic) == 0) throw InputError("the bag has no " + topic, Code::kNotFound);
    return topic;
  }
  if (topics.empty())
    throw InputError("the bag has no session: record ~session of the node beside ~<body>/state", Code::kNotFound);
  if (topics.size() == 1) return *topics.begin();
  std::string list;
  for (const std::string& topic : topics)
    list += (list.empty() ? "" : ", ") + topic.substr(1, topic.size() - 1 - kSession.size());
  throw InputError("the bag has the sessions of several nodes; --node one of " + list);
}

void sort_records(std::vector<msg::SessionRecord>* records) {
  std::sort(records->begin(), records->end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  // What is recorded from the middle on begins with the next whole simulation.
  const auto begin =
      std::find_if(records->begin(), records->end(), [](const auto& r) { return r.kind == msg::SessionRecord::BEGIN; });
  records->erase(records->begin(), begin);
  if (records->empty()) throw InputError("the bag has no beginning of a session");
  for (size_t k = 1; k < records->size(); ++k) {
    if ((*records)[k].number != (*records)[k - 1].number + 1)
      throw InputError("record " + std::to_string((*records)[k - 1].number + 1) +
                       " is missing: whoever recorded did not keep up, or there were two nodes");
  }
}

}  // namespace

Recording read_recording(const std::string& path, const std::string& node) {
  try {
    const rosbag::Bag bag(path, rosbag::bagmode::Read);
    Recording recording;
    recording.topic = session_topic(bag, node);
    const std::string prefix = recording.topic.substr(0, recording.topic.size() - kSession.size() + 1);
    rosbag::View view(bag);
    for (const rosbag::MessageInstance& instance : view) {
      const std::string& topic = instance.getTopic();
      if (topic == recording.topic) {
        recording.records.push_back(*read<msg::SessionRecord>(instance));
      } else if (topic.compare(0, prefix.size(), prefix) == 0 && ends_with(topic, kState)) {
        const auto state = read<msg::BodyState>(instance);
        recording.states.emplace(state->header.stamp, RecordedState{state->body, to_nodes(state->positions, topic),
                                                                    to_nodes(state->velocities, topic)});
      }
    }
    sort_records(&recording.records);
    return recording;
  } catch (const rosbag::BagException& error) {
    throw InputError(path + ": " + error.what(), Code::kNotFound);
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what(), error.code());
  } catch (const ros::Exception& error) {
    throw InputError(path + ": " + error.what());
  }
}

}  // namespace deformable_sim
