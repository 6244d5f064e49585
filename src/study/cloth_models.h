// Fabrics as specimens: which energies each model of cloth gives a mesh.
#pragma once

#include <string>

#include "deformable_sim/core/material/real_materials.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "specimen.h"

namespace deformable_sim::study {

struct ClothModel {
  bool springs = false;       // structural, shear and bend springs; else a membrane of finite elements
  bool bend_springs = false;  // bending by springs over two cells; else by hinges ...
  bool quadratic = false;     // ... or by the quadratic energy
};

/// springs, springs_hinges, membrane, membrane_quadratic. Throws InputError.
ClothModel cloth_model(const std::string& name);

/// A sheet of the fabric, its warp turned by `angle` (rad) from the x axis of the mesh: finite elements only.
Specimen make_sheet(const TriangleMesh& mesh, const FabricData& fabric, const ClothModel& model, double angle = 0.0);

/// The one modulus (N/m) that springs are made for.
double spring_membrane(const FabricData& fabric);

}  // namespace deformable_sim::study
