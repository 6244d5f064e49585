// Scene text to everything the node runs: world, topics, what tf moves.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <geometry_msgs/PoseStamped.h>
#include <ros/node_handle.h>

#include "deformable_sim/ros/advertiser.h"
#include "deformable_sim/ros/force_plugins.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/parameters.h"
#include "deformable_sim/ros/simulation.h"
#include "deformable_sim/scene/allowed_paths.h"

namespace deformable_sim {

class SceneLoader {
 public:
  using Drag = std::function<void(const std::string& grasp, const geometry_msgs::PoseStamped& target)>;

  SceneLoader(const ros::NodeHandle& private_nh, const Parameters& parameters, Frames* frames, Drag drag_grasp);

  /// A path, or the bare name of a scene in ~scene_dir; `files` are those that may be opened for it. Throws InputError.
  LoadedScene from_file(const std::string& file, const AllowedPaths& files) const;
  LoadedScene from_text(const std::string& yaml, const AllowedPaths& files) const;

 private:
  LoadedScene build(SceneSpec spec) const;

  ros::NodeHandle private_nh_;
  Advertiser advertiser_;  // one for all scenes of the node
  std::shared_ptr<ForcePlugin> plugins_ = std::make_shared<ForcePlugins>();
  Parameters parameters_;
  Frames* frames_;
  Drag drag_grasp_;
};

}  // namespace deformable_sim
