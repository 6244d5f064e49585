// Keys of ropes.
#include "body_keys.h"
#include "named_materials.h"

namespace deformable_sim {
namespace {

void read_section(const YamlValue& v, const std::string& path, RopeMaterialSpec* out) {
  out->section.emplace();
  read_vector(v, path, between(1e-5, 0.5), out->section->data(), 2);
}

/// One number curves in the x-y plane: about the second director.
void read_curvature(const YamlValue& v, const std::string& path, BodySpec* body) {
  const Range range = between(-1000, 1000);
  if (v.kind == YamlValue::Kind::kList) {
    read_vector(v, path, range, body->rope.natural_curvature.data(), 2);
  } else {
    body->rope.natural_curvature = {0.0, read_number(v, path, range)};
  }
}

void add_model_keys(Table<BodySpec>* t) {
  const auto model = [](BodySpec& b) -> RopeModel& { return b.rope.model; };
  add_choice(t, "model", model,
             Choices<RopeModel>{
                 {"springs", RopeModel::kSprings}, {"untwisted", RopeModel::kUntwisted}, {"rod", RopeModel::kRod}},
             "springs",
             "springs: a chain; untwisted: a chain with a bending rigidity, round, straight without load and free to "
             "twist: some ten times faster than a rod; rod: a chain with frames that resists bending and twisting.");
  t->add({"natural_curvature", "number or [about y, about z]", "1/m", "0", between(-1000, 1000).text(),
          "Of a rod without load; one number bends it in the x-y plane of its pose, towards y."},
         read_curvature);
  t->number(
      "natural_twist", "rad/m", [](BodySpec& b) -> double& { return b.rope.natural_twist; }, between(-1000, 1000),
      "Of a rod without load.");
  t->number(
      "initial_twist", "rad/m", [](BodySpec& b) -> double& { return b.rope.initial_twist; }, between(-1000, 1000),
      "Of a rod at the start, beyond the natural one: what its ends were turned before they were grasped.");
  const auto start = [](BodySpec& b) -> RopeStart& { return b.rope.start; };
  add_choice(
      t, "start", start, Choices<RopeStart>{{"natural", RopeStart::kNatural}, {"straight", RopeStart::kStraight}},
      "natural",
      "A rod with natural curvature starts in its natural shape, beginning along x of its pose, or straight and under "
      "load.");
  add_look_key(t, BodyKind::kRope);
}

void read_path(const YamlValue& v, const std::string& path, BodySpec* body) {
  body->path.clear();
  body->length = 0.0;
  for (const YamlValue& item : read_list(v, path, "points [x, y, z]")) {
    Vec3 point;
    read_vector(item, path + "[" + std::to_string(body->path.size()) + "]", between(-1000, 1000), point.data(), 3);
    if (!body->path.empty()) body->length += (point - body->path.back()).norm();
    body->path.push_back(point);
  }
}

}  // namespace

Table<RopeMaterialSpec> rope_material_table() {
  using M = RopeMaterialSpec;
  Table<M> t(
      "bodies[].rope.material",
      "Rope material: a map, or the name of a yarn, rope or cable of doc/materials.md. A rod's stiffnesses come "
      "from youngs_modulus and its section unless given; a laid or braided rope bends far more easily than that: "
      "give its bending_rigidity.");
  add_from(&t, "ropes", [](const std::string& name, M* out) { start_from_rope(name, out); });
  t.number("linear_density", "kg/m", &M::linear_density, between(1e-6, 1000), "Mass per length.");
  t.number("diameter", "m", &M::diameter, between(1e-5, 0.5), "Of the round cross-section.");
  t.add({"section", "[width, height]", "m", "round", between(1e-5, 0.5).text(),
         "A rod's rectangular section instead: width along y of its pose, height along z."},
        read_section);
  t.add({"youngs_modulus", "number", "Pa", "5e+07", between(1, 1e12).text(), "Along the rope."},
        [](const YamlValue& v, const std::string& path, M* out) {
          out->youngs_modulus = read_number(v, path, between(1, 1e12));
          out->axial_stiffness.reset();
        });
  t.optional_number(
      "axial_stiffness", "N", &M::axial_stiffness, above(0, 1e12), "youngs_modulus x area",
      "E A: force over strain; replaces youngs_modulus for stretch. Ropes hardly stretch: a hundredth of a steel "
      "cable's changes no shape that one can see, and is solved much faster.");
  t.optional_number("shear_modulus", "Pa", &M::shear_modulus, above(0, 1e12), "youngs_modulus / 2.6",
                    "G, for the twist of a rod.");
  t.pair("bending_rigidity", "[about y, about z]", "N m^2", &M::bending_rigidity, between(0, 1e6),
         "youngs_modulus x second moment", "E I of a rod: moment over curvature.");
  t.optional_number("twist_rigidity", "N m^2", &M::twist_rigidity, between(0, 1e6), "shear_modulus x torsion constant",
                    "G J of a rod: torque over twist per length.");
  t.optional_number("stretch_stiffness", "N/m", &M::stretch_stiffness, above(0, 1e9), "from youngs_modulus",
                    "Stiffness of each structural spring; replaces youngs_modulus and depends on the mesh.");
  t.optional_number("bend_stiffness", "N/m", &M::bend_stiffness, between(0, 1e9), "from the material",
                    "Stiffness of each bend spring (over two cells or segments, or across an edge); 0 = none.");
  t.number("damping", "s", &M::damping, between(0, 1), "Viscous over elastic stiffness of every spring or element.");
  t.optional_number("elastic_limit", "", &M::elastic_limit, above(0, 10), "none",
                    "Strain beyond which the law is not valid: ~status warns.");
  t.at_most_one_of({"diameter", "section"});
  t.at_most_one_of({"youngs_modulus", "stretch_stiffness"}).at_most_one_of({"axial_stiffness", "stretch_stiffness"});
  return t;
}

Table<BodySpec> rope_table() {
  Table<BodySpec> t("bodies[].rope",
                    "A chain along x of its pose, centred on it; closed: a regular polygon in its x-y plane.");
  add_first_keys(&t);
  t.number("length", "m", &BodySpec::length, between(0.001, 1000), "Rest length; the perimeter of a loop.");
  t.integer("segments", &BodySpec::segments, 1, 100000,
            "One node more than segments; as many when closed (at least 3).");
  t.boolean("closed", &BodySpec::closed, "A loop.");
  t.add({"path", "list of [x, y, z]", "m", "straight", between(-1000, 1000).text(),
         "Points in the frame of its pose, two at least, that it lies along at the start, straight from each to the "
         "next: "
         "a knot, for one. They give its length. Not for rods and loops."},
        read_path);
  t.at_most_one_of({"length", "path"}).at_most_one_of({"closed", "path"});
  add_model_keys(&t);
  t.add({"material", "map or name", "", "", "", "See bodies[].rope.material."},
        [](const YamlValue& v, const std::string& path, BodySpec* body) {
          read_material(v, path, rope_material_table(), &body->rope_material);
        });
  add_common_keys(&t, "half the diameter, at least " + format_number(kMinContactRadius));
  return t;
}

}  // namespace deformable_sim
