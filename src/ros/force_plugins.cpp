#include "deformable_sim/ros/force_plugins.h"

#include <pluginlib/class_loader.hpp>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

ForcePlugins::ForcePlugins() = default;

ForcePlugins::~ForcePlugins() {
  plugins_.clear();  // before their libraries
}

ForcePlugin* ForcePlugins::find(const std::string& name) {
  const auto known = plugins_.find(name);
  if (known != plugins_.end()) return known->second.get();
  try {
    if (!loader_) {
      loader_ = std::make_unique<pluginlib::ClassLoader<ForcePlugin>>("deformable_sim", "deformable_sim::ForcePlugin");
    }
    if (!loader_->isClassAvailable(name)) {
      std::string there;
      for (const std::string& other : loader_->getDeclaredClasses()) there += (there.empty() ? "" : ", ") + other;
      throw InputError("no package exports a force '" + name + "'; there is " + (there.empty() ? "none" : there),
                       Code::kNotFound);
    }
    return plugins_.emplace(name, loader_->createUniqueInstance(name)).first->second.get();
  } catch (const pluginlib::PluginlibException& error) {
    throw InputError("plugin '" + name + "' cannot be loaded: " + error.what(), Code::kUnavailable);
  }
}

std::unique_ptr<Energy> ForcePlugins::make(const ForceRequest& request, const Model& model) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return find(request.plugin)->make(request, model);
}

}  // namespace deformable_sim
