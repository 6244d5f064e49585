// Soft bodies of a scene as tetrahedra or as lattices of springs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "build_parts.h"
#include "deformable_sim/core/energy/solid_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_moduli.h"
#include "deformable_sim/core/topology/skin.h"
#include "deformable_sim/scene/mesh_file.h"
#include "deformable_sim/scene/tet_mesh_file.h"
#include "features.h"
#include "schema.h"

namespace deformable_sim {
namespace {

constexpr int kNodesThrough = 4, kMostAlong = 20;  // spaces between nodes, of a box without cells
constexpr double kLocked = 0.9;                    // of the right deflection in bending: below, a note says so

/// The simulated volume and, when there is one, the surface that it carries.
struct SoftShape {
  TetMesh volume;
  Vec3 cell = Vec3::Zero();  // of a regular lattice; zero: none
  std::shared_ptr<const TriangleMesh> skin;
};

void check_lattice_size(const TriangleMesh& surface, double cell) {
  const Vec3 size = surface.rest.rowwise().maxCoeff() - surface.rest.rowwise().minCoeff();
  const double cells = (size / cell).array().ceil().prod();
  if (cells > 4.0 * kMaxNodes) {
    throw InputError("lattice.cell: " + format_number(cells) + " cells around a surface of " +
                         format_vector(size.data(), 3) + " m; at most " + std::to_string(4 * kMaxNodes) +
                         ": choose larger ones",
                     Code::kOutOfRange);
  }
}

SoftShape shape_of(const BodySpec& spec) {
  const SoftModelSpec& soft = spec.soft;
  SoftShape shape;
  if (soft.box_size) {
    const std::array<int, 3> cells = cells_of(soft);
    shape.volume = make_box(*soft.box_size, cells);
    shape.cell = soft.box_size->array() / Vec3(cells[0], cells[1], cells[2]).array();
  } else if (soft.lattice_cell) {
    shape.skin = std::make_shared<const TriangleMesh>(load_mesh(spec.mesh, spec.mesh_scale));
    check_lattice_size(*shape.skin, *soft.lattice_cell);
    shape.volume = make_lattice_around(*shape.skin, *soft.lattice_cell);
    shape.cell.setConstant(*soft.lattice_cell);
  } else {
    shape.volume = load_tet_mesh(spec.mesh, spec.mesh_scale);
    check_mesh(shape.volume);
  }
  return shape;
}

double volume_of(const TetMesh& mesh) {
  double sum = 0.0;
  for (size_t t = 0; t < mesh.tets.size(); ++t) sum += volume_of(mesh, t);
  return sum;
}

/// Edges of the elements: of quadratic ones the halves on either side of a middle node.
std::vector<StrainEdge> element_edges(const TetMesh& mesh, int first_node) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  std::set<std::array<int, 2>> pairs;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (size_t e = 0; e < 6; ++e) {
      const int a = mesh.tets[t][static_cast<size_t>(kEdges[e][0])],
                b = mesh.tets[t][static_cast<size_t>(kEdges[e][1])];
      if (mesh.is_quadratic()) {
        const int middle = mesh.mid_nodes[t][e];
        pairs.insert({std::min(a, middle), std::max(a, middle)});
        pairs.insert({std::min(b, middle), std::max(b, middle)});
      } else {
        pairs.insert({std::min(a, b), std::max(a, b)});
      }
    }
  }
  std::vector<StrainEdge> edges;
  for (const auto& [a, b] : pairs) {
    edges.push_back({{a + first_node, b + first_node}, (mesh.rest.col(b) - mesh.rest.col(a)).norm()});
  }
  return edges;
}

/// Tetrahedra: the term, masses, stresses, and notes on what the element or law cannot do.
Eigen::VectorXd add_elements(const BodySpec& spec, const std::shared_ptr<const TetMesh>& mesh, Body* body,
                             Parts* parts) {
  const SoftMaterialSpec& m = spec.soft.material;
  const std::string& law = spec.soft.law.empty() ? m.law : spec.soft.law;
  SolidMaterial material = solid_material(solid_law(law), m.youngs_modulus, m.poissons_ratio);
  material.share = m.mooney_rivlin_share;
  parts->terms.push_back(make_solid(*mesh, material, m.damping, body->first_node));
  body->strain_edges = element_edges(*mesh, body->first_node);
  body->stress = [mesh, material](const Nodes& x) { return solid_stress(*mesh, material, x); };
  const double factor = expected_bending_factor(*mesh, std::max(0.0, m.poissons_ratio));
  if (factor < kLocked) {
    char text[240];
    std::snprintf(
        text, sizeof text,
        mesh->is_quadratic()
            ? ": clamped at an end, a beam of these quadratic tetrahedra ten times as long as thick bends about "
              "%.3g times too stiffly at this mesh and Poisson's ratio; more cells through the thickness mend it"
            : ": linear tetrahedra bend about %.2g times too stiffly at this mesh and Poisson's ratio; more "
              "cells or element: quadratic_tetrahedron mend it",
        1.0 / factor);
    parts->notes.push_back("body " + spec.name + text);
  }
  if (material.law == SolidLaw::kHooke) parts->notes.push_back("body " + spec.name + ": " + kHookeNote);
  if (spec.soft.mass == SoftMass::kConsistent) {
    const Eigen::SparseMatrix<double> mass = solid_mass_matrix(*mesh, m.density);
    for (Eigen::Index k = 0; k < mass.outerSize(); ++k) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(mass, k); it; ++it) {
        parts->mass_entries.emplace_back(body->first_node + static_cast<int>(it.row()),
                                         body->first_node + static_cast<int>(it.col()), it.value());
      }
    }
  }
  return solid_masses(*mesh, m.density);
}

