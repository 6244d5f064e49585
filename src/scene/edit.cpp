#include "deformable_sim/scene/edit.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "scene_tree.h"

namespace deformable_sim {
namespace {

YamlValue copy_of(const SceneSpec& scene) {
  if (!scene.source) throw InputError("the scene has no text", Code::kInternal);
  return *scene.source;
}

/// Files of it were checked when its parts were read.
SceneSpec read_again(YamlValue root, const SceneSpec& scene) {
  SceneSpec changed = load_scene_tree(std::move(root), scene.origin, AllowedPaths());
  changed.file = scene.file;
  return changed;
}

YamlValue* find(YamlValue* map, const std::string& key) {
  for (YamlValue& item : map->items)
    if (item.key == key) return &item;
  return nullptr;
}

YamlValue named(const YamlValue& like, const std::string& key, YamlValue::Kind kind) {
  YamlValue value;
  value.kind = kind;
  value.key = key;
  value.origin = like.origin;
  value.line = value.key_line = like.line;
  return value;
}

YamlValue* find_or_make(YamlValue* map, const std::string& key, YamlValue::Kind kind) {
  if (YamlValue* found = find(map, key)) return found;
  map->items.push_back(named(*map, key, kind));
  return &map->items.back();
}

bool names(const YamlValue& map, const std::string& key, const std::string& name) {
  const YamlValue* value = map.find(key);
  return value && value->text == name;
}

template <class Which>
void erase(YamlValue* list, const Which& which) {
  list->items.erase(std::remove_if(list->items.begin(), list->items.end(), which), list->items.end());
}

/// What stands under the one key of an item of `bodies` or `colliders`: cloth, rope, box ...
YamlValue& entry_of(YamlValue* item) {
  return item->items.front();
}

YamlValue* find_body(YamlValue* root, const std::string& name) {
  std::string known;
  for (YamlValue& item : find(root, "bodies")->items) {
    const std::string here = entry_of(&item).find("name")->text;
    if (here == name) return &item;
    known += (known.empty() ? "" : ", ") + here;
  }
  throw InputError("no body named '" + name + "'; there are: " + known, Code::kNotFound);
}

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

YamlValue numbers(const YamlValue& like, const std::string& key, const std::vector<double>& values) {
  YamlValue list = named(like, key, YamlValue::Kind::kList);
  for (const double value : values) {
    list.items.push_back(named(like, "", YamlValue::Kind::kScalar));
    list.items.back().text = exact(value);
  }
  return list;
}

void place(const Pose& pose, YamlValue* body) {
  const Vec3 p = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  YamlValue map = named(*body, "pose", YamlValue::Kind::kMap);
  map.items = {numbers(*body, "position", {p.x(), p.y(), p.z()}),
               numbers(*body, "orientation", {q.x(), q.y(), q.z(), q.w()})};
  *find_or_make(body, "pose", YamlValue::Kind::kMap) = std::move(map);
}

void forget_in_list(const std::string& name, YamlValue* list) {
  erase(list, [&name](const YamlValue& v) { return v.text == name; });
}

/// Grasps, forces, events and permissions that name the body.
void forget_body(const std::string& name, const std::set<std::string>& pins, YamlValue* root) {
  std::set<std::string> grasps = pins;
  if (YamlValue* list = find(root, "grasps")) {
    for (const YamlValue& grasp : list->items)
      if (names(grasp, "body", name)) grasps.insert(grasp.find("name")->text);
    erase(list, [&name](const YamlValue& grasp) { return names(grasp, "body", name); });
  }
  if (YamlValue* list = find(root, "forces"))
    erase(list, [&name](const YamlValue& force) { return names(force, "body", name); });
  if (YamlValue* list = find(root, "script")) {
    for (const YamlValue& event : list->items) {
      const YamlValue* grasp = event.find("grasp");
      if (grasp && names(*grasp, "body", name)) grasps.insert(grasp->find("name")->text);
    }
    erase(list, [&](const YamlValue& event) {
      const YamlValue* grasp = event.find("grasp");
      const YamlValue* release = event.find("release");
      const YamlValue* move = event.find("move_grasp");
      return (grasp && names(*grasp, "body", name)) || (release && grasps.count(release->text)) ||
             (move && grasps.count(move->text));
    });
  }
  if (YamlValue* list = find(root, "colliders"))
    for (YamlValue& item : list->items)
      if (YamlValue* bodies = find(&entry_of(&item), "lets_through")) forget_in_list(name, bodies);
  if (YamlValue* robot = find(root, "robot"))
    if (YamlValue* links = find(robot, "lets_through"))
      for (YamlValue& bodies : links->items) forget_in_list(name, &bodies);
}

}  // namespace

SceneSpec with_bodies(const SceneSpec& scene, const SceneSpec& added, const std::optional<Pose>& pose) {
  YamlValue root = copy_of(scene), from = copy_of(added);
  if (pose) {
    YamlValue* bodies = find(&from, "bodies");
    if (bodies->items.size() != 1) {
      throw InputError("pose: is that of one body; there are " + std::to_string(bodies->items.size()));
    }
    place(*pose, &entry_of(&bodies->items.front()));
  }
  for (const char* key : {"bodies", "grasps", "forces"}) {
    YamlValue* list = find(&from, key);
    if (!list) continue;
    YamlValue* into = find_or_make(&root, key, YamlValue::Kind::kList);
    std::move(list->items.begin(), list->items.end(), std::back_inserter(into->items));
  }
  return read_again(std::move(root), scene);
}

SceneSpec without_body(const SceneSpec& scene, const std::string& name) {
  YamlValue root = copy_of(scene);
  YamlValue* gone = find_body(&root, name);
  YamlValue* bodies = find(&root, "bodies");
  if (bodies->items.size() == 1) {
    throw InputError("'" + name + "' is the only body; a scene has at least one: ~load_scene or ~add_body first");
  }
  std::set<std::string> pins;
  if (const YamlValue* list = entry_of(gone).find("pins"))
    for (const YamlValue& pin : list->items) pins.insert("pin_" + name + "_" + pin.text);
  bodies->items.erase(bodies->items.begin() + (gone - bodies->items.data()));
  forget_body(name, pins, &root);
  return read_again(std::move(root), scene);
}

SceneSpec with_material(const SceneSpec& scene, const std::string& body, const std::string& yaml) {
  YamlValue root = copy_of(scene);
  YamlValue given = parse_yaml(yaml, "material");
  if (given.kind != YamlValue::Kind::kMap && given.kind != YamlValue::Kind::kScalar) {
    throw InputError("material: neither a name nor keys with values, such as {damping: 0.01}");
  }
  YamlValue& entry = entry_of(find_body(&root, body));
  YamlValue* material = find_or_make(&entry, "material", YamlValue::Kind::kMap);
  given.key = "material";
  if (given.kind == YamlValue::Kind::kScalar || given.find("from")) {
    *material = std::move(given);
    return read_again(std::move(root), scene);
  }
  if (material->kind == YamlValue::Kind::kScalar) {
    YamlValue from = *material;
    from.key = "from";
    *material = named(from, "material", YamlValue::Kind::kMap);
    material->items.push_back(std::move(from));
  }
  material->kind = YamlValue::Kind::kMap;
  for (YamlValue& value : given.items) *find_or_make(material, value.key, value.kind) = value;
  return read_again(std::move(root), scene);
}

std::string scene_text(const SceneSpec& scene) {
  return yaml_text(copy_of(scene));
}

SceneSpec with_values(const SceneSpec& scene, const std::vector<Override>& values) {
  YamlValue root = copy_of(scene);
  for (const auto& [path, value] : values) override_value(path, value, &root);
  return read_again(std::move(root), scene);
}

}  // namespace deformable_sim
