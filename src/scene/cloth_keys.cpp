// Keys of cloth.
#include "body_keys.h"
#include "deformable_sim/core/material/solid_law.h"
#include "named_materials.h"

namespace deformable_sim {
namespace {

constexpr double kPi = 3.14159265358979323846;

void read_cells(const YamlValue& v, const std::string& path, BodySpec* body) {
  const std::vector<YamlValue>& items = read_list(v, path, "2 whole numbers");
  if (items.size() != 2) refuse(v, path, "must be a list of 2 whole numbers, not of " + std::to_string(items.size()));
  for (size_t k = 0; k < 2; ++k) body->cells[k] = read_integer(items[k], path + "[" + std::to_string(k) + "]", 1, 2000);
}

void read_creases(const YamlValue& v, const std::string& path, BodySpec* body) {
  const Table<CreaseSpec> table = crease_table();
  for (const YamlValue& item : read_list(v, path, "creases")) {
    CreaseSpec crease;
    crease.where = {item.origin, item.line};
    crease.path = path + "[" + std::to_string(body->cloth.creases.size()) + "]";
    table.read(item, crease.path, &crease);
    body->cloth.creases.push_back(crease);
  }
}

void add_model_keys(Table<BodySpec>* t) {
  const auto model = [](BodySpec& b) -> ClothModel& { return b.cloth.model; };
  add_choice(
      t, "model", model,
      Choices<ClothModel>{
          {"springs", ClothModel::kSprings}, {"provot", ClothModel::kProvot}, {"membrane", ClothModel::kMembrane}},
      "springs",
      "springs: a network that gives the material's modulus back; provot: structural, shear and flexion springs "
      "of a grid; membrane: triangles of a continuum, with warp and weft.");
  const auto law = [](BodySpec& b) -> std::string& { return b.cloth.law; };
  t->choice("law", law, solid_law_names(),
            "Stress-strain law of a membrane. All but hooke and st_venant_kirchhoff are isotropic; hooke is for small "
            "rotations only.");
  const auto bending = [](BodySpec& b) -> std::optional<ClothBending>& { return b.cloth.bending; };
  add_choice(t, "bending", bending,
             Choices<ClothBending>{{"springs", ClothBending::kSprings},
                                   {"hinges", ClothBending::kHinges},
                                   {"quadratic", ClothBending::kQuadratic}},
             "hinges for a membrane or where a bending_rigidity is known, else springs",
             "springs: over two cells or across an edge, without a rigidity in N m; hinges: the plate energy of the "
             "bending_rigidity at any mesh; quadratic: the same with a constant matrix, for sheets that hardly stretch "
             "and are flat at rest.");
  const auto rest = [](BodySpec& b) -> RestShape& { return b.cloth.rest_shape; };
  add_choice(t, "rest_shape", rest, Choices<RestShape>{{"as_meshed", RestShape::kAsMeshed}, {"flat", RestShape::kFlat}},
             "as_meshed", "Angles between faces at rest: those of the mesh, or none. With hinges.");
  t->add({"creases", "list", "", "[]", "",
          "Pressed folds and pleats: edges that keep an angle. With hinges. See bodies[].cloth.creases[]."},
         read_creases);
  t->optional_number(
      "strain_limit", "", [](BodySpec& b) -> std::optional<double>& { return b.cloth.strain_limit; }, between(0.001, 1),
      "none", "Structural edges stretched beyond this strain are pulled back to it after every step; 0.1 is Provot's.");
  t->number(
      "pressure", "Pa", [](BodySpec& b) -> double& { return b.cloth.pressure; }, between(-1e5, 1e6),
      "Gauge pressure inside a closed mesh: it pushes outwards, < 0 inwards. It is kept up, as by a pump, whatever the "
      "volume.");
  t->number(
      "pressure_rise", "s", [](BodySpec& b) -> double& { return b.cloth.pressure_rise; }, between(0, 1000),
      "The pressure rises from nothing in this time after the start of the simulation.");
  add_visual_key(t, BodyKind::kCloth);
  add_look_key(t, BodyKind::kCloth);
}

}  // namespace

std::array<double, 2> ClothMaterialSpec::membrane() const {
  if (membrane_stiffness) return *membrane_stiffness;
  return {youngs_modulus[0] * thickness, youngs_modulus[1] * thickness};
}

Table<CreaseSpec> crease_table() {
  Table<CreaseSpec> t(
      "bodies[].cloth.creases[]",
      "A fold line along edges of the mesh, straight in its x-y plane: on a grid, along a line of nodes "
      "or a chain of cell diagonals.");
  const auto point = [](Eigen::Vector2d CreaseSpec::*member) {
    return [member](const YamlValue& v, const std::string& path, CreaseSpec* out) {
      read_vector(v, path, between(-1000, 1000), (out->*member).data(), 2);
    };
  };
  t.add({"from", "[x, y]", "m", "", "-1000 ... 1000", "Where it begins, in the body's own frame."},
        point(&CreaseSpec::from))
      .required();
  t.add({"to", "[x, y]", "m", "", "-1000 ... 1000", "Where it ends."}, point(&CreaseSpec::to)).required();
  t.number("angle", "rad", &CreaseSpec::angle, between(-0.95 * kPi, 0.95 * kPi),
           "Between the faces at rest, 0 = flat; positive: a valley on the sheet's +z side.")
      .required();
  return t;
}

Table<ClothMaterialSpec> cloth_material_table() {
  using M = ClothMaterialSpec;
  Table<M> t("bodies[].cloth.material",
             "Sheet material, as measured on the textile: a map, or the name of a fabric of doc/materials.md. [warp, "
             "weft] are along x and y of the rest mesh; one number stands for both.");
  add_from(&t, "fabrics", [](const std::string& name, M* out) { start_from_fabric(name, out); });
  t.number("areal_density", "kg/m^2", &M::areal_density, between(1e-4, 1000), "Mass per area.");
  t.number("thickness", "m", &M::thickness, between(1e-6, 0.1), "With youngs_modulus it gives the membrane stiffness.");
  t.add({"youngs_modulus", "number or [warp, weft]", "Pa", "820000", between(1, 1e12).text(), "In the plane."},
        [](const YamlValue& v, const std::string& path, M* out) {
          read_pair(v, path, between(1, 1e12), &out->youngs_modulus);
          out->membrane_stiffness.reset();
        });
  t.pair("membrane_stiffness", "[warp, weft]", "N/m", &M::membrane_stiffness, above(0, 1e9),
         "youngs_modulus x thickness", "E h: force per width over strain, the sides free; replaces youngs_modulus.");
  t.number(
      "poissons_ratio", "", &M::poissons_ratio, between(0, 0.5),
      "Contraction along weft over extension along warp. A triangle mesh of springs has 1/3, and refuses this key.");
  t.optional_number("shear_rigidity", "N/m", &M::shear_rigidity, above(0, 1e9),
                    "isotropic: E h / (2 (1 + poissons_ratio))",
                    "G h of a membrane: shear force per width over shear angle. Woven cloth: about 1 % of E h.");
  t.pair("bending_rigidity", "[warp, weft]", "N m", &M::bending_rigidity, above(0, 1e6),
         "E h^3 / 12 (membranes), which is about a tenth of a woven cloth's",
         "Moment per width over curvature of a strip cut along warp or weft, by hinges; independent of the membrane.");
  t.optional_number("shear_stiffness", "N/m", &M::shear_stiffness, between(0, 1e9), "from poissons_ratio",
                    "Springs: stiffness of each shear spring (grids only); 0 = none.");
  t.optional_number("stretch_stiffness", "N/m", &M::stretch_stiffness, above(0, 1e9), "from youngs_modulus",
                    "Stiffness of each structural spring; replaces youngs_modulus and depends on the mesh.");
  t.optional_number("bend_stiffness", "N/m", &M::bend_stiffness, between(0, 1e9), "from the material",
                    "Stiffness of each bend spring (over two cells or segments, or across an edge); 0 = none.");
  t.number("damping", "s", &M::damping, between(0, 1), "Viscous over elastic stiffness of every spring or element.");
  t.optional_number("bending_damping", "s", &M::bending_damping, between(0, 1), "damping",
                    "Viscous over elastic moment of bending by hinges or quadratic.");
  t.optional_number("elastic_limit", "", &M::elastic_limit, above(0, 10), "none",
                    "Strain beyond which the law is not valid: ~status warns.");
  t.at_most_one_of({"youngs_modulus", "membrane_stiffness", "stretch_stiffness"});
  return t;
}

Table<BodySpec> cloth_table() {
  Table<BodySpec> t("bodies[].cloth",
                    "A sheet: a grid in the x-y plane of its pose, centred on it, or any triangle mesh.");
  add_first_keys(&t);
  t.vector("size", "[x, y]", "m", &BodySpec::size, between(0.001, 100), "Edge lengths of a grid.");
  t.add({"cells", "[nx, ny]", "", "[20, 20]", "1 ... 2000", "Cells of a grid along x and y: one node more each way."},
        read_cells);
  t.text("mesh", &BodySpec::mesh,
         "OBJ, STL, PLY or DAE file instead of a grid: relative to the scene file, absolute, or "
         "package://deformable_sim/... Polygons are cut into triangles; vertices at the same place are one node; nodes "
         "are numbered as the faces first name them. Axes are taken as they stand in the file.");
  t.number("mesh_scale", "m", &BodySpec::mesh_scale, between(1e-6, 1000),
           "Metres per unit of the file (a DAE file's own unit is applied first).");
  add_model_keys(&t);
  t.add({"material", "map or name", "", "", "", "See bodies[].cloth.material."},
        [](const YamlValue& v, const std::string& path, BodySpec* body) {
          read_material(v, path, cloth_material_table(), &body->cloth_material);
        });
  add_contact_points(&t);
  add_common_keys(&t, "half the thickness, at least " + format_number(kMinContactRadius));
  t.at_most_one_of({"mesh", "cells"}).at_most_one_of({"mesh", "size"});
  return t;
}

}  // namespace deformable_sim
