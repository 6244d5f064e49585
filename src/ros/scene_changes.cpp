#include "deformable_sim/ros/scene_changes.h"

#include <algorithm>
#include <utility>

#include "deformable_sim/scene/edit.h"

namespace deformable_sim {

namespace {

std::unique_lock<std::mutex> alone(std::mutex* mutex) {
  std::unique_lock<std::mutex> lock(*mutex, std::try_to_lock);
  if (!lock) throw InputError("another scene is being loaded, or this one changed", Code::kUnavailable);
  return lock;
}

bool is_of_outputs(const Override& value) {
  return value.first.compare(0, 8, "outputs.") == 0;
}

}  // namespace

void SceneChanges::load(const std::string& file, const std::string& yaml) {
  const auto lock = alone(&changing_);
  const SceneSpec spec = loader_->read(file, yaml, *files_);
  LoadedScene scene = loader_->build(spec);
  done(simulation_->replace(std::move(scene)), spec);
}

std::vector<std::string> SceneChanges::add_bodies(const std::string& file, const std::string& yaml,
                                                  const std::optional<Pose>& world_from_body) {
  const auto lock = alone(&changing_);
  const SceneSpec added = loader_->read(file, yaml, *files_);
  change(with_bodies(running(), added, world_from_body));
  std::vector<std::string> names;
  for (const BodySpec& body : added.bodies) names.push_back(body.name);
  return names;
}

void SceneChanges::remove_body(const std::string& name) {
  const auto lock = alone(&changing_);
  change(without_body(running(), name));
}

void SceneChanges::set_material(const std::string& body, const std::string& yaml) {
  const auto lock = alone(&changing_);
  change(with_material(running(), body, yaml));
}

void SceneChanges::set_values(const std::vector<Override>& values) {
  const auto lock = alone(&changing_);
  SceneSpec spec = with_values(running(), values);
  if (!std::all_of(values.begin(), values.end(), is_of_outputs)) return change(spec);
  done(simulation_->change(loader_->shown_otherwise(spec, simulation_->model())), spec);
}

SceneSpec SceneChanges::running() const {
  SceneSpec spec;
  const Reply reply = simulation_->scene(&spec);
  if (!reply.status.ok()) throw InputError(reply.status.message, reply.status.code);
  return spec;
}

void SceneChanges::change(const SceneSpec& spec) {
  done(simulation_->change(loader_->changed(spec, simulation_->dt())), spec);
}

void SceneChanges::done(const Reply& reply, const SceneSpec& spec) {
  if (!reply.status.ok()) throw InputError(reply.status.message, reply.status.code);
  if (changed_) changed_(spec);
}

}  // namespace deformable_sim
