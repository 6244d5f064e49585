#include "body_keys.h"
#include "deformable_sim/core/topology/upsampling.h"

namespace deformable_sim {
namespace {

void read_pins(const YamlValue& v, const std::string& path, BodySpec* body) {
  for (const YamlValue& item : read_list(v, path, "features")) {
    body->pins.push_back(read_text(item, path + "[" + std::to_string(body->pins.size()) + "]"));
  }
}

void read_visual_mesh(const YamlValue& v, const std::string& path, BodySpec* body) {
  body->visual.mesh = read_text(v, path);
  body->visual.where = {v.origin, v.line};
  body->visual.path = path;
}

/// A number of metres, or the word `material`.
void read_thickness(const YamlValue& v, const std::string& path, BodySpec* body) {
  if (v.kind == YamlValue::Kind::kScalar && v.text == "material") {
    body->look.thickness.reset();
  } else {
    body->look.thickness = read_number(v, path, between(0, 0.1));
  }
}

void read_color(const YamlValue& v, const std::string& path, BodySpec* body) {
  body->color.emplace();
  read_vector(v, path, between(0, 1), body->color->data(), 3);
}

}  // namespace

void add_first_keys(Table<BodySpec>* table) {
  table->name("name", &BodySpec::name, "Unique; part of topic names.");
  table->map("pose", &BodySpec::pose, pose_table(), "World from body. See pose.");
}

void add_visual_key(Table<BodySpec>* table, BodyKind kind) {
  const Table<BodySpec> visual = visual_table(kind);
  table->map(
      "visual", [](BodySpec& b) -> BodySpec& { return b; }, visual, "See " + visual.text().path + ".");
}

Table<BodySpec> visual_table(BodyKind kind) {
  const bool cloth = kind == BodyKind::kCloth;
  Table<BodySpec> t(cloth ? "bodies[].cloth.visual" : "bodies[].soft.visual",
                    "A finer surface that is drawn and published as points in place of the nodes, which carry it.");
  if (cloth) {
    t.integer(
        "upsample", [](BodySpec& b) -> int& { return b.cloth.upsample; }, 1, kMaxUpsampling,
        "A grid so many times finer along each side of a cell, on a smooth surface through the nodes.");
  }
  t.add({"mesh", "text", "", "", "",
         "OBJ, STL, PLY or DAE file in the frame of the body, wherever it lies near it: relative to the scene file, "
         "absolute, or package://deformable_sim/..."},
        read_visual_mesh);
  t.number(
      "mesh_scale", "m", [](BodySpec& b) -> double& { return b.visual.mesh_scale; }, between(1e-6, 1000),
      "Metres per unit of the file.");
  if (cloth) t.at_most_one_of({"upsample", "mesh"});
  return t;
}

void add_look_key(Table<BodySpec>* table, BodyKind kind) {
  const Table<BodySpec> look = look_table(kind);
  table->add({"look", "map", "", "", "", "How it is drawn. See " + look.text().path + "."},
             [look](const YamlValue& v, const std::string& path, BodySpec* body) {
               look.read(v, path, body);
               body->look.where = {v.origin, v.line};
               body->look.path = path;
             });
}

Table<BodySpec> look_table(BodyKind kind) {
  const bool cloth = kind == BodyKind::kCloth;
  Table<BodySpec> t(cloth ? "bodies[].cloth.look" : "bodies[].rope.look",
                    "How it is drawn in rviz beyond its colour; the simulation is the same.");
  if (!cloth) {
    t.number(
        "stripe", "", [](BodySpec& b) -> double& { return b.look.stripe; }, between(0, 1),
        "Width of the darker stripe along a rod that turns with it, as a part of the circumference; the first director "
        "points at its middle. 0 = none.");
    return t;
  }
  t.add(
      {"checker", "number", "m", "plain", "0.001 ... 100",
       "Edge of the squares of a checkered cloth, along x and y of the rest mesh (warp and weft), from its least x and "
       "y on."},
      [](const YamlValue& v, const std::string& path, BodySpec* body) {
        body->look.checker = read_number(v, path, between(0.001, 100));
      });
  t.add({"checker_color", "[r, g, b]", "", "much lighter than `color`", "0 ... 1", "Of every other square."},
        [](const YamlValue& v, const std::string& path, BodySpec* body) {
          read_vector(v, path, between(0, 1), body->look.checker_color.emplace().data(), 3);
        });
  t.number(
      "seams", "m", [](BodySpec& b) -> double& { return b.look.seams; }, between(0, 1),
      "Width of the darker band along hems (borders of the mesh) and on both sides of seams (edges where panels of the "
      "rest mesh meet at more than 60 degrees); 0 = none.");
  t.add({"thickness", "number or word", "m", "0", "0 ... 0.1, material",
         "Distance of two faces, joined along the borders; material: its thickness; 0 = one face without."},
        read_thickness);
  return t;
}

void add_contact_points(Table<BodySpec>* table) {
  table->add(
      {"contact_points", "word", "", "nodes", "nodes, faces, anywhere",
       "What is held off colliders: nodes; nodes, middles of edges and face centroids (coarse meshes on small or "
       "sharp colliders); or nodes and the place of every edge and face that is nearest to the collider (pulled "
       "over edges, lifted by corners and posts; convex shapes)."},
      [](const YamlValue& v, const std::string& path, BodySpec* body) {
        const std::string points = read_choice(v, path, {"nodes", "faces", "anywhere"});
        body->contact_at_faces = points != "nodes";
        body->contact_anywhere = points == "anywhere";
      });
}

void add_common_keys(Table<BodySpec>* table, const std::string& contact_radius) {
  table->number("friction", "", &BodySpec::friction, between(0, 10),
                "Coulomb coefficient; a contact takes the geometric mean of body and collider.");
  table->optional_number("contact_radius", "m", &BodySpec::contact_radius, between(0.0001, 0.1), contact_radius,
                         "Distance kept between the body's nodes and collider surfaces.");
  table->add(
      {"touches", "word", "", "none", "none, others, all",
       "Which deformable bodies it feels, of those that touch any: none, all others, or itself, too. They keep the "
       "sum of their contact radii apart and never cross; where they do at the start the scene is refused."},
      [](const YamlValue& v, const std::string& path, BodySpec* body) {
        const std::string word = read_choice(v, path, {"none", "others", "all"});
        body->touches = word == "all"      ? BodyContact::kAll
                        : word == "others" ? BodyContact::kOthers
                                           : BodyContact::kNone;
      });
  table->add({"color", "[r, g, b]", "", "by order", "0 ... 1", "Colour in rviz."}, read_color);
  table->add(
      {"pins", "list of features", "", "[]", "features of the body",
       "Features held where they start: each becomes a rigid grasp named pin_BODY_FEATURE, which can be moved and "
       "released like any other."},
      read_pins);
}

}  // namespace deformable_sim
