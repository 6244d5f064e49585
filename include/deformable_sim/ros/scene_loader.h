// Scene text to everything the node runs: world, topics, what tf moves.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <geometry_msgs/PoseStamped.h>
#include <ros/node_handle.h>

#include "deformable_sim/ros/advertiser.h"
#include "deformable_sim/ros/force_plugins.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/parameters.h"
#include "deformable_sim/ros/simulation.h"
#include "deformable_sim/ros/warnings.h"
#include "deformable_sim/scene/allowed_paths.h"

namespace deformable_sim {

class SceneLoader {
 public:
  using Drag = std::function<void(const std::string& grasp, const geometry_msgs::PoseStamped& target)>;

  SceneLoader(const ros::NodeHandle& private_nh, const Parameters& parameters, Frames* frames, Warnings* warnings,
              Drag drag_grasp);

  /// What stands in one of the two, the other being empty: in a file, a path or the bare name of a scene in ~scene_dir,
  /// or in a text. `files` are those that may be opened for it. All throw InputError.
  SceneSpec read(const std::string& file, const std::string& yaml, const AllowedPaths& files) const;
  LoadedScene build(SceneSpec spec) const { return build_for(std::move(spec), {}); }
  /// For Simulation::change(): of a scene whose steps take dt s.
  LoadedScene changed(SceneSpec spec, double dt) const;
  /// The same where only its outputs have changed; `model` is the running one.
  LoadedScene shown_otherwise(SceneSpec spec, std::shared_ptr<const Model> model) const;

  /// On one thread.
  std::unique_ptr<World> copy_of(const Fork& fork) const;

 private:
  LoadedScene build_for(SceneSpec spec, std::optional<double> running_dt) const;
  /// Topics of the scene.
  std::shared_ptr<PublisherSet> publishers_of(const SceneSpec& spec, std::shared_ptr<const Model> model) const;

  ros::NodeHandle private_nh_;
  Advertiser advertiser_;  // one for all scenes of the node
  std::shared_ptr<ForcePlugin> plugins_ = std::make_shared<ForcePlugins>();
  Parameters parameters_;
  Frames* frames_;
  Warnings* warnings_;
  Drag drag_grasp_;
};

}  // namespace deformable_sim
