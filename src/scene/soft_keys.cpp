// Keys of soft bodies.
#include "body_keys.h"
#include "deformable_sim/core/material/solid_law.h"
#include "named_materials.h"

namespace deformable_sim {
namespace {

constexpr int kMostCells = 1000;  // along one side

void read_cells(const YamlValue& v, const std::string& path, SoftModelSpec* out) {
  const std::vector<YamlValue>& items = read_list(v, path, "3 whole numbers");
  if (items.size() != 3) refuse(v, path, "must be a list of 3 whole numbers, not of " + std::to_string(items.size()));
  out->cells.emplace();
  for (size_t k = 0; k < 3; ++k)
    (*out->cells)[k] = read_integer(items[k], path + "[" + std::to_string(k) + "]", 1, kMostCells);
}

void read_neighbours(const YamlValue& v, const std::string& path, BodySpec* body) {
  const int count = read_integer(v, path, 6, 26);
  if (count != 6 && count != 18 && count != 26) {
    refuse(v, path, std::to_string(count) + " is out of range; allowed: 6, 18, 26", Code::kOutOfRange);
  }
  body->soft.neighbours = count;
}

SoftModelSpec& soft_of(BodySpec& body) {
  return body.soft;
}

}  // namespace

Table<SoftModelSpec> box_table() {
  Table<SoftModelSpec> t("bodies[].soft.box", "A box, centred on the pose.");
  t.add({"size", "[x, y, z]", "m", "", between(0.001, 100).text(), "Edge lengths."}, [](const YamlValue& v,
                                                                                        const std::string& path,
                                                                                        SoftModelSpec* out) {
     out->box_size.emplace();
     read_vector(v, path, between(0.001, 100), out->box_size->data(), 3);
   }).required();
  t.add({"cells", "[nx, ny, nz]", "",
         "nearly cubes: through the thinnest side 4, or 2 quadratic ones; at most 20 or 10 along any",
         "1 ... " + std::to_string(kMostCells), "Cells along x, y and z; each is cut into tetrahedra."},
        read_cells);
  return t;
}

Table<SoftModelSpec> lattice_table() {
  Table<SoftModelSpec> t("bodies[].soft.lattice",
                         "A closed surface in a lattice of cubes: those that it touches or encloses are simulated and "
                         "carry it along; the surface is what is drawn.");
  t.optional_number("cell", "m", &SoftModelSpec::lattice_cell, above(0, 10), "", "Edge length of a cube.").required();
  return t;
}

Table<SoftMaterialSpec> soft_material_table() {
  using M = SoftMaterialSpec;
  Table<M> t("bodies[].soft.material",
             "Isotropic solid: a map, or the name of a solid of doc/materials.md, which also brings the law that suits "
             "it.");
  add_from(&t, "solids", [](const std::string& name, M* out) { start_from_solid(name, out); });
  t.number("youngs_modulus", "Pa", &M::youngs_modulus, between(1, 1e13), "Gel 1e3, sponge 1e4, rubber 1e6.");
  t.number("poissons_ratio", "", &M::poissons_ratio, between(-0.99, 0.499),
           "0.5 would keep the volume exactly, and is not possible. A spring lattice has its own.");
  t.number("density", "kg/m^3", &M::density, between(0.1, 1e5), "Mass per volume.");
  t.number("damping", "s", &M::damping, between(0, 1), "Viscous over elastic stiffness; none in rigid motion.");
  t.number("mooney_rivlin_share", "", &M::mooney_rivlin_share, between(0, 1),
           "C10 / (C10 + C01) of law mooney_rivlin.");
  t.optional_number("elastic_limit", "", &M::elastic_limit, above(0, 10), "none",
                    "Strain beyond which the law is not valid: ~status warns.");
  return t;
}

Table<BodySpec> soft_table() {
  Table<BodySpec> t("bodies[].soft",
                    "A solid: a box, a mesh of tetrahedra, or a closed surface in a lattice of cubes.");
  add_first_keys(&t);
  t.map("box", soft_of, box_table(), "See bodies[].soft.box.");
  t.text("mesh", &BodySpec::mesh,
         "Tetrahedra in a text file of Gmsh (.msh 2.2 or 4.1), MEDIT (.mesh) or TetGen (.node with .ele); or, with "
         "lattice, a closed surface in an OBJ, STL, PLY or DAE file. Relative to the scene file, absolute, or "
         "package://deformable_sim/...");
  t.number("mesh_scale", "m", &BodySpec::mesh_scale, between(1e-6, 1000), "Metres per unit of the file.");
  t.map("lattice", soft_of, lattice_table(), "For a mesh that is a surface. See bodies[].soft.lattice.");
  const auto element = [](BodySpec& b) -> std::optional<SoftElement>& { return b.soft.element; };
  add_choice(
      &t, "element", element,
      Choices<SoftElement>{{"tetrahedron", SoftElement::kTetrahedron},
                           {"quadratic_tetrahedron", SoftElement::kQuadraticTetrahedron},
                           {"springs", SoftElement::kSprings}},
      "quadratic_tetrahedron for a box, tetrahedron for a mesh",
      "tetrahedron: too stiff in bending, by a factor that is reported; quadratic_tetrahedron: a node more in the "
      "middle of every edge, bends and keeps its volume as it should; springs: along edges and diagonals of the cells "
      "of a box or lattice.");
  add_choice(
      &t, "mass", [](BodySpec& b) -> SoftMass& { return b.soft.mass; },
      Choices<SoftMass>{{"lumped", SoftMass::kLumped}, {"consistent", SoftMass::kConsistent}}, "lumped",
      "lumped: at the nodes; consistent: spread over the tetrahedra, for vibrations on coarse meshes; costs a matrix.");
  t.add({"neighbours", "integer", "", "18", "6, 18, 26",
         "Springs: how many neighbours an inner node is linked to: edges, face diagonals too, body diagonals too."},
        read_neighbours);
  t.add({"material", "map or name", "", "", "", "See bodies[].soft.material."},
        [](const YamlValue& v, const std::string& path, BodySpec* body) {
          read_material(v, path, soft_material_table(), &body->soft.material);
        });
  t.add({"law", "word", "", "of the material, else stable_neo_hookean", join(solid_law_names()),
         "Stress-strain law of tetrahedra. hooke: for small rotations only; corotational: small strains; "
         "st_venant_kirchhoff: gives way under compression; neo_hookean (of a Poisson's ratio >= 0), mooney_rivlin: "
         "rubber, undefined when turned inside out; stable_neo_hookean: rubber and flesh, safe in any state."},
        [](const YamlValue& v, const std::string& path, BodySpec* body) {
          body->soft.law = read_choice(v, path, solid_law_names());
        });
  add_visual_key(&t, BodyKind::kSoft);
  add_contact_points(&t);
  add_common_keys(&t, format_number(kMinContactRadius));
  t.exactly_one_of({"box", "mesh"});
  return t;
}

}  // namespace deformable_sim
