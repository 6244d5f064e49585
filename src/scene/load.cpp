#include "deformable_sim/scene/load.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "body_rules.h"
#include "build_parts.h"
#include "deformable_sim/scene/collider_file.h"
#include "deformable_sim/scene/octomap_file.h"
#include "deformable_sim/scene/tet_mesh_file.h"
#include "features.h"
#include "keys.h"
#include "scene_tree.h"

namespace deformable_sim {
namespace {

Location location_of(const YamlValue& value) {
  return {value.origin, value.line};
}

std::string indexed(const std::string& path, size_t k) {
  return path + "[" + std::to_string(k) + "]";
}

std::string resolve_mesh(const std::string& mesh, const std::string& scene_file) {
  const std::string scheme = "package://deformable_sim/";
  if (mesh.compare(0, scheme.size(), scheme) == 0) return package_dir() + "/" + mesh.substr(scheme.size());
  const std::filesystem::path path(mesh);
  if (path.is_absolute()) return mesh;
  return (std::filesystem::path(scene_file).parent_path() / path).lexically_normal().string();
}

/// Reads the lists of a scene: entries need their neighbours (unique names, bodies that grasps refer to).
class SceneReader {
 public:
  SceneReader(std::string scene_file, const AllowedPaths& files) : scene_file_(std::move(scene_file)), files_(files) {}

  void read(const YamlValue& root, SceneSpec* scene) {
    const SceneListReaders lists{
        [this](const YamlValue& v, const std::string& path, SceneSpec* out) { read_bodies(v, path, out); },
        [this](const YamlValue& v, const std::string& path, SceneSpec* out) { read_colliders(v, path, out); },
        [this](const YamlValue& v, const std::string& path, SceneSpec* out) { read_grasps(v, path, out); },
        [](const YamlValue& v, const std::string& path, SceneSpec* out) { read_forces(v, path, out); },
        [this](const YamlValue& v, const std::string& path, SceneSpec* out) { read_script(v, path, out); }};
    scene_table(lists).read(root, "", scene);
    if (const YamlValue* step = root.find("step")) choose_mode(*step, &scene->step);
  }

 private:
  /// A scene that names a part of the solver names all of it.
  static void choose_mode(const YamlValue& given, StepSpec* step) {
    const YamlValue *part = nullptr, *wish = nullptr;  // the first of each
    for (const YamlValue& item : given.items) {
      const bool wishes = item.key == "accuracy" || item.key == "budget";
      if (item.key == "solver" || item.key == "dt" || item.key == "control") continue;
      if (item.key == "accuracy" && step->control != StepControl::kFixed) continue;
      if (item.key == "budget" && step->control == StepControl::kBudget) continue;
      if (item.key == "accuracy_floor" && step->control != StepControl::kBudget) {
        refuse_key(item, "step.accuracy_floor", "belongs to control: budget");
      }
      if (item.key == "accuracy_floor") continue;
      const YamlValue*& first = wishes ? wish : part;
      if (first == nullptr) first = &item;
    }
    if (part != nullptr && step->mode == SolverMode::kAuto) {
      if (given.find("solver") != nullptr) {
        refuse_key(*part, "step." + part->key, "solver: auto chooses it; leave out one of the two");
      }
      step->mode = SolverMode::kManual;
    }
    if (wish != nullptr && step->mode == SolverMode::kManual) {
      refuse_key(*wish, "step." + wish->key,
                 "belongs to solver: auto or a control; " +
                     std::string(part != nullptr ? "step." + part->key : "manual") + " rules it out");
    }
  }

