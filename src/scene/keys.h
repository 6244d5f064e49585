// The tables of all scene keys. Adding a key: a field in spec.h and one line in keys.cpp, cloth_keys.cpp,
// rope_keys.cpp or soft_keys.cpp.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/scene/spec.h"
#include "schema.h"

namespace deformable_sim {

/// Flat text of a collider before it becomes a Collider.
struct PrimitiveText {
  std::string name;
  Vec3 size{0.1, 0.1, 0.1};
  double radius = 0.1;
  double length = 0.2;
  std::string file;
  double scale = 1.0;
  PoseSpec pose;
  double friction = 0.5;
  std::string frame;
  std::vector<std::string> lets_through;
};

/// A grasp's `select` map as it stands in the file; exactly one of the first five is given.
struct SelectText {
  std::optional<std::string> feature;
  std::vector<int> nodes;
  std::optional<Vec3> nearest;
  double reach = 0.02;
  std::optional<double> radius;
  Vec3 center = Vec3::Zero();
  std::optional<Vec3> box;
  PoseSpec pose;
};

struct GraspText {
  GraspRequest request;
  SelectText select;
  std::optional<PoseSpec> pose;
};

/// An event of the script as it stands in the file; exactly one of the first four is given.
struct EventText {
  std::optional<GraspText> grasp;
  std::string release, move_grasp, move_collider;
  double at = 0.0;
  std::optional<PoseSpec> pose;
  double duration = 0.0;
};

struct TaggedTable {
  std::string tag;
  Table<PrimitiveText> table;
};

/// Refuses names in a list that are no bodies of the scene.
void check_bodies(const YamlValue& list, const std::string& path, const SceneSpec& scene);

Table<PoseSpec> pose_table();
Table<AirSpec> air_table();
Table<StepSpec> step_table();
Table<CreaseSpec> crease_table();
Table<ClothMaterialSpec> cloth_material_table();
Table<RopeMaterialSpec> rope_material_table();
Table<SoftModelSpec> box_table();
Table<SoftModelSpec> lattice_table();
Table<SoftMaterialSpec> soft_material_table();
/// Of cloth or soft bodies.
Table<BodySpec> visual_table(BodyKind kind);
/// Of cloth or ropes.
Table<BodySpec> look_table(BodyKind kind);
Table<BodySpec> cloth_table();
Table<BodySpec> rope_table();
Table<BodySpec> soft_table();
std::vector<TaggedTable> collider_tables();
Table<SelectText> select_table();
Table<GraspText> grasp_table();
Table<ForceRequest> force_table();
Table<EventText> script_table();
Table<RobotSpec> robot_table();
Table<OutputSpec> output_table();
/// The whole scene; bodies, colliders, grasps, forces and the script are read by the loader, which passes its reader
/// for each entry.
struct SceneListReaders {
  Table<SceneSpec>::Reader bodies, colliders, grasps, forces, script;
};
Table<SceneSpec> scene_table(const SceneListReaders& lists);

}  // namespace deformable_sim
