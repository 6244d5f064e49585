// Assembling volumes: elements, masses, stresses at nodes.
#include "deformable_sim/core/energy/solid_terms.h"

#include <cmath>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "deformable_sim/core/element/quadratic_tetrahedron.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/largest_stress.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

/// Nodes of one element: four corners, and six middle nodes when quadratic.
template <class Tetrahedron>
std::array<int, static_cast<size_t>(Tetrahedron::kPoints)> nodes_of(const TetMesh& mesh, size_t tet) {
  std::array<int, static_cast<size_t>(Tetrahedron::kPoints)> node{};
  for (size_t k = 0; k < node.size(); ++k) node[k] = k < 4 ? mesh.tets[tet][k] : mesh.mid_nodes[tet][k - 4];
  return node;
}

template <class Tetrahedron>
typename Tetrahedron::Rest rest_of(const TetMesh& mesh, size_t tet) {
  const auto& t = mesh.tets[tet];
  Mat3 edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = mesh.rest.col(t[static_cast<size_t>(k + 1)]) - mesh.rest.col(t[0]);
  return {edges.inverse(), volume_of(mesh, tet)};
}

template <class Tetrahedron>
typename Tetrahedron::Points points_of(const TetMesh& mesh, size_t tet, const Nodes& x) {
  typename Tetrahedron::Points points;
  const auto node = nodes_of<Tetrahedron>(mesh, tet);
  for (size_t k = 0; k < node.size(); ++k) points.col(static_cast<Eigen::Index>(k)) = x.col(node[k]);
  return points;
}

template <class Tetrahedron>
std::unique_ptr<Energy> make_term(const std::string& name, const TetMesh& mesh, const SolidMaterial& material,
                                  double damping, int first_node) {
  std::vector<typename ElementEnergy<Tetrahedron>::Element> elements;
  elements.reserve(mesh.tets.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    auto node = nodes_of<Tetrahedron>(mesh, t);
    for (int& i : node) i += first_node;
    elements.push_back({node, rest_of<Tetrahedron>(mesh, t)});
  }
  return std::make_unique<ElementEnergy<Tetrahedron>>(name, std::move(elements),
                                                      typename Tetrahedron::Parameters{material, damping});
}

void check_material(const SolidMaterial& m, double damping) {
  if (!(m.mu > 0.0) || !std::isfinite(m.mu) || !(m.lambda > -2.0 / 3.0 * m.mu) || !std::isfinite(m.lambda)) {
    throw InputError("Lame's parameters are mu = " + std::to_string(m.mu) +
                     " Pa, lambda = " + std::to_string(m.lambda) + " Pa; mu must be > 0 and lambda > -2/3 mu");
  }
  if (!(m.share >= 0.0 && m.share <= 1.0)) {
    throw InputError("the share of C10 is " + std::to_string(m.share) + "; it must lie in [0, 1]");
  }
  if (!(damping >= 0.0) || !std::isfinite(damping)) {
    throw InputError("the strain rate damping is " + std::to_string(damping) + " s; it must be finite and >= 0");
  }
}

void check_density(double density) {
  if (!(density > 0.0) || !std::isfinite(density)) {
    throw InputError("the density is " + std::to_string(density) + " kg/m^3; it must be finite and > 0");
  }
}

/// integral of N_a N_b over a tetrahedron of volume 1, straight-sided.
Eigen::Matrix<double, 10, 10> quadratic_mass() {
  Eigen::Matrix<double, 10, 10> m;
  for (int a = 0; a < 10; ++a) {
    for (int b = 0; b < 10; ++b) {
      const auto meets = [](int corner, int middle) {
        const auto& e = kTetEdges[static_cast<size_t>(middle - 4)];
        return e[0] == corner || e[1] == corner;
      };
      double entry = 1.0;  // two corners
      if (a == b) {
        entry = a < 4 ? 6.0 : 32.0;
      } else if (a >= 4 && b >= 4) {
        const auto& e = kTetEdges[static_cast<size_t>(a - 4)];
        entry = meets(e[0], b) || meets(e[1], b) ? 16.0 : 8.0;
      } else if (a >= 4 || b >= 4) {
        entry = meets(std::min(a, b), std::max(a, b)) ? -4.0 : -6.0;
      }
      m(a, b) = entry / 420.0;
    }
  }
  return m;
}

/// Cauchy stress of one element at its corners.
std::array<Mat3, 4> stress_at_corners(const TetMesh& mesh, const SolidMaterial& material, const Nodes& x, size_t tet) {
  std::array<Mat3, 4> corner;
  if (!mesh.is_quadratic()) {
    const Mat3 f = LinearTetrahedron::gradient(points_of<LinearTetrahedron>(mesh, tet, x),
                                               rest_of<LinearTetrahedron>(mesh, tet), 0);
    corner.fill(cauchy_stress(material, f));
    return corner;
  }
  // The linear function through the values at the four points: each has kNear at its own corner, kFar at the others.
  std::array<Mat3, 4> inside;
  Mat3 sum = Mat3::Zero();
  const auto points = points_of<QuadraticTetrahedron>(mesh, tet, x);
  for (size_t q = 0; q < 4; ++q) {
    inside[q] = cauchy_stress(material, QuadraticTetrahedron::gradient(points, rest_of<QuadraticTetrahedron>(mesh, tet),
                                                                       static_cast<int>(q)));
    sum += inside[q];
  }
  constexpr double kNear = QuadraticShape::kNear, kFar = QuadraticShape::kFar;
  for (size_t q = 0; q < 4; ++q) corner[q] = (inside[q] - kFar * sum) / (kNear - kFar);
  return corner;
}

}  // namespace