  void read_bodies(const YamlValue& list, const std::string& path, SceneSpec* scene) {
    const std::vector<YamlValue>& items = read_list(list, path, "bodies");
    if (items.empty()) refuse(list, path, "must hold at least one body: cloth, rope or soft");
    double nodes = 0.0, vertices = 0.0;
    for (size_t k = 0; k < items.size(); ++k) {
      const YamlValue& entry = read_tagged(items[k], indexed(path, k), {"cloth", "rope", "soft"});
      const std::string entry_path = indexed(path, k) + "." + entry.key;
      BodySpec body;
      body.where = location_of(items[k]);
      read_body(entry, entry_path, &body);
      check_unique(entry, entry_path, body.name, &body_names_);
      check_body(entry, entry_path, body);
      if (!body.pins.empty()) body.pins_where = location_of(*entry.find("pins"));
      if (!body.mesh.empty()) body.mesh_where = location_of(*entry.find("mesh"));
      nodes += expected_nodes(body);
      if (nodes > kMaxNodes) {
        refuse(entry, entry_path,
               format_number(nodes) + " nodes so far; at most " + std::to_string(kMaxNodes) + " in a scene",
               Code::kOutOfRange);
      }
      vertices += expected_skin_vertices(body);
      if (vertices > kMaxSkinVertices) {
        refuse(*entry.find("visual"), entry_path + ".visual.upsample",
               format_number(vertices) + " vertices of visual surfaces so far; at most " +
                   std::to_string(kMaxSkinVertices) + " in a scene",
               Code::kOutOfRange);
      }
      if (!body.mesh.empty()) body.mesh = file_of(entry, entry_path, "mesh", body.mesh);
      if (!body.visual.mesh.empty()) {
        body.visual.mesh = file_of(*entry.find("visual"), entry_path + ".visual", "mesh", body.visual.mesh);
      }
      scene->bodies.push_back(std::move(body));
    }
  }

  /// Relative paths are so to the file that an entry stands in; what is set from outside has none of its own.
  const std::string& base_of(const YamlValue& entry) const { return entry.line > 0 ? entry.origin : scene_file_; }

  /// The path to open of the file that `key` of `entry` names.
  std::string file_of(const YamlValue& entry, const std::string& path, const std::string& key,
                      const std::string& name) const {
    try {
      const std::string file = files_.check(resolve_mesh(name, base_of(entry)));
      for (const std::string& part : tet_mesh_parts(file)) files_.check(part);
      return file;
    } catch (const InputError& error) {
      refuse(*entry.find(key), path + "." + key, error.what(), error.code());
    }
  }

  static void read_body(const YamlValue& entry, const std::string& path, BodySpec* body) {
    if (entry.key == "rope") {
      body->kind = BodyKind::kRope;
      rope_table().read(entry, path, body);
    } else if (entry.key == "soft") {
      body->kind = BodyKind::kSoft;
      soft_table().read(entry, path, body);
      choose_springs_ratio(entry, body);
    } else {
      body->kind = BodyKind::kCloth;
      cloth_table().read(entry, path, body);
    }
  }

  /// Where nothing asks for a Poisson's ratio, springs have their own.
  static void choose_springs_ratio(const YamlValue& entry, BodySpec* body) {
    const YamlValue* material = entry.find("material");
    const bool given = !body->soft.material.name.empty() || (material && material->find("poissons_ratio"));
    if (given || element_of(body->soft) != SoftElement::kSprings) return;
    body->soft.material.poissons_ratio = body->soft.neighbours == 6 ? 0.0 : 0.25;
  }

  void check_body(const YamlValue& entry, const std::string& path, const BodySpec& body) {
    check_body_keys(entry, path, body);
    const std::vector<std::string> features = feature_names(body);
    for (size_t k = 0; k < body.pins.size(); ++k) {
      const YamlValue& pin = entry.find("pins")->items[k];
      check_feature(pin, indexed(path + ".pins", k), body.name, body.pins[k], features);
      check_unique(pin, indexed(path + ".pins", k), "pin_" + body.name + "_" + body.pins[k], &grasp_names_);
    }
  }

