// Everything that gives the running simulation another scene, or changes the one it has.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "deformable_sim/ros/scene_loader.h"
#include "deformable_sim/ros/simulation.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {

/// Scenes are read and worlds are built on the caller's thread, one at a time, while the simulation goes on; only
/// putting the new world in the place of the old one is done between two steps. All throw InputError, and have then
/// changed nothing; kUnavailable while another change is being made.
class SceneChanges {
 public:
  using Changed = std::function<void(const SceneSpec&)>;

  SceneChanges(Simulation* simulation, const SceneLoader* loader, const AllowedPaths* files)
      : simulation_(simulation), loader_(loader), files_(files) {}
  /// Who is told the new scene after every change. Before the first one.
  void tell(Changed changed) { changed_ = std::move(changed); }

  /// One of file and text, the other empty; the simulation begins anew.
  void load(const std::string& file, const std::string& yaml);
  /// Names of the bodies that came. world_from_body: of one body alone.
  std::vector<std::string> add_bodies(const std::string& file, const std::string& yaml,
                                      const std::optional<Pose>& world_from_body);
  void remove_body(const std::string& name);
  void set_material(const std::string& body, const std::string& yaml);
  /// Keys of the scene. Those of `outputs` alone leave the world as it is.
  void set_values(const std::vector<Override>& values);

 private:
  SceneSpec running() const;
  void change(const SceneSpec& spec);
  void done(const Reply& reply, const SceneSpec& spec);

  Simulation* simulation_;
  const SceneLoader* loader_;
  const AllowedPaths* files_;
  Changed changed_;
  std::mutex changing_;
};

}  // namespace deformable_sim
