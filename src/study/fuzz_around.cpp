// Colliders, grasps, script and commands of scenes made at random.
#include <algorithm>

#include "fuzz_parts.h"

namespace deformable_sim::fuzz {
namespace {

double length(Drawing* d, double low, double high) {
  return std::max(1e-4, d->size * d->random.decades(low, high));
}

Tree collider(Drawing* d, const std::string& type) {
  Random& r = d->random;
  Tree map;
  map["name"] = "obstacle_" + std::to_string(d->colliders.size());
  const std::array<double, 3> where = d->place(0.9);
  map["pose"] = d->pose(where, 0.5);
  if (type == "plane") {
    map["pose"] = d->pose({0.0, 0.0, d->size * r.uniform(-1.0, 0.0)}, 0.0);
    if (r.chance(0.2))
      map["pose"]["rpy"] = Tree(std::array<double, 3>{r.uniform(-0.6, 0.6), r.uniform(-0.6, 0.6), 0.0});
  } else if (type == "box") {
    std::array<double, 3> size{length(d, 0.02, 2.0), length(d, 0.02, 2.0), length(d, 0.02, 2.0)};
    if (r.chance(0.3)) size[static_cast<size_t>(r.whole(0, 2))] = 5e-4;
    map["size"] = Tree(size);
  } else if (type == "mesh") {
    map["file"] = r.pick({"meshes/ell.obj", "meshes/octahedron.obj", "meshes/plate.obj"});
    map["scale"] = length(d, 0.1, 2.0);
  } else {
    map["radius"] = length(d, 0.005, 0.6);
    if (type != "sphere") map["length"] = length(d, 0.02, 2.0);
  }
  if (r.chance(0.4)) map["friction"] = r.chance(0.3) ? 0.0 : r.decades(0.01, 10.0);
  if (r.chance(0.08)) {
    Tree bodies = Tree::list();
    bodies.push(d->bodies.front().name);
    map["lets_through"] = bodies;
  }
  d->colliders.push_back(map["name"].text);
  Tree entry;
  entry[type] = map;
  return entry;
}

/// Where: anything that finds nodes in most cases.
Tree selection(Drawing* d, DrawnBody* body) {
  Random& r = d->random;
  Tree select;
  const int how = r.whole(0, 9);
  if (how < 4 && !body->features.empty()) {
    select["feature"] = body->features.back();
    body->features.pop_back();
  } else if (how < 6) {
    select["nearest"] = Tree(d->place(0.8));
    select["reach"] = 100.0 * d->size;
  } else if (how < 8) {
    select["radius"] = d->size * r.uniform(0.3, 0.8);
    select["center"] = Tree(body->center);
  } else if (how == 8) {
    const double side = d->size * r.uniform(0.6, 1.5);
    select["box"] = Tree(std::array<double, 3>{side, side, side});
    select["pose"]["position"] = Tree(body->center);
  } else {
    Tree nodes = Tree::list();
    nodes.push(r.whole(0, 3));
    select["nodes"] = nodes;
  }
  return select;
}

Tree grasp(Drawing* d) {
  Random& r = d->random;
  Tree map;
  map["name"] = "grasp_" + std::to_string(d->grasps.size());
  DrawnBody& body = d->bodies[static_cast<size_t>(r.whole(0, static_cast<int>(d->bodies.size()) - 1))];
  map["body"] = body.name;
  map["select"] = selection(d, &body);
  if (r.chance(0.15)) map["pose"] = d->pose(d->place(0.8), 0.5);
  if (r.chance(0.3)) map["max_force"] = r.decades(1e-2, 1e3);
  if (r.chance(0.3)) map["max_speed"] = r.decades(0.1, 100.0);
  if (r.chance(0.4)) map["stiffness"] = r.decades(1.0, 1e7);
  return map;
}

void draw_duration(Random* r, Tree* event) {
  if (r->chance(0.7)) (*event)["duration"] = r->decades(1e-3, 0.5);
}

std::string vector_words(const std::array<double, 3>& v) {
  return " " + number_text(v[0]) + " " + number_text(v[1]) + " " + number_text(v[2]);
}

std::string pose_words(Drawing* d) {
  const std::array<double, 3> turn = d->random.chance(0.5) ? d->turn() : std::array<double, 3>{};
  return vector_words(d->place(0.9)) + vector_words(turn) + " " +
         number_text(d->random.chance(0.3) ? 0.0 : d->random.decades(1e-3, 0.5));
}

std::string state_words(Drawing* d) {
  Random& r = d->random;
  const std::string& body = d->bodies[static_cast<size_t>(r.whole(0, static_cast<int>(d->bodies.size()) - 1))].name;
  if (r.chance(0.2))
    return "scatter " + body + " " + number_text(d->size * r.decades(0.01, 2.0)) + " " +
           std::to_string(r.whole(1, 999));
  const std::vector<double> scales{1.0, 1.0, 0.5, 1.5, 3.0, 10.0, 0.01, -1.0};
  const double scale = scales[static_cast<size_t>(r.whole(0, 7))], speed = r.decades(0.1, 50.0);
  const std::array<double, 3> turn = d->turn();
  return "set_state " + body + " " + number_text(scale) + vector_words(d->place(0.3)) +
         vector_words({speed * turn[0] / 3.0, speed * turn[1] / 3.0, speed * turn[2] / 3.0});
}

std::string command_words(Drawing* d) {
  Random& r = d->random;
  const std::string what = r.pick({"grasp", "move_grasp", "move_grasp", "release", "add_collider", "move_collider",
                                   "move_collider", "remove_collider", "state", "let_through", "reset"});
  const std::string& body = d->bodies.front().name;
  const std::string outside = "outside_" + std::to_string(d->result.commands.size());
  if (what == "grasp") {
    d->grasps.push_back(outside);
    return "grasp " + outside + " " + body + " " + r.pick({"node", "radius", "box"}) + vector_words(d->place(0.6)) +
           " " + number_text(d->size * r.uniform(0.3, 1.0)) + " " +
           number_text(r.chance(0.5) ? 0.0 : r.decades(0.1, 1e3)) + " " +
           number_text(r.chance(0.5) ? 0.0 : r.decades(1.0, 1e6));
  }
  if (what == "add_collider") {
    d->colliders.push_back(outside);
    return "add_collider " + outside + " " + r.pick({"sphere", "box", "capsule", "plane"}) +
           vector_words(d->place(0.9)) + " " + number_text(length(d, 0.02, 0.6)) + " " + number_text(r.uniform(0, 1));
  }
  if (what == "state") return state_words(d);
  if (what == "reset") return "reset";
  const bool of_grasp = what == "move_grasp" || what == "release";
  const std::vector<std::string>& names = of_grasp ? d->grasps : d->colliders;
  if (names.empty()) return state_words(d);
  const std::string name = r.pick(names);
  if (what == "move_grasp" || what == "move_collider") return what + " " + name + pose_words(d);
  return what + " " + name + (what == "let_through" ? " " + body : "");
}

}  // namespace

void draw_colliders(Drawing* d) {
  Random& r = d->random;
  if (r.chance(0.25)) return;
  d->result.scene["colliders"] = Tree::list();
  Tree& list = d->result.scene["colliders"];
  const int count = r.whole(1, 3);
  if (r.chance(0.5)) list.push(collider(d, "plane"));
  for (int k = 0; k < count; ++k) {
    list.push(collider(d, r.pick({"box", "box", "sphere", "cylinder", "capsule", "plane", "cone", "mesh"})));
  }
}

void draw_grasps(Drawing* d) {
  if (d->random.chance(0.6)) return;
  Tree list = Tree::list();
  list.push(grasp(d));
  d->grasps.push_back(list.items.back().second["name"].text);
  d->result.scene["grasps"] = list;
}

void draw_script(Drawing* d) {
  Random& r = d->random;
  if (r.chance(0.4)) return;
  Tree list = Tree::list();
  const int count = r.whole(1, 5);
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(r.uniform(0.0, d->motion_ends));
  std::sort(times.begin(), times.end());
  std::vector<std::string> held = d->grasps;
  for (const double time : times) {
    Tree event;
    event["at"] = time;
    const int what = r.whole(0, 9);
    if (what < 4 && !held.empty()) {
      event["move_grasp"] = r.pick(held);
      event["pose"] = d->pose(d->place(0.9), 0.5);
      draw_duration(&r, &event);
    } else if (what < 7 && !d->colliders.empty()) {
      event["move_collider"] = r.pick(d->colliders);
      event["pose"] = d->pose(d->place(0.9), 0.5);
      draw_duration(&r, &event);
    } else if (what == 7 && !held.empty()) {
      event["release"] = held.back();
      held.pop_back();
    } else {
      event["grasp"] = grasp(d);
      held.push_back(event["grasp"]["name"].text);
      d->grasps.push_back(held.back());
    }
    list.push(event);
  }
  d->result.scene["script"] = list;
}

void draw_commands(Drawing* d) {
  Random& r = d->random;
  if (r.chance(0.5)) return;
  const int count = r.whole(1, 5);
  for (int k = 0; k < count; ++k) {
    const std::string time = number_text(r.uniform(0.0, d->motion_ends));
    d->result.commands.push_back("#! " + time + " " + command_words(d));
  }
}

}  // namespace deformable_sim::fuzz