  static void check_feature(const YamlValue& value, const std::string& path, const std::string& body,
                            const std::string& feature, const std::vector<std::string>& features) {
    if (std::find(features.begin(), features.end(), feature) == features.end()) {
      refuse(value, path, "'" + body + "' has no feature '" + feature + "'; it has " + join(features), Code::kNotFound);
    }
  }

  /// `entry` is a named value whose `name` key, or which itself when it has none, gave `name`.
  static void check_unique(const YamlValue& entry, const std::string& path, const std::string& name,
                           std::map<std::string, std::string>* names) {
    const YamlValue* key = entry.find("name");
    const std::string key_path = key ? path + ".name" : path;
    const auto added = names->emplace(name, key_path);
    if (!added.second) {
      refuse(key ? *key : entry, key_path, "'" + name + "' is taken by " + added.first->second, Code::kAlreadyExists);
    }
  }

  void read_colliders(const YamlValue& list, const std::string& path, SceneSpec* scene) {
    const std::vector<TaggedTable> tables = collider_tables();
    std::vector<std::string> tags;
    for (const TaggedTable& table : tables) tags.push_back(table.tag);
    const std::vector<YamlValue>& items = read_list(list, path, "colliders");
    for (size_t k = 0; k < items.size(); ++k) {
      const YamlValue& entry = read_tagged(items[k], indexed(path, k), tags);
      const std::string entry_path = indexed(path, k) + "." + entry.key;
      const size_t type = static_cast<size_t>(std::find(tags.begin(), tags.end(), entry.key) - tags.begin());
      PrimitiveText text;
      tables[type].table.read(entry, entry_path, &text);
      check_unique(entry, entry_path, text.name, &collider_names_);
      if (const YamlValue* bodies = entry.find("lets_through"))
        check_bodies(*bodies, entry_path + ".lets_through", *scene);
      scene->colliders.push_back({location_of(items[k]), collider_of(entry, entry_path, text)});
    }
  }

  Collider collider_of(const YamlValue& entry, const std::string& path, const PrimitiveText& text) const {
    static const std::map<std::string, Shape::Type> kTypes{
        {"box", Shape::Type::kBox},         {"sphere", Shape::Type::kSphere}, {"cylinder", Shape::Type::kCylinder},
        {"capsule", Shape::Type::kCapsule}, {"plane", Shape::Type::kPlane},   {"cone", Shape::Type::kCone},
        {"mesh", Shape::Type::kMesh},       {"octomap", Shape::Type::kVoxels}};
    Shape shape;
    shape.type = kTypes.at(entry.key);
    Collider collider;
    collider.shapes = {shape};
    Vec3& size = collider.shapes.front().size;
    switch (shape.type) {
      case Shape::Type::kBox:
        size = text.size;
        break;
      case Shape::Type::kSphere:
        size = {text.radius, 0, 0};
        break;
      case Shape::Type::kCylinder:
      case Shape::Type::kCapsule:
      case Shape::Type::kCone:
        size = {text.radius, text.length, 0};
        break;
      case Shape::Type::kPlane:
        break;
      case Shape::Type::kMesh:
      case Shape::Type::kVoxels:
        collider.shapes = read_file(entry, path, text);
        break;
    }
    collider.name = text.name;
    collider.world_from_collider = text.pose.pose();
    collider.friction = text.friction;
    collider.frame = text.frame;
    collider.lets_through = text.lets_through;
    return collider;
  }

  std::vector<Shape> read_file(const YamlValue& entry, const std::string& path, const PrimitiveText& text) const {
    const std::string file = file_of(entry, path, "file", text.file);
    try {
      if (entry.key == "octomap") return {load_octomap(file)};
      return load_collider_mesh(file, Vec3::Constant(text.scale), 0.0, {});
    } catch (const InputError& error) {
      refuse(*entry.find("file"), path + ".file", error.what(), error.code());
    }
  }

