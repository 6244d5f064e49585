#include "cloth_models.h"

#include <algorithm>
#include <cmath>

#include "bench.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim::study {

std::vector<std::string> cloth_models() {
  return {"springs", "springs_hinges", "membrane", "membrane_quadratic"};
}

ClothModel cloth_model(const std::string& name) {
  check_model(name, cloth_models(), "fabric");
  return {name.rfind("springs", 0) == 0, name == "springs", name == "membrane_quadratic"};
}

double spring_membrane(const FabricData& fabric) {
  return 0.5 * (fabric.traction_warp() + fabric.traction_weft());
}

Specimen make_sheet(const TriangleMesh& mesh, const FabricData& fabric, const ClothModel& model, double angle) {
  Specimen sheet(mesh.rest, sheet_masses(mesh, fabric.areal_density));
  const Vec3 warp(std::cos(angle), std::sin(angle), 0.0);
  if (model.springs) {
    SheetStiffness stiffness;
    stiffness.membrane = spring_membrane(fabric);
    stiffness.poissons_ratio = std::clamp(fabric.poissons_ratio(), 0.0, 0.49);
    if (!model.bend_springs) stiffness.bend = 0.0;
    const SpringNetwork network = sheet_network(mesh, stiffness);
    sheet.add(make_springs("stretch springs", network.stretch, 0));
    if (!network.shear.empty()) sheet.add(make_springs("shear springs", network.shear, 0));
    if (!network.bend.empty()) sheet.add(make_springs("bend springs", network.bend, 0));
  } else {
    SheetMaterial membrane;
    membrane.warp = fabric.traction_warp();
    membrane.weft = fabric.traction_weft();
    membrane.poissons_ratio = fabric.poissons_ratio();
    membrane.shear = fabric.shear;
    membrane.warp_direction = warp;
    sheet.add(make_membrane(mesh, membrane, 0));
  }
  if (!model.bend_springs) {
    BendingMaterial bending;
    bending.warp = fabric.bend_warp;
    bending.weft = fabric.bend_weft;
    bending.twist = fabric.bend_twist();
    bending.warp_direction = warp;
    sheet.add(model.quadratic ? make_quadratic_bending(mesh, bending, 0) : make_bending(mesh, bending, 0));
  }
  return sheet;
}

}  // namespace deformable_sim::study
