// Forces from other packages, by pluginlib.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "deformable_sim/core/force_plugin.h"

namespace pluginlib {
template <class T>
class ClassLoader;
}

namespace deformable_sim {

/// Loads each class when a scene first names it. Libraries stay loaded as long as this lives, for the terms that they
/// made are code of theirs.
class ForcePlugins : public ForcePlugin {
 public:
  ForcePlugins();
  ~ForcePlugins() override;
  ForcePlugins(const ForcePlugins&) = delete;
  ForcePlugins& operator=(const ForcePlugins&) = delete;

  /// Throws InputError where no package exports the class, naming those that are, where its library cannot be loaded,
  /// and what the plugin throws.
  std::unique_ptr<Energy> make(const ForceRequest& request, const Model& model) override;

 private:
  ForcePlugin* find(const std::string& name);

  std::mutex mutex_;                                             // copies of a world are built on threads of their own
  std::unique_ptr<pluginlib::ClassLoader<ForcePlugin>> loader_;  // when first needed: it looks through all packages
  std::map<std::string, std::shared_ptr<ForcePlugin>> plugins_;
};

}  // namespace deformable_sim