  void read_grasps(const YamlValue& list, const std::string& path, SceneSpec* scene) {
    const std::vector<YamlValue>& items = read_list(list, path, "grasps");
    const Table<GraspText> table = grasp_table();
    for (size_t k = 0; k < items.size(); ++k) {
      const std::string entry_path = indexed(path, k);
      GraspText text;
      table.read(items[k], entry_path, &text);
      check_unique(items[k], entry_path, text.request.name, &grasp_names_);
      check_selection(items[k], entry_path, text, *scene);
      scene->grasps.push_back({location_of(*items[k].find("select")), request_of(text)});
    }
  }

  static void read_forces(const YamlValue& list, const std::string& path, SceneSpec* scene) {
    const std::vector<YamlValue>& items = read_list(list, path, "forces");
    const Table<ForceRequest> table = force_table();
    for (size_t k = 0; k < items.size(); ++k) {
      const std::string entry_path = indexed(path, k);
      ForceRequest request;
      table.read(items[k], entry_path, &request);
      if (const YamlValue* body = items[k].find("body")) find_body(*body, entry_path + ".body", *scene);
      scene->forces.push_back({location_of(items[k]), std::move(request)});
    }
  }

  static const BodySpec& find_body(const YamlValue& name, const std::string& path, const SceneSpec& scene) {
    std::vector<std::string> names;
    for (const BodySpec& body : scene.bodies) {
      if (body.name == name.text) return body;
      names.push_back(body.name);
    }
    refuse(name, path, "no body '" + name.text + "'; there is " + join(names), Code::kNotFound);
  }

  static void check_selection(const YamlValue& entry, const std::string& path, const GraspText& text,
                              const SceneSpec& scene) {
    const BodySpec* body = &find_body(*entry.find("body"), path + ".body", scene);
    const YamlValue& select = *entry.find("select");
    if (text.select.feature) {
      check_feature(*select.find("feature"), path + ".select.feature", body->name, *text.select.feature,
                    feature_names(*body));
    }
    const std::vector<std::pair<std::string, std::string>> belongs{
        {"reach", "nearest"}, {"center", "radius"}, {"pose", "box"}};
    for (const auto& [key, to] : belongs) {
      const YamlValue* value = select.find(key);
      if (value && !select.find(to)) refuse_key(*value, path + ".select." + key, "belongs to " + to);
    }
  }

  void read_script(const YamlValue& list, const std::string& path, SceneSpec* scene) {
    const std::vector<YamlValue>& items = read_list(list, path, "script");
    const Table<EventText> table = script_table();
    double now = 0.0;
    for (size_t k = 0; k < items.size(); ++k) {
      const std::string entry_path = indexed(path, k);
      EventText text;
      table.read(items[k], entry_path, &text);
      if (text.at < now) {
        refuse(*items[k].find("at"), entry_path + ".at", "is before that of the event before, " + format_number(now));
      }
      now = text.at;
      scene->script.push_back(
          {location_of(items[k]), entry_path, text.at, command_of(items[k], entry_path, text, *scene)});
    }
  }

  Command command_of(const YamlValue& entry, const std::string& path, const EventText& text, const SceneSpec& scene) {
    const bool moves = entry.find("move_grasp") || entry.find("move_collider");
    if (moves && !text.pose) refuse(entry, path + ".pose", "required by a move, and missing");
    for (const char* key : {"pose", "duration"}) {
      const YamlValue* value = entry.find(key);
      if (value && !moves) refuse_key(*value, path + "." + key, "belongs to move_grasp and move_collider");
    }
    if (const YamlValue* grasp = entry.find("grasp")) {
      check_selection(*grasp, path + ".grasp", *text.grasp, scene);
      grasp_names_.emplace(text.grasp->request.name, path + ".grasp.name");  // may be taken again, once released
      return command::Grasp{request_of(*text.grasp)};
    }
    if (const YamlValue* release = entry.find("release")) {
      check_known(*release, path + ".release", "grasp", grasp_names_);
      return command::Release{text.release};
    }
    if (const YamlValue* move = entry.find("move_grasp")) {
      check_known(*move, path + ".move_grasp", "grasp", grasp_names_);
      return command::MoveGrasp{text.move_grasp, text.pose->pose(), text.duration};
    }
    const YamlValue& move = *entry.find("move_collider");
    check_known(move, path + ".move_collider", "collider", collider_names_);
    for (const ColliderSpec& collider : scene.colliders) {
      if (collider.collider.name == text.move_collider && !collider.collider.frame.empty()) {
        refuse(move, path + ".move_collider",
               "'" + text.move_collider + "' follows tf frame " + collider.collider.frame + " and takes no targets");
      }
    }
    return command::MoveCollider{text.move_collider, text.pose->pose(), text.duration};
  }

