// Cloth of a scene as springs or as a membrane.
#include <algorithm>
#include <cmath>

#include "build_parts.h"
#include "creases.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_moduli.h"
#include "deformable_sim/core/strain_limit.h"
#include "deformable_sim/scene/mesh_file.h"
#include "features.h"
#include "schema.h"

namespace deformable_sim {
namespace {

constexpr double kProvotFlexion = 0.01;  // of E h: what springs that only keep a sheet from crumpling need

double isotropic_membrane(const ClothMaterialSpec& material) {
  const std::array<double, 2> both = material.membrane();
  return both[0] == both[1] ? both[0] : 0.5 * (both[0] + both[1]);
}

/// What springs and plates can have; measured fabrics, pulled along warp, may contract more, or grow wider.
constexpr double kLargestRatio = 0.45;
double ratio_in_range(const ClothMaterialSpec& material) {
  if (material.name.empty()) return material.poissons_ratio;
  return std::clamp(material.poissons_ratio, 0.0, kLargestRatio);
}

SpringNetwork springs_of(const BodySpec& spec, const TriangleMesh& mesh) {
  const ClothMaterialSpec& material = spec.cloth_material;
  SheetStiffness stiffness;
  stiffness.membrane = isotropic_membrane(material);
  stiffness.poissons_ratio = ratio_in_range(material);
  stiffness.stretch = material.stretch_stiffness;
  stiffness.shear = material.shear_stiffness;
  stiffness.bend = material.bend_stiffness;
  // Hinges resist bending; springs beside them would do it twice.
  if (bending_of(spec) != ClothBending::kSprings) stiffness.bend = 0.0;
  stiffness.damping_time = material.damping;
  return sheet_network(mesh, stiffness);
}

/// Provot's springs; what is not given is as square cells of the material have it.
SpringNetwork provot_of(const BodySpec& spec, const TriangleMesh& mesh) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const double membrane = isotropic_membrane(material), ratio = ratio_in_range(material);
  const double along = membrane / (1.0 - ratio * ratio);
  ProvotStiffness stiffness;
  stiffness.shear = material.shear_stiffness.value_or(ratio * along);
  stiffness.flexion = material.bend_stiffness.value_or(kProvotFlexion * membrane);
  if (bending_of(spec) != ClothBending::kSprings) stiffness.flexion = 0.0;
  stiffness.structural =
      material.stretch_stiffness.value_or(std::max(0.01 * along, along - stiffness.shear - 4.0 * stiffness.flexion));
  stiffness.damping_time = material.damping;
  return provot_network(mesh, stiffness);
}

/// Says what a spring network makes of the material, where a real one was asked for by its name.
void note_gap(const BodySpec& spec, const TriangleMesh& mesh, const SpringNetwork& network, Parts* parts) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const std::array<double, 2> both = material.membrane();
  if (material.name.empty()) return;
  if (std::abs(both[0] - both[1]) > 0.01 * both[0]) {
    parts->notes.push_back("body " + spec.name + ": springs are the same along warp and weft, " +
                           format_number(isotropic_membrane(material)) + " N/m; " + material.name + " has " +
                           format_number(both[0]) + " and " + format_number(both[1]) +
                           "; model: membrane tells them apart");
  }
  if (!mesh.is_grid()) return;
  const double area = spec.size[0] * spec.size[1];
  const std::string gap = spring_gap(isotropic_membrane(material), material.poissons_ratio,
                                     constants_of(sheet_moduli(mesh.rest, network, area)));
  if (!gap.empty()) parts->notes.push_back("body " + spec.name + ": " + gap);
}

SheetMaterial sheet_of(const BodySpec& spec) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const std::array<double, 2> both = material.membrane();
  SheetMaterial sheet;
  sheet.law = solid_law(spec.cloth.law);
  sheet.warp = both[0];
  sheet.weft = both[1];
  sheet.poissons_ratio = material.poissons_ratio;
  const double mean = both[0] == both[1] ? both[0] : std::sqrt(both[0] * both[1]);
  sheet.shear = material.shear_rigidity.value_or(mean / (2.0 * (1.0 + material.poissons_ratio)));
  sheet.thickness = material.thickness;
  sheet.damping = material.damping;
  return sheet;
}

double bending_damping(const BodySpec& spec) {
  return spec.cloth_material.bending_damping.value_or(spec.cloth_material.damping);
}

BendingMaterial bending_material(const BodySpec& spec, const TriangleMesh& mesh) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const std::array<double, 2> both = material.membrane();
  const double h = material.thickness;
  const std::array<double, 2> rigidity =
      material.bending_rigidity.value_or(std::array<double, 2>{{both[0] * h * h / 12.0, both[1] * h * h / 12.0}});
  BendingMaterial bending;
  bending.warp = rigidity[0];
  bending.weft = rigidity[1];
  bending.poissons_ratio = ratio_in_range(material);
  bending.damping = bending_damping(spec);
  const bool meshed = spec.cloth.rest_shape == RestShape::kAsMeshed && !mesh.is_grid();
  bending.rest = meshed ? BendingMaterial::Rest::kAsMeshed : BendingMaterial::Rest::kFlat;
  bending.creases = find_creases(mesh, spec.cloth.creases);
  return bending;
}

/// Of quadratic bending on a grid; empty for all other bending.
std::vector<QuadraticWeight> bending_differences(const BodySpec& spec, const TriangleMesh& mesh) {
  if (!mesh.is_grid() || bending_of(spec) != ClothBending::kQuadratic) return {};
  return grid_bending_weights(mesh, bending_material(spec, mesh));
}