std::unique_ptr<Energy> make_solid(const TetMesh& mesh, const SolidMaterial& material, double strain_rate_damping,
                                   int first_node) {
  check_mesh(mesh);
  check_material(material, strain_rate_damping);
  const std::string law = solid_law_names()[static_cast<size_t>(material.law)];
  if (mesh.is_quadratic()) {
    return make_term<QuadraticTetrahedron>("quadratic tetrahedra: " + law, mesh, material, strain_rate_damping,
                                           first_node);
  }
  return make_term<LinearTetrahedron>("tetrahedra: " + law, mesh, material, strain_rate_damping, first_node);
}

Eigen::VectorXd solid_masses(const TetMesh& mesh, double density) {
  check_density(density);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.rest.cols());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const double total = density * volume_of(mesh, t);
    for (const int corner : mesh.tets[t]) mass[corner] += total * (mesh.is_quadratic() ? 1.0 / 36.0 : 0.25);
    if (!mesh.is_quadratic()) continue;
    for (const int middle : mesh.mid_nodes[t]) mass[middle] += total * 4.0 / 27.0;
  }
  return mass;
}

Eigen::SparseMatrix<double> solid_mass_matrix(const TetMesh& mesh, double density) {
  check_density(density);
  const Eigen::Matrix<double, 10, 10> quadratic = quadratic_mass();
  std::vector<Eigen::Triplet<double>> entries;
  const int points = mesh.is_quadratic() ? 10 : 4;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const double total = density * volume_of(mesh, t);
    const auto node = [&](int k) {
      return k < 4 ? mesh.tets[t][static_cast<size_t>(k)] : mesh.mid_nodes[t][static_cast<size_t>(k - 4)];
    };
    for (int a = 0; a < points; ++a) {
      for (int b = 0; b < points; ++b) {
        const double share = mesh.is_quadratic() ? quadratic(a, b) : (a == b ? 0.1 : 0.05);
        entries.emplace_back(node(a), node(b), total * share);
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(mesh.rest.cols(), mesh.rest.cols());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::vector<Mat3> deformation_gradients(const TetMesh& mesh, const Nodes& x) {
  std::vector<Mat3> result;
  result.reserve(mesh.tets.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_quadratic()) {
      result.push_back(LinearTetrahedron::gradient(points_of<LinearTetrahedron>(mesh, t, x),
                                                   rest_of<LinearTetrahedron>(mesh, t), 0));
      continue;
    }
    // F is linear inside: the mean of the four points is its value at the centroid.
    Mat3 mean = Mat3::Zero();
    const auto points = points_of<QuadraticTetrahedron>(mesh, t, x);
    const auto rest = rest_of<QuadraticTetrahedron>(mesh, t);
    for (int q = 0; q < 4; ++q) mean += 0.25 * QuadraticTetrahedron::gradient(points, rest, q);
    result.push_back(mean);
  }
  return result;
}

std::vector<Mat3> solid_cauchy_stress(const TetMesh& mesh, const SolidMaterial& material, const Nodes& x) {
  const auto n = static_cast<size_t>(mesh.rest.cols());
  std::vector<Mat3> stress(n, Mat3::Zero());
  std::vector<double> volume(n, 0.0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const double weight = volume_of(mesh, t);
    const std::array<Mat3, 4> corner = stress_at_corners(mesh, material, x, t);
    const auto add = [&](int node, const Mat3& value) {
      stress[static_cast<size_t>(node)] += weight * value;
      volume[static_cast<size_t>(node)] += weight;
    };
    for (size_t k = 0; k < 4; ++k) add(mesh.tets[t][k], corner[k]);
    if (!mesh.is_quadratic()) continue;
    for (size_t m = 0; m < kTetEdges.size(); ++m) {
      const auto a = static_cast<size_t>(kTetEdges[m][0]), b = static_cast<size_t>(kTetEdges[m][1]);
      add(mesh.mid_nodes[t][m], 0.5 * (corner[a] + corner[b]));
    }
  }
  for (size_t i = 0; i < n; ++i) stress[i] /= volume[i];
  return stress;
}

Eigen::VectorXf solid_stress(const TetMesh& mesh, const SolidMaterial& material, const Nodes& x) {
  const std::vector<Mat3> stress = solid_cauchy_stress(mesh, material, x);
  Eigen::VectorXf result(static_cast<Eigen::Index>(stress.size()));
  for (size_t i = 0; i < stress.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = shown_stress(static_cast<float>(von_mises(stress[i])));
  }
  return result;
}

}  // namespace deformable_sim