  static void check_known(const YamlValue& value, const std::string& path, const std::string& what,
                          const std::map<std::string, std::string>& names) {
    if (names.count(value.text)) return;
    std::vector<std::string> known;
    for (const auto& [name, where] : names) known.push_back(name);
    refuse(value, path, "no " + what + " '" + value.text + "'; there is " + (known.empty() ? "none" : join(known)),
           Code::kNotFound);
  }

  static GraspRequest request_of(const GraspText& text) {
    GraspRequest request = text.request;
    Selection& selection = request.selection;
    const SelectText& from = text.select;
    if (from.feature) {
      selection.method = SelectionMethod::kFeature;
      selection.feature = *from.feature;
    } else if (from.nearest) {
      selection.method = SelectionMethod::kNearest;
      selection.world_from_selection.translation() = *from.nearest;
      selection.radius = from.reach;
    } else if (from.radius) {
      selection.method = SelectionMethod::kRadius;
      selection.world_from_selection.translation() = from.center;
      selection.radius = *from.radius;
    } else if (from.box) {
      selection.method = SelectionMethod::kBox;
      selection.world_from_selection = from.pose.pose();
      selection.size = *from.box;
    } else {
      selection.method = SelectionMethod::kNodes;
      selection.nodes = from.nodes;
    }
    if (text.pose) {
      request.has_frame = true;
      request.world_from_grasp = text.pose->pose();
    }
    return request;
  }

  std::string scene_file_;
  const AllowedPaths& files_;
  std::map<std::string, std::string> body_names_, collider_names_, grasp_names_;
};

}  // namespace

Pose PoseSpec::pose() const {
  Pose result = Pose::Identity();
  result.linear() = orientation.toRotationMatrix();
  result.translation() = position;
  return result;
}

SceneSpec load_scene_text(const std::string& yaml, const std::string& origin, const std::vector<Override>& overrides,
                          const AllowedPaths& files) {
  YamlValue root = parse_yaml(yaml, origin);
  if (root.kind == YamlValue::Kind::kNull) {
    throw InputError(origin + ":1: the scene is empty; it needs at least `bodies`");
  }
  for (const auto& [path, value] : overrides) override_value(path, value, &root);
  return load_scene_tree(std::move(root), origin, files);
}

SceneSpec load_scene_tree(YamlValue root, const std::string& origin, const AllowedPaths& files) {
  SceneSpec scene;
  SceneReader(origin, files).read(root, &scene);
  scene.origin = origin;
  scene.source = std::make_shared<const YamlValue>(std::move(root));
  return scene;
}

SceneSpec load_scene_file(const std::string& path, const std::vector<Override>& overrides, const AllowedPaths& files) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw InputError(path + ": is a directory, not a scene file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path + ": cannot be read", Code::kNotFound);
  // One byte beyond the limit is enough to know; a device file never ends.
  std::string text(kMaxSceneBytes + 1, '\0');
  stream.read(&text[0], static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(stream.gcount()));
  SceneSpec scene = load_scene_text(text, path, overrides, files);
  scene.file = path;
  return scene;
}

}  // namespace deformable_sim
