#include "deformable_sim/ros/live_parameters.h"

#include <cstdio>

#include <dynamic_reconfigure/server.h>
#include <ros/console.h>

#define deformable_sim deformable_sim_msgs
#include <deformable_sim/LiveConfig.h>
#undef deformable_sim

namespace deformable_sim {

namespace {

using Config = deformable_sim_msgs::LiveConfig;

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string text_of(double x, double y, double z) {
  return "[" + text_of(x) + ", " + text_of(y) + ", " + text_of(z) + "]";
}

const char* key_of(BodyKind kind) {
  return kind == BodyKind::kRope ? "rope" : kind == BodyKind::kSoft ? "soft" : "cloth";
}

/// What is drawn beside the bodies, where it is asked for.
struct ShownPart {
  const char* key;
  bool Config::*live;
  bool OutputSpec::*scene;
};
constexpr ShownPart kShownParts[] = {
    {"outputs.wireframe", &Config::wireframe, &OutputSpec::wireframe},
    {"outputs.shadows", &Config::shadows, &OutputSpec::shadows},
    {"outputs.contact_arrows", &Config::contact_arrows, &OutputSpec::contact_arrows},
    {"outputs.legend", &Config::legend, &OutputSpec::legend},
};

Config values_of(const SceneSpec& scene) {
  Config config = Config::__getDefault__();
  config.gravity_x = scene.gravity.x();
  config.gravity_y = scene.gravity.y();
  config.gravity_z = scene.gravity.z();
  config.wind_x = scene.air.wind.x();
  config.wind_y = scene.air.wind.y();
  config.wind_z = scene.air.wind.z();
  config.air_damping = scene.air.damping;
  config.friction = scene.bodies.front().friction;
  config.accuracy = scene.step.error;
  config.tolerance = scene.step.solver.tolerance;
  config.color_by = scene.outputs.color_by;
  config.strain_range = scene.outputs.strain_range;
  config.stress_range = scene.outputs.stress_range;
  for (const ShownPart& part : kShownParts) config.*part.live = scene.outputs.*part.scene;
  return config;
}

/// What differs, as keys of the scene.
std::vector<Override> difference(const Config& from, const Config& to, const SceneSpec& scene) {
  std::vector<Override> values;
  if (from.gravity_x != to.gravity_x || from.gravity_y != to.gravity_y || from.gravity_z != to.gravity_z)
    values.emplace_back("gravity", text_of(to.gravity_x, to.gravity_y, to.gravity_z));
  if (from.wind_x != to.wind_x || from.wind_y != to.wind_y || from.wind_z != to.wind_z)
    values.emplace_back("air.wind", text_of(to.wind_x, to.wind_y, to.wind_z));
  if (from.air_damping != to.air_damping) values.emplace_back("air.damping", text_of(to.air_damping));
  for (std::size_t b = 0; b < scene.bodies.size() && from.friction != to.friction; ++b)
    values.emplace_back("bodies[" + std::to_string(b) + "]." + key_of(scene.bodies[b].kind) + ".friction",
                        text_of(to.friction));
  if (from.accuracy != to.accuracy) values.emplace_back("step.accuracy", text_of(to.accuracy));
  if (from.tolerance != to.tolerance) {
    if (scene.step.mode == SolverMode::kAuto)
      throw InputError("tolerance: the scene leaves the solver open (auto); set accuracy");
    values.emplace_back("step.tolerance", text_of(to.tolerance));
  }
  if (from.color_by != to.color_by) values.emplace_back("outputs.color_by", "\"" + to.color_by + "\"");
  if (from.strain_range != to.strain_range) values.emplace_back("outputs.strain_range", text_of(to.strain_range));
  if (from.stress_range != to.stress_range) values.emplace_back("outputs.stress_range", text_of(to.stress_range));
  for (const ShownPart& part : kShownParts) {
    if (from.*part.live != to.*part.live) values.emplace_back(part.key, to.*part.live ? "true" : "false");
  }
  return values;
}

/// The server reads what lies on the parameter server when it is made: that is overwritten first.
ros::NodeHandle with_values(ros::NodeHandle nh, const Config& config) {
  config.__toServer__(nh);
  return nh;
}

}  // namespace

class LiveParameters::Server {
 public:
  Server(const ros::NodeHandle& nh, const SceneSpec& scene, SceneChanges* changes, Warnings* warnings)
      : changes_(changes),
        warnings_(warnings),
        scene_(scene),
        now_(values_of(scene)),
        server_(mutex_, with_values(nh, now_)) {
    server_.setCallback([this](Config& config, std::uint32_t) { set(&config); });
  }

  void show(const SceneSpec& scene) {
    const std::lock_guard<boost::recursive_mutex> lock(mutex_);
    scene_ = scene;
    now_ = values_of(scene);
    if (!setting_) server_.updateConfig(now_);
  }

 private:
  void set(Config* config) {
    setting_ = true;
    try {
      const std::vector<Override> values = difference(now_, *config, scene_);
      if (!values.empty()) changes_->set_values(values);
      warnings_->clear("reconfigure");
    } catch (const InputError& error) {
      const std::string text = std::string("reconfigure: ") + error.what();
      warnings_->set("reconfigure", text);
      ROS_WARN_STREAM_NAMED("reconfigure", text);
    }
    setting_ = false;
    *config = now_;
  }

  SceneChanges* changes_;
  Warnings* warnings_;
  boost::recursive_mutex mutex_;
  SceneSpec scene_;
  Config now_;
  bool setting_ = false;
  dynamic_reconfigure::Server<Config> server_;
};

LiveParameters::LiveParameters(const ros::NodeHandle& private_nh, SceneChanges* changes, Warnings* warnings)
    : nh_(private_nh), changes_(changes), warnings_(warnings) {}
LiveParameters::~LiveParameters() = default;

void LiveParameters::start(const SceneSpec& scene) {
  server_ = std::make_unique<Server>(nh_, scene, changes_, warnings_);
  changes_->tell([this](const SceneSpec& changed) { server_->show(changed); });
}

}  // namespace deformable_sim
