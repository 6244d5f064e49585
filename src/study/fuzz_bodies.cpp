// Bodies of scenes made at random.
#include <algorithm>
#include <cmath>

#include "fuzz_parts.h"

namespace deformable_sim::fuzz {
namespace {

const std::vector<std::string> kLaws{"hooke",       "corotational",       "st_venant_kirchhoff",
                                     "neo_hookean", "stable_neo_hookean", "mooney_rivlin"};

std::string name_of(const Drawing& d, const std::string& kind) {
  return kind + "_" + std::to_string(d.bodies.size());
}

void draw_damping(Random* r, Tree* material) {
  if (r->chance(0.5)) (*material)["damping"] = r->chance(0.2) ? 0.0 : r->decades(1e-5, 1e-1);
}

/// Of springs or a membrane; `both`: one number, not warp and weft.
Tree cloth_material(Drawing* d, bool membrane, bool isotropic, bool mesh, bool hinges) {
  Random& r = d->random;
  Tree m;
  if (r.chance(0.8)) m["areal_density"] = r.decades(1e-3, 1e2);
  if (r.chance(0.3)) m["thickness"] = r.decades(1e-5, 1e-2);
  if (r.chance(0.6)) {
    m["youngs_modulus"] = r.decades(1e3, 1e9);
    if (!isotropic && membrane && r.chance(0.4)) {
      m["youngs_modulus"] = Tree(std::array<double, 2>{r.decades(1e3, 1e9), r.decades(1e3, 1e9)});
    }
  } else if (!membrane && r.chance(0.5)) {
    m["stretch_stiffness"] = r.decades(1e-1, 1e5);
  }
  if ((membrane || !mesh) && r.chance(0.4)) m["poissons_ratio"] = r.uniform(0.0, 0.45);
  if (membrane && !isotropic && r.chance(0.4)) m["shear_rigidity"] = r.decades(1e-2, 1e4);
  if (!membrane && !mesh && r.chance(0.3)) m["shear_stiffness"] = r.chance(0.2) ? 0.0 : r.decades(1e-2, 1e4);
  if (hinges) m["bending_rigidity"] = r.decades(1e-8, 1e-2);
  if (!membrane && !hinges && r.chance(0.4)) m["bend_stiffness"] = r.chance(0.2) ? 0.0 : r.decades(1e-3, 1e3);
  if (hinges && r.chance(0.2)) m["bending_damping"] = r.decades(1e-5, 1e-1);
  draw_damping(&r, &m);
  return m;
}

/// Pleats along lines of nodes of a grid.
Tree creases(Drawing* d, double width, double height, int columns) {
  Tree list = Tree::list();
  const int count = std::min(d->random.whole(1, 3), columns - 1);
  for (int k = 1; k <= count; ++k) {
    const double x = width * (static_cast<double>(k) / columns - 0.5);
    Tree crease;
    crease["from"] = Tree(std::array<double, 2>{x, -0.5 * height});
    crease["to"] = Tree(std::array<double, 2>{x, 0.5 * height});
    crease["angle"] = d->random.uniform(-2.9, 2.9);
    list.push(crease);
  }
  return list;
}

/// Knots, steps and zigzags: any points, none of them where the one before it is.
Tree rope_path(Drawing* d) {
  Tree path = Tree::list();
  const int count = d->random.whole(2, 8);
  for (int k = 0; k < count; ++k) {
    const double step = static_cast<double>(k) / count - 0.5, w = 0.3 * d->size;
    path.push(Tree(std::array<double, 3>{d->size * step, d->random.uniform(-w, w), d->random.uniform(-w, w)}));
  }
  return path;
}

Tree rope_material(Drawing* d, const std::string& model) {
  Random& r = d->random;
  Tree m;
  if (r.chance(0.7)) m["linear_density"] = r.decades(1e-4, 1e2);
  if (model == "rod" && r.chance(0.2)) {
    m["section"] = Tree(std::array<double, 2>{r.decades(1e-4, 1e-2), r.decades(1e-4, 1e-2)});
  } else if (r.chance(0.5)) {
    m["diameter"] = r.decades(5e-4, 2e-2);
  }
  if (r.chance(0.5)) m["youngs_modulus"] = r.decades(1e5, 1e11);
  if (r.chance(0.4)) {
    if (model == "springs" && m.find("youngs_modulus") == nullptr && r.chance(0.5)) {
      m["stretch_stiffness"] = r.decades(1.0, 1e6);
    } else {
      m["axial_stiffness"] = r.decades(1.0, 1e6);
    }
  }
  if (model == "springs" && r.chance(0.3)) m["bend_stiffness"] = r.chance(0.2) ? 0.0 : r.decades(1e-3, 1e3);
  if (model != "springs" && r.chance(0.5)) m["bending_rigidity"] = r.chance(0.1) ? 0.0 : r.decades(1e-7, 1e1);
  if (model == "rod" && r.chance(0.3)) m["twist_rigidity"] = r.chance(0.1) ? 0.0 : r.decades(1e-7, 1e1);
  draw_damping(&r, &m);
  return m;
}

void draw_rod_shape(Drawing* d, bool closed, Tree* map) {
  Random& r = d->random;
  if (r.chance(0.4)) {
    const double most = 20.0 / d->size;
    (*map)["natural_curvature"] = r.uniform(-most, most);
    if (r.chance(0.3))
      (*map)["natural_curvature"] = Tree(std::array<double, 2>{r.uniform(-most, most), r.uniform(-most, most)});
  }
  if (r.chance(0.3)) (*map)["natural_twist"] = r.uniform(-20.0, 20.0) / d->size;
  if (closed) return;
  if (r.chance(0.4)) (*map)["initial_twist"] = r.uniform(-40.0, 40.0) / d->size;
  if (r.chance(0.3)) (*map)["start"] = "straight";
}

Tree soft_material(Drawing* d) {
  Random& r = d->random;
  Tree m;
  if (r.chance(0.8)) m["youngs_modulus"] = r.decades(1e2, 1e8) * (r.chance(0.1) ? 1e3 : 1.0);
  if (r.chance(0.5)) m["poissons_ratio"] = r.chance(0.15) ? r.uniform(-0.9, 0.0) : r.uniform(0.0, 0.499);
  if (r.chance(0.4)) m["density"] = r.decades(1.0, 1e5);
  if (r.chance(0.1)) m["mooney_rivlin_share"] = r.uniform(0.0, 1.0);
  draw_damping(&r, &m);
  return m;
}

/// Cells of a box of about `most` nodes, `parts` nodes a cell along each side.
std::array<int, 3> box_cells(Random* r, int most, int parts) {
  std::array<int, 3> cells{1, 1, 1};
  const auto nodes = [&] { return (parts * cells[0] + 1) * (parts * cells[1] + 1) * (parts * cells[2] + 1); };
  for (int tries = 0; tries < 20; ++tries) {
    const auto axis = static_cast<size_t>(r->whole(0, 2));
    ++cells[axis];
    if (nodes() > most) --cells[axis];
  }
  return cells;
}

void draw_box(Drawing* d, const std::string& element, int most, Tree* map) {
  Random& r = d->random;
  const int parts = element == "tetrahedron" || element == "springs" ? 1 : 2;
  const std::array<int, 3> cells = box_cells(&r, most, parts);
  Tree list = Tree::list();
  for (const int n : cells) list.push(n);
  std::array<double, 3> size{};
  const double cell = d->size / *std::max_element(cells.begin(), cells.end());
  // Slivers in a tenth: one side a hundredth or a thousandth of the others.
  for (size_t k = 0; k < 3; ++k) size[k] = std::max(0.001, cell * cells[k] * r.uniform(0.6, 1.2));
  if (r.chance(0.1)) size[2] = std::max(0.001, size[2] * r.decades(1e-3, 1e-1));
  (*map)["box"]["size"] = Tree(size);
  (*map)["box"]["cells"] = list;
}

}  // namespace

void draw_cloth(Drawing* d, int most) {
  Random& r = d->random;
  DrawnBody body;
  body.name = name_of(*d, "cloth");
  body.kind = "cloth";
  Tree map;
  map["name"] = body.name;
  const bool mesh = r.chance(0.25);
  const std::string model =
      r.pick(mesh ? std::vector<std::string>{"springs", "membrane"}
                  : std::vector<std::string>{"springs", "springs", "provot", "membrane", "membrane"});
  const bool membrane = model == "membrane";
  double width = d->size, height = d->size * r.uniform(0.3, 1.2);
  if (r.chance(0.08)) height = std::max(0.001, d->size * r.decades(1e-3, 1e-1));
  int columns = 0;
  if (mesh) {
    map["mesh"] = r.pick({"meshes/sheet_uneven.obj", "meshes/sheet_slivers.obj", "meshes/cap.obj"});
    map["mesh_scale"] = d->size;
    body.features = {"center"};
  } else {
    columns = r.whole(1, 14);
    const int rows = std::clamp(most / (columns + 1) - 1, 1, r.whole(1, 14));
    Tree cells = Tree::list();
    cells.push(columns);
    cells.push(rows);
    map["size"] = Tree(std::array<double, 2>{width, height});
    map["cells"] = cells;
    body.features =
        r.chance(0.5) ? std::vector<std::string>{"corner_0", "corner_2"} : std::vector<std::string>{"edge_0", "edge_2"};
  }
  if (r.chance(0.7)) map["model"] = model;
  const bool model_written = map.find("model") != nullptr, is_membrane = membrane && model_written;
  std::string law = "st_venant_kirchhoff";
  if (is_membrane && r.chance(0.6)) map["law"] = law = r.pick(kLaws);
  const bool isotropic = law != "hooke" && law != "st_venant_kirchhoff";
  bool hinges = is_membrane ? r.chance(0.6) : r.chance(0.4);
  const bool quadratic = hinges && r.chance(0.3);
  if (quadratic) {
    map["bending"] = "quadratic";
    if (mesh) map["rest_shape"] = "flat";
  } else if (hinges && r.chance(0.5)) {
    map["bending"] = "hinges";
    if (r.chance(0.3)) map["rest_shape"] = r.pick({"as_meshed", "flat"});
  }
  if (hinges && !quadratic && !mesh && columns > 1 && r.chance(0.5))
    map["creases"] = creases(d, width, height, columns);
  if (r.chance(0.15)) map["strain_limit"] = r.decades(0.001, 1.0);
  if (!isotropic && r.chance(0.2)) {
    map["material"] = r.pick({"cotton_penava", "wool_penava", "denim_11oz_black", "paper", "silk_clyde", "fabric_p5",
                              "fabric_p95", "polyester_dobby", "cupro"});
    if (!is_membrane) map.erase("bending"), map.erase("rest_shape"), map.erase("creases");
  } else {
    map["material"] = cloth_material(d, is_membrane, isotropic, mesh, hinges);
  }
  body.springs_only = !is_membrane && (!hinges || quadratic) && map["material"].kind == Tree::Kind::kMap;
  body.nodes = most;
  draw_common(d, body, &map);
}

void draw_rope(Drawing* d, int most) {
  Random& r = d->random;
  DrawnBody body;
  body.name = name_of(*d, "rope");
  body.kind = "rope";
  Tree map;
  map["name"] = body.name;
  const std::string model = r.pick({"springs", "untwisted", "rod", "rod"});
  if (model != "springs" || r.chance(0.5)) map["model"] = model;
  const bool closed = r.chance(0.2);
  body.nodes = std::clamp(most, 4, r.chance(0.2) ? 400 : 80);
  map["segments"] = r.chance(0.05) && !closed ? 1 : body.nodes - 1;
  if (closed) map["closed"] = "true";
  if (model != "rod" && !closed && r.chance(0.3)) {
    map["path"] = rope_path(d);
  } else {
    map["length"] = d->size * r.decades(0.5, 3.0);
  }
  if (model == "rod") draw_rod_shape(d, closed, &map);
  map["material"] = r.chance(0.15) ? Tree(r.pick({"nylon_rope", "steel_cable", "kevlar_49_yarn", "rubber_cord_3mm",
                                                  "copper_wire_1mm", "steel_wire_1mm", "nylon_monofilament_1mm"}))
                                   : rope_material(d, model);
  body.features = closed || map["segments"].text == "1" ? std::vector<std::string>{"end_0"}
                                                        : std::vector<std::string>{"end_0", "end_1"};
  body.springs_only = model == "springs";
  draw_common(d, body, &map);
}

void draw_soft(Drawing* d, int most) {
  Random& r = d->random;
  DrawnBody body;
  body.name = name_of(*d, "soft");
  body.kind = "soft";
  body.features = {"face_x0", "face_x1"};
  Tree map;
  map["name"] = body.name;
  const int shape = r.whole(0, 9);  // 0: tetrahedra of a file, 1, 2: a surface in a lattice, else a box
  std::string element = r.pick({"tetrahedron", "quadratic_tetrahedron", "springs"});
  if (shape == 0) {
    map["mesh"] = r.pick({"meshes/block.mesh", "meshes/slivers.mesh"});
    map["mesh_scale"] = d->size;
    element = r.pick({"tetrahedron", "quadratic_tetrahedron"});
  } else if (shape <= 2) {
    map["mesh"] = r.pick({"meshes/ell.obj", "meshes/octahedron.obj"});
    map["mesh_scale"] = d->size;
    if (element == "quadratic_tetrahedron") element = "tetrahedron";
    map["lattice"]["cell"] = d->size * r.uniform(0.24, 0.6);
    body.features = {"center"};
  } else {
    draw_box(d, element, most, &map);
  }
  map["element"] = element;
  if (element == "springs") {
    if (r.chance(0.6)) map["neighbours"] = r.pick({"6", "18", "26"});
  } else {
    if (r.chance(0.7)) map["law"] = r.pick(kLaws);
    if (r.chance(0.15)) map["mass"] = "consistent";
  }
  map["material"] = r.chance(0.12)
                        ? Tree(r.pick({"gelatin", "foam_soft", "silicone_00_30", "rubber", "cork", "steel", "oak"}))
                        : soft_material(d);
  body.consistent_mass = map.find("mass") != nullptr;
  body.springs_only = element == "springs";
  body.nodes = most;
  draw_common(d, body, &map);
}

}  // namespace deformable_sim::fuzz
