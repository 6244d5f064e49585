#include "deformable_sim/ros/parameters.h"

#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>
#include <vector>

#include <ros/console.h>
#include <ros/node_handle.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/saved_states.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {

namespace {

class Reader {
 public:
  explicit Reader(const ros::NodeHandle& nh) : nh_(nh) {}

  void read(const char* key, std::string* value) {
    XmlRpc::XmlRpcValue raw;
    if (!fetch(key, &raw)) return;
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeString) refuse(key, "a string is needed");
    *value = static_cast<std::string>(raw);
  }

  void read(const char* key, std::vector<std::string>* value) {
    XmlRpc::XmlRpcValue raw;
    if (!fetch(key, &raw)) return;
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeArray) refuse(key, "a list of strings is needed");
    value->clear();
    for (int k = 0; k < raw.size(); ++k) {
      if (raw[k].getType() != XmlRpc::XmlRpcValue::TypeString) refuse(key, "a list of strings is needed");
      value->push_back(static_cast<std::string>(raw[k]));
    }
  }

  void read(const char* key, std::vector<CameraParameters>* value) {
    XmlRpc::XmlRpcValue raw;
    if (fetch(key, &raw)) *value = to_cameras(raw);
  }

  void read(const char* key, bool* value) {
    XmlRpc::XmlRpcValue raw;
    if (!fetch(key, &raw)) return;
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeBoolean) refuse(key, "true or false is needed");
    *value = static_cast<bool>(raw);
  }

  void read(const char* key, int low, int high, int* value) {
    XmlRpc::XmlRpcValue raw;
    if (!fetch(key, &raw)) return;
    const std::string allowed = std::to_string(low) + " ... " + std::to_string(high);
    if (raw.getType() != XmlRpc::XmlRpcValue::TypeInt) refuse(key, "a whole number is needed, " + allowed);
    *value = static_cast<int>(raw);
    if (*value < low || *value > high) refuse(key, std::to_string(*value) + " is out of range, allowed is " + allowed);
  }

  template <typename Value>  // double or std::optional<double>
  void read_real(const char* key, double low, double high, Value* value) {
    XmlRpc::XmlRpcValue raw;
    if (!fetch(key, &raw)) return;
    std::ostringstream allowed;
    allowed << low << " ... " << high;
    double number = 0.0;
    if (raw.getType() == XmlRpc::XmlRpcValue::TypeDouble) {
      number = static_cast<double>(raw);
    } else if (raw.getType() == XmlRpc::XmlRpcValue::TypeInt) {
      number = static_cast<int>(raw);
    } else {
      refuse(key, "a number is needed, " + allowed.str());
    }
    if (!(number >= low && number <= high)) refuse(key, "out of range, allowed is " + allowed.str());
    *value = number;
  }

  [[noreturn]] static void refuse(const std::string& key, const std::string& why) {
    throw InputError("parameter ~" + key + ": " + why);
  }

  /// Private parameters that nobody reads: typing mistakes.
  std::string unknown() const {
    std::vector<std::string> names;
    nh_.getParamNames(names);
    const std::string prefix = nh_.getNamespace() + "/";
    std::set<std::string> unknown;
    for (const std::string& name : names) {
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const std::string key = name.substr(prefix.size(), name.find('/', prefix.size()) - prefix.size());
      if (known_.count(key) == 0) unknown.insert(key);
    }
    std::string list;
    for (const std::string& key : unknown) list += (list.empty() ? "~" : ", ~") + printable(key);
    return list;
  }

  std::string known() const {
    std::string list;
    for (const std::string& key : known_) list += (list.empty() ? "~" : ", ~") + key;
    return list;
  }

 private:
  bool fetch(const char* key, XmlRpc::XmlRpcValue* raw) {
    known_.insert(key);
    return nh_.getParam(key, *raw);
  }

  const ros::NodeHandle& nh_;
  // Of others under this namespace, dynamic_reconfigure among them.
  std::set<std::string> known_{
      "accuracy",  "air_damping",       "color_by",     "diagnostic_period", "friction",  "gravity_x", "gravity_y",
      "gravity_z", "robot_description", "strain_range", "stress_range",      "tolerance", "wind_x",    "wind_y",
      "wind_z"};
};

ClockMode to_clock_mode(const std::string& text) {
  for (const ClockMode mode : {ClockMode::kRealTime, ClockMode::kAsFastAsPossible, ClockMode::kOnDemand}) {
    if (text == to_string(mode)) return mode;
  }
  Reader::refuse("clock", "'" + printable(text) + "', allowed are real_time, as_fast_as_possible, on_demand");
}

