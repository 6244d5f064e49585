#include "named_materials.h"

#include "deformable_sim/scene/material_library.h"

namespace deformable_sim {
namespace {

/// Read once: a scene may name a material for each of many thousand bodies.
const MaterialLibrary& shipped_materials() {
  static const MaterialLibrary kLibrary = load_material_library(default_material_dir());
  return kLibrary;
}

}  // namespace

void start_from_fabric(const std::string& name, ClothMaterialSpec* out) {
  const FabricData& fabric = shipped_materials().fabric(name);
  out->name = name;
  out->areal_density = fabric.areal_density;
  if (fabric.thickness) out->thickness = *fabric.thickness;
  out->membrane_stiffness = {{fabric.traction_warp(), fabric.traction_weft()}};
  out->poissons_ratio = fabric.stable_poisson() / fabric.weft;
  out->shear_rigidity = fabric.shear;
  out->bending_rigidity = {{fabric.bend_warp, fabric.bend_weft}};
  if (fabric.limit > 0.0) out->elastic_limit = fabric.limit;
}

void start_from_rope(const std::string& name, RopeMaterialSpec* out) {
  const RopeData& rope = shipped_materials().rope(name);
  out->name = name;
  out->linear_density = rope.linear_density;
  out->diameter = rope.diameter;
  out->axial_stiffness = rope.axial;
  out->bending_rigidity = {{rope.bending, rope.bending}};
  out->twist_rigidity = rope.twist;
  if (rope.breaking_strain > 0.0) out->elastic_limit = rope.breaking_strain;
}

void start_from_solid(const std::string& name, SoftMaterialSpec* out) {
  const SolidData& solid = shipped_materials().solid(name);
  out->name = name;
  out->youngs_modulus = solid.youngs_modulus;
  out->poissons_ratio = solid.poissons_ratio;
  out->density = solid.density;
  out->law = solid.law;
  if (solid.elastic_limit > 0.0) out->elastic_limit = solid.elastic_limit;
}

}  // namespace deformable_sim