Eigen::VectorXd add_lattice_springs(const BodySpec& spec, const SoftShape& shape, Body* body, Parts* parts) {
  const SoftMaterialSpec& m = spec.soft.material;
  LatticeStiffness stiffness;
  stiffness.neighbours = static_cast<LatticeNeighbours>(spec.soft.neighbours);
  stiffness.youngs_modulus = m.youngs_modulus;
  stiffness.damping_time = m.damping;
  const std::vector<LatticeCell> cells = lattice_cells(shape.volume, shape.cell);
  const SpringNetwork network = lattice_network(shape.volume.rest, cells, stiffness);
  const auto add = [&](const char* name, const std::vector<SpringLink>& links) {
    if (!links.empty()) parts->terms.push_back(make_springs(name, links, body->first_node));
  };
  add("lattice edge springs", network.stretch);
  add("lattice face springs", network.shear);
  add("lattice body springs", network.bend);
  add_strain_edges(network.stretch, body);
  const std::string gap = spring_gap(m.youngs_modulus, m.poissons_ratio,
                                     constants_of(solid_moduli(shape.volume.rest, network, volume_of(shape.volume))));
  if (!gap.empty()) parts->notes.push_back("body " + spec.name + ": " + gap);
  return lattice_masses(shape.volume.rest, cells, m.density);
}

}  // namespace

SoftElement element_of(const SoftModelSpec& soft) {
  const bool box = soft.box_size.has_value();
  return soft.element.value_or(box ? SoftElement::kQuadraticTetrahedron : SoftElement::kTetrahedron);
}

std::array<int, 3> cells_of(const SoftModelSpec& soft) {
  if (soft.cells) return *soft.cells;
  const int spaces = element_of(soft) == SoftElement::kQuadraticTetrahedron ? 2 : 1;  // in a cell
  const Vec3 size = *soft.box_size;
  const double cell = spaces * std::max(size.minCoeff() / kNodesThrough, size.maxCoeff() / kMostAlong);
  std::array<int, 3> cells{};
  for (size_t k = 0; k < 3; ++k) {
    cells[k] = std::max(1, static_cast<int>(std::lround(size[static_cast<Eigen::Index>(k)] / cell)));
  }
  return cells;
}

void add_soft(const BodySpec& spec, Body* body, Parts* parts) {
  SoftShape shape = shape_of(spec);
  const SoftElement element = element_of(spec.soft);
  if (element == SoftElement::kQuadraticTetrahedron) shape.volume = with_mid_nodes(shape.volume);
  const auto volume = std::make_shared<const TetMesh>(shape.volume);
  const auto surface = std::make_shared<const TriangleMesh>(boundary_of(*volume));
  const Eigen::VectorXd mass = element == SoftElement::kSprings ? add_lattice_springs(spec, shape, body, parts)
                                                                : add_elements(spec, volume, body, parts);
  append_triangles(surface->triangles, body->first_node, &parts->solid_triangles);
  place_nodes(volume->rest, spec.pose.pose(), mass, body, parts);
  if (spec.soft.material.elastic_limit) {
    body->valid_strain = {-*spec.soft.material.elastic_limit, *spec.soft.material.elastic_limit};
  }
  body->contact_at_faces = spec.contact_at_faces;
  body->contact_anywhere = spec.contact_anywhere;
  body->contact_radius = spec.contact_radius.value_or(kMinContactRadius);
  body->features = solid_features(*volume, spec.soft.box_size ? Corners::kOfBounds : Corners::kNone);
  body->volume = volume;
  body->surface = surface;
  if (shape.skin) body->skin = make_skin(*shape.skin, *volume);
}

}  // namespace deformable_sim
