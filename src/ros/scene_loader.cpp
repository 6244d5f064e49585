#include "deformable_sim/ros/scene_loader.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/robot_links.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {

namespace {

/// Colliders given relative to a frame enter the world when tf says where that is.
std::vector<Collider> take_attached(SceneSpec* spec) {
  const auto begin = std::stable_partition(spec->colliders.begin(), spec->colliders.end(),
                                           [](const ColliderSpec& c) { return c.collider.frame.empty(); });
  std::vector<Collider> attached;
  std::transform(begin, spec->colliders.end(), std::back_inserter(attached),
                 [](const ColliderSpec& c) { return c.collider; });
  spec->colliders.erase(begin, spec->colliders.end());
  return attached;
}

}  // namespace

SceneLoader::SceneLoader(const ros::NodeHandle& private_nh, const Parameters& parameters, Frames* frames,
                         Warnings* warnings, Drag drag_grasp)
    : private_nh_(private_nh),
      parameters_(parameters),
      frames_(frames),
      warnings_(warnings),
      drag_grasp_(std::move(drag_grasp)) {}

SceneSpec SceneLoader::read(const std::string& file, const std::string& yaml, const AllowedPaths& files) const {
  if (file.empty() == yaml.empty()) throw InputError("file, yaml: one of the two must be given, the other empty");
  if (file.empty()) return load_scene_text(yaml, "yaml", {}, files);
  return load_scene_file(find_scene(file, parameters_.scene_dir, files), {}, files);
}

LoadedScene SceneLoader::changed(SceneSpec spec, double dt) const {
  return build_for(std::move(spec), dt);
}

LoadedScene SceneLoader::shown_otherwise(SceneSpec spec, std::shared_ptr<const Model> model) const {
  LoadedScene scene;
  scene.attached = take_attached(&spec);
  scene.publishers = publishers_of(spec, std::move(model));
  scene.script = Script(spec.script);
  scene.spec = std::move(spec);
  return scene;
}

LoadedScene SceneLoader::build_for(SceneSpec spec, std::optional<double> running_dt) const {
  LoadedScene scene;
  scene.attached = take_attached(&spec);
  if (spec.robot.present) {
    std::string urdf, key;
    if (!private_nh_.searchParam("robot_description", key) || !private_nh_.getParam(key, urdf)) {
      throw InputError("robot: the scene collides with a robot, but there is no parameter robot_description",
                       Code::kUnavailable);
    }
    for (Collider& link : robot_links(urdf, spec.robot)) scene.attached.push_back(std::move(link));
  }
  const bool follows = std::any_of(spec.grasps.begin(), spec.grasps.end(),
                                   [](const GraspSpec& grasp) { return !grasp.request.follow_frame.empty(); });
  const bool looks = std::any_of(parameters_.cameras.begin(), parameters_.cameras.end(),
                                 [this](const auto& camera) { return camera.frame != parameters_.frame_id; });
  if (!scene.attached.empty() || follows || looks) frames_->open();
  scene.world = build_world(spec, parameters_.threads, plugins_, running_dt);
  scene.publishers = publishers_of(spec, scene.world->shared_model());
  scene.running_dt = running_dt;
  scene.script = Script(spec.script);
  scene.spec = std::move(spec);
  return scene;
}

std::unique_ptr<World> SceneLoader::copy_of(const Fork& fork) const {
  std::unique_ptr<World> world = build_world(fork.spec, 1, plugins_, fork.running_dt);
  world->restore(fork.world);
  return world;
}

std::shared_ptr<PublisherSet> SceneLoader::publishers_of(const SceneSpec& spec,
                                                         std::shared_ptr<const Model> model) const {
  PublisherContext context;
  context.private_nh = private_nh_;
  context.advertiser = advertiser_;
  context.frame_id = parameters_.frame_id;
  context.node_name = private_nh_.getNamespace().substr(1);
  context.model = std::move(model);
  if (parameters_.clock == ClockMode::kRealTime && !parameters_.publish_clock) context.loaded = ros::Time::now();
  context.outputs = spec.outputs;
  context.frames = frames_;
  context.warnings = warnings_;
  context.drag_grasp = drag_grasp_;
  return make_publishers(context, parameters_);
}

}  // namespace deformable_sim