LatePolicy to_late_policy(const std::string& text) {
  for (const LatePolicy policy : {LatePolicy::kSlowDown, LatePolicy::kLessAccurate, LatePolicy::kStop}) {
    if (text == to_string(policy)) return policy;
  }
  Reader::refuse("when_late", "'" + printable(text) + "', allowed are slow_down, less_accurate, stop");
}

std::string summary(const Parameters& p) {
  const auto rate = [](const std::optional<double>& value) -> std::string {
    if (!value) return "scene's";
    std::ostringstream text;
    text << *value << " Hz";
    return text.str();
  };
  std::ostringstream line;
  line << "scene " << p.scene << ", frame_id " << p.frame_id << ", clock " << to_string(p.clock)
       << (p.publish_clock ? " (publishes /clock)" : "") << ", rates: markers " << rate(p.rate_markers) << ", points "
       << rate(p.rate_points) << ", state " << rate(p.rate_state) << ", threads " << p.threads << ", tf_timeout "
       << p.tf_timeout << " s, when late " << to_string(p.when_late) << (p.start_paused ? ", starts paused" : "");
  if (p.priority > 0) line << ", real-time priority " << p.priority;
  for (const CameraParameters& camera : p.cameras) line << ", camera " << camera.name;
  return line.str();
}

}  // namespace

const char* to_string(ClockMode mode) {
  switch (mode) {
    case ClockMode::kRealTime:
      return "real_time";
    case ClockMode::kAsFastAsPossible:
      return "as_fast_as_possible";
    case ClockMode::kOnDemand:
      return "on_demand";
  }
  return "";
}

const char* to_string(LatePolicy policy) {
  switch (policy) {
    case LatePolicy::kSlowDown:
      return "slow_down";
    case LatePolicy::kLessAccurate:
      return "less_accurate";
    case LatePolicy::kStop:
      return "stop";
  }
  return "";
}

Parameters read_parameters(const ros::NodeHandle& private_nh) {
  Parameters p;
  Reader reader(private_nh);
  std::string clock = to_string(p.clock);
  p.scene_dir = default_scene_dir();
  p.state_dir = default_state_dir();
  reader.read("scene", &p.scene);
  reader.read("scene_dir", &p.scene_dir);
  p.scene_dir = std::filesystem::absolute(p.scene_dir).string();
  reader.read("allowed_dirs", &p.allowed_dirs);
  reader.read("state_dir", &p.state_dir);
  reader.read("frame_id", &p.frame_id);
  reader.read("clock", &clock);
  reader.read("publish_clock", &p.publish_clock);
  reader.read_real("rate_markers", 0.0, 1000.0, &p.rate_markers);
  reader.read_real("rate_points", 0.0, 1000.0, &p.rate_points);
  reader.read_real("rate_state", 0.0, 1000.0, &p.rate_state);
  reader.read("cameras", &p.cameras);
  reader.read("threads", 1, 64, &p.threads);
  reader.read("priority", 0, 99, &p.priority);
  std::string when_late = to_string(p.when_late);
  reader.read("when_late", &when_late);
  p.when_late = to_late_policy(when_late);
  reader.read_real("accuracy_floor", 1e-5, 1.0, &p.accuracy_floor);
  reader.read("start_paused", &p.start_paused);
  reader.read_real("tf_timeout", 0.001, 10.0, &p.tf_timeout);
  p.clock = to_clock_mode(clock);
  if (p.priority > 0 && p.clock != ClockMode::kRealTime)
    Reader::refuse("priority", "for clock real_time alone: in any other a core would be left to nothing else");
  if (p.scene.empty()) Reader::refuse("scene", "missing; a scene file, or the name of a shipped scene, is needed");
  if (p.state_dir.empty()) Reader::refuse("state_dir", "empty; a folder is needed");
  if (p.frame_id.empty() || p.frame_id[0] == '/')
    Reader::refuse("frame_id", "a tf frame without leading slash is needed");

  const std::string unknown = reader.unknown();
  if (!unknown.empty()) {
    ROS_WARN_STREAM_NAMED("parameters",
                          "unknown parameters ignored: " << unknown << " (known: " << reader.known() << ")");
  }
  ROS_INFO_STREAM_NAMED("parameters", summary(p));
  return p;
}

}  // namespace deformable_sim
