#include "body_rules.h"

#include <vector>

#include "build_parts.h"
#include "deformable_sim/scene/tet_mesh_file.h"

namespace deformable_sim {
namespace {

using Keys = std::vector<const char*>;

/// Refuses those of the keys that are given. `map` may be null.
void only_with(const YamlValue* map, const std::string& path, const Keys& keys, const std::string& what) {
  for (const char* key : keys) {
    const YamlValue* value = map ? map->find(key) : nullptr;
    if (value) refuse_key(*value, path + "." + key, what);
  }
}

bool has(const YamlValue* map, const char* key) {
  return map && map->find(key);
}

void check_springs(const YamlValue& entry, const YamlValue* material, const std::string& path, const BodySpec& body) {
  const ClothMaterialSpec& m = body.cloth_material;
  only_with(&entry, path, {"law"}, "belongs to model: membrane");
  only_with(material, path + ".material", {"shear_rigidity"}, "belongs to model: membrane");
  for (const char* key : {"youngs_modulus", "membrane_stiffness"}) {
    if (has(material, key) && m.membrane()[0] != m.membrane()[1]) {
      refuse(*material->find(key), path + ".material." + key,
             "springs are the same along warp and weft: give one number, or model: membrane");
    }
  }
  if (!body.mesh.empty()) {
    only_with(material, path + ".material", {"shear_stiffness", "poissons_ratio"},
              "is for grids; a triangle mesh of springs has a ratio of 1/3");
  }
  if (body.cloth.model == ClothModel::kProvot && !body.mesh.empty()) {
    refuse_key(*entry.find("model"), path + ".model", "provot is for grids; a mesh has springs or a membrane");
  }
}

void check_membrane(const YamlValue& entry, const YamlValue* material, const std::string& path, const BodySpec& body) {
  only_with(material, path + ".material", {"stretch_stiffness", "shear_stiffness", "bend_stiffness"},
            "belongs to springs; a membrane has membrane_stiffness (or youngs_modulus), shear_rigidity and "
            "bending_rigidity");
  if (body.cloth.bending == ClothBending::kSprings) {
    refuse(*entry.find("bending"), path + ".bending", "a membrane bends by hinges or quadratic");
  }
  const ClothMaterialSpec& m = body.cloth_material;
  const bool any = body.cloth.law == "hooke" || body.cloth.law == "st_venant_kirchhoff";
  if (!any && (m.membrane()[0] != m.membrane()[1] || m.shear_rigidity)) {
    refuse(entry.find("law") ? *entry.find("law") : entry, path + ".law",
           body.cloth.law + " is isotropic; warp, weft and shear_rigidity of their own need st_venant_kirchhoff");
  }
}

void check_bending(const YamlValue& entry, const YamlValue* material, const std::string& path, const BodySpec& body) {
  const ClothBending bending = bending_of(body);
  if (bending == ClothBending::kSprings) {
    only_with(&entry, path, {"creases"}, "belongs to bending: hinges");
    only_with(&entry, path, {"rest_shape"}, "belongs to bending: hinges or quadratic");
    only_with(material, path + ".material", {"bending_rigidity"},
              "belongs to bending: hinges or quadratic; springs have bend_stiffness");
    only_with(material, path + ".material", {"bending_damping"},
              "belongs to bending: hinges or quadratic; springs have damping");
    return;
  }
  only_with(material, path + ".material", {"bend_stiffness"},
            "belongs to bending: springs; here it is bending_rigidity");
  if (body.cloth.model != ClothModel::kMembrane && !body.cloth_material.bending_rigidity) {
    refuse(*entry.find("bending"), path + ".bending", "needs material.bending_rigidity (N m)");
  }
  if (bending != ClothBending::kQuadratic) return;
  only_with(&entry, path, {"creases"}, "belongs to bending: hinges; quadratic is flat at rest");
  if (!body.mesh.empty() && body.cloth.rest_shape != RestShape::kFlat) {
    refuse(*entry.find("bending"), path + ".bending", "quadratic is flat at rest: needs rest_shape: flat");
  }
}

void check_cloth(const YamlValue& entry, const std::string& path, const BodySpec& body) {
  const YamlValue* material = entry.find("material");
  if (body.cloth.model == ClothModel::kMembrane) {
    check_membrane(entry, material, path, body);
  } else {
    check_springs(entry, material, path, body);
  }
  check_bending(entry, material, path, body);
  if (body.cloth.pressure == 0.0) only_with(&entry, path, {"pressure_rise"}, "belongs to pressure");
  if (body.look.checker == 0.0) {
    only_with(entry.find("look"), path + ".look", {"checker_color"}, "belongs to checker");
  }
  if (!body.mesh.empty() && body.cloth.upsample > 1) {
    refuse_key(*entry.find("visual"), path + ".visual", "is for grids");
  }
}

void check_rope(const YamlValue& entry, const std::string& path, const BodySpec& body) {
  if (body.closed && body.segments < 3) {
    refuse(*entry.find("closed"), path + ".closed", "a loop needs at least 3 segments");
  }
  if (const YamlValue* points = entry.find("path")) {
    if (body.rope.model == RopeModel::kRod) refuse(*points, path + ".path", "belongs to model: springs or untwisted");
    if (body.path.size() < 2) refuse(*points, path + ".path", "needs two points at least");
    for (size_t k = 1; k < body.path.size(); ++k) {
      if ((body.path[k] - body.path[k - 1]).norm() > 1e-6) continue;
      refuse(*points, path + ".path[" + std::to_string(k) + "]", "is where the point before it is");
    }
  }
  const YamlValue* material = entry.find("material");
  if (body.rope.model == RopeModel::kRod) {
    if (body.closed) only_with(&entry, path, {"initial_twist", "start"}, "belongs to an open rod");
    only_with(material, path + ".material", {"stretch_stiffness", "bend_stiffness"},
              "belongs to model: springs; a rod has axial_stiffness and bending_rigidity");
    return;
  }
  only_with(&entry, path, {"natural_curvature", "natural_twist", "initial_twist", "start"}, "belongs to model: rod");
  only_with(entry.find("look"), path + ".look", {"stripe"}, "belongs to model: rod; no other rope has a twist to show");
  if (body.rope.model == RopeModel::kUntwisted) {
    only_with(material, path + ".material", {"section", "shear_modulus", "twist_rigidity"}, "belongs to model: rod");
    only_with(material, path + ".material", {"stretch_stiffness", "bend_stiffness"},
              "belongs to model: springs; this one has axial_stiffness and bending_rigidity");
    const auto& rigidity = body.rope_material.bending_rigidity;
    if (rigidity && (*rigidity)[0] != (*rigidity)[1]) {
      refuse(*material->find("bending_rigidity"), path + ".material.bending_rigidity",
             "model: untwisted is round: both values must be equal; model: rod tells them apart");
    }
    return;
  }
  only_with(material, path + ".material", {"bending_rigidity"}, "belongs to model: untwisted or rod");
  only_with(material, path + ".material", {"section", "shear_modulus", "twist_rigidity"}, "belongs to model: rod");
}

void check_solid_law(const YamlValue& entry, const std::string& path, const SoftModelSpec& soft) {
  const std::string& law = soft.law.empty() ? soft.material.law : soft.law;
  const YamlValue* material = entry.find("material");
  if (law != "neo_hookean" || soft.material.poissons_ratio >= 0.0 || !has(material, "poissons_ratio")) return;
  refuse(*material->find("poissons_ratio"), path + ".material.poissons_ratio",
         "law neo_hookean needs 0 or more: below, its energy falls without bound when it is pressed together; "
         "stable_neo_hookean, mooney_rivlin and corotational take any",
         Code::kOutOfRange);
}

void check_soft(const YamlValue& entry, const std::string& path, const BodySpec& body) {
  const bool tetrahedra = !body.mesh.empty() && is_tet_mesh_file(body.mesh);
  if (body.mesh.empty()) {
    only_with(&entry, path, {"lattice", "mesh_scale"}, "belongs to mesh");
  } else if (tetrahedra) {
    only_with(&entry, path, {"lattice"}, "belongs to a mesh that is a surface; this one has tetrahedra of its own");
  } else if (!body.soft.lattice_cell) {
    refuse(*entry.find("mesh"), path + ".mesh",
           "a surface needs lattice: {cell: METRES}; tetrahedra come from .msh, .mesh or .node files");
  }
  if (element_of(body.soft) != SoftElement::kSprings) {
    only_with(&entry, path, {"neighbours"}, "belongs to element: springs");
    check_solid_law(entry, path, body.soft);
    return;
  }
  only_with(&entry, path, {"law"}, "belongs to tetrahedra; springs are linear");
  only_with(&entry, path, {"mass"}, "belongs to tetrahedra; springs have their mass at the nodes");
  if (tetrahedra) {
    refuse(*entry.find("element"), path + ".element", "springs need the cells of a box or a lattice");
  }
}

}  // namespace

void check_body_keys(const YamlValue& entry, const std::string& path, const BodySpec& body) {
  switch (body.kind) {
    case BodyKind::kCloth:
      return check_cloth(entry, path, body);
    case BodyKind::kRope:
      return check_rope(entry, path, body);
    case BodyKind::kSoft:
      return check_soft(entry, path, body);
  }
}

double expected_nodes(const BodySpec& body) {
  if (body.kind == BodyKind::kRope) return body.segments + 1.0;
  if (!body.mesh.empty()) return 0.0;
  if (body.kind == BodyKind::kCloth) return (body.cells[0] + 1.0) * (body.cells[1] + 1.0);
  const std::array<int, 3> cells = cells_of(body.soft);
  const double parts = element_of(body.soft) == SoftElement::kQuadraticTetrahedron ? 2.0 : 1.0;
  return (parts * cells[0] + 1.0) * (parts * cells[1] + 1.0) * (parts * cells[2] + 1.0);
}

double expected_skin_vertices(const BodySpec& body) {
  const double parts = body.cloth.upsample;
  if (body.kind != BodyKind::kCloth || !body.mesh.empty() || body.cloth.upsample == 1) return 0.0;
  return (parts * body.cells[0] + 1.0) * (parts * body.cells[1] + 1.0);
}

}  // namespace deformable_sim