void add_quadratic_bending(const BodySpec& spec, const TriangleMesh& mesh,
                           const std::vector<QuadraticWeight>& differences, int first_node, Parts* parts) {
  parts->terms.push_back(
      make_quadratic_links("bending: quadratic",
                           mesh.is_grid() ? differences : quadratic_bending_weights(mesh, bending_material(spec, mesh)),
                           bending_damping(spec), first_node));
}

/// What fast kernels see of a grid of springs.
void add_grid(const BodySpec& spec, const TriangleMesh& mesh, const SpringNetwork& network,
              const std::vector<QuadraticWeight>& differences, int first_node, Parts* parts) {
  std::vector<const Energy*> replaces;
  if (bending_of(spec) == ClothBending::kQuadratic) replaces.push_back(parts->terms.back().get());
  auto sheet = make_grid_sheet(mesh, network, differences, bending_damping(spec), first_node);
  if (sheet) parts->grids.push_back({std::move(*sheet), parts->springs.size() - 1, std::move(replaces)});
}

void add_bending(const BodySpec& spec, const TriangleMesh& mesh, const std::vector<QuadraticWeight>& differences,
                 int first_node, Parts* parts) {
  switch (bending_of(spec)) {
    case ClothBending::kSprings:
      break;
    case ClothBending::kHinges:
      parts->terms.push_back(make_bending(mesh, bending_material(spec, mesh), first_node));
      break;
    case ClothBending::kQuadratic:
      add_quadratic_bending(spec, mesh, differences, first_node, parts);
      break;
  }
}

/// Edges along warp and weft of a grid, all edges of another mesh, as links as stiff as the membrane between them.
std::vector<SpringLink> structural_edges(const TriangleMesh& mesh, const ClothMaterialSpec& material) {
  std::vector<SpringLink> links;
  const std::array<double, 2> both = material.membrane();
  for (const auto& [a, b] : edges_of(mesh)) {
    const bool row = b - a == 1, column = b - a == mesh.cols;
    if (mesh.is_grid() && !row && !column) continue;
    const double length = (mesh.rest.col(b) - mesh.rest.col(a)).norm();
    links.push_back({a, b, length, column ? both[1] : both[0], 0.0});
  }
  return links;
}

void add_membrane(const BodySpec& spec, const std::shared_ptr<const TriangleMesh>& mesh, Body* body, Parts* parts) {
  const SheetMaterial sheet = sheet_of(spec);
  parts->terms.push_back(make_membrane(*mesh, sheet, body->first_node));
  body->stress = [mesh, sheet](const Nodes& x) { return sheet_stress(*mesh, sheet, x); };
  if (sheet.law == SolidLaw::kHooke) {
    parts->notes.push_back("body " + spec.name + ": " + kHookeNote);
  }
}

void add_pressure(const BodySpec& spec, const TriangleMesh& mesh, int first_node, Parts* parts) {
  if (spec.cloth.pressure == 0.0) return;
  if (!is_closed(mesh))
    throw InputError("pressure needs a closed mesh; this one has an edge with a face on one side only");
  const double outwards = enclosed_volume(mesh) < 0.0 ? -1.0 : 1.0;
  parts->terms.push_back(
      make_pressure(mesh.triangles, outwards * spec.cloth.pressure, spec.cloth.pressure_rise, first_node));
}

}  // namespace

ClothBending bending_of(const BodySpec& spec) {
  if (spec.cloth.bending) return *spec.cloth.bending;
  const bool known = spec.cloth_material.bending_rigidity || spec.cloth.model == ClothModel::kMembrane;
  return known ? ClothBending::kHinges : ClothBending::kSprings;
}

void add_cloth(const BodySpec& spec, Body* body, Parts* parts) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const auto mesh = std::make_shared<const TriangleMesh>(
      spec.mesh.empty() ? make_grid(spec.size[0], spec.size[1], spec.cells[0], spec.cells[1])
                        : load_mesh(spec.mesh, spec.mesh_scale));
  std::vector<SpringLink> structural;
  SpringNetwork network;
  if (spec.cloth.model == ClothModel::kMembrane) {
    add_membrane(spec, mesh, body, parts);
    structural = structural_edges(*mesh, material);
  } else {
    network = spec.cloth.model == ClothModel::kProvot ? provot_of(spec, *mesh) : springs_of(spec, *mesh);
    append_network(network, body->first_node, parts);
    note_gap(spec, *mesh, network, parts);
    structural = network.stretch;
  }
  const std::vector<QuadraticWeight> differences = bending_differences(spec, *mesh);
  add_bending(spec, *mesh, differences, body->first_node, parts);
  if (mesh->is_grid() && spec.cloth.model != ClothModel::kMembrane) {
    add_grid(spec, *mesh, network, differences, body->first_node, parts);
  }
  add_pressure(spec, *mesh, body->first_node, parts);
  add_strain_edges(structural, body);
  if (spec.cloth.strain_limit) {
    const std::vector<StrainLimit> limits = strain_limits(structural, *spec.cloth.strain_limit, body->first_node);
    parts->strain_limits.insert(parts->strain_limits.end(), limits.begin(), limits.end());
  }
  if (material.elastic_limit) body->valid_strain[1] = *material.elastic_limit;
  append_triangles(mesh->triangles, body->first_node, &parts->sheet_triangles);
  place_nodes(mesh->rest, spec.pose.pose(), sheet_masses(*mesh, material.areal_density), body, parts);
  body->contact_at_faces = spec.contact_at_faces;
  body->contact_anywhere = spec.contact_anywhere;
  body->contact_radius = spec.contact_radius.value_or(std::max(0.5 * material.thickness, kMinContactRadius));
  body->features = sheet_features(*mesh);
  body->surface = mesh;
  if (spec.cloth.upsample > 1) body->skin = make_upsampled_skin(*mesh, spec.cloth.upsample);
}

}  // namespace deformable_sim
