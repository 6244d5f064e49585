// How far a mesh of tetrahedra is too stiff in bending.
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/energy/solid_terms.h"

namespace deformable_sim {
namespace {

/// Are there faces with one tetrahedron the mirror image of the other, reflected at a right angle: does the middle of
/// the two opposite nodes fall on a corner of the face? So it is between mirrored cubes, and not by chance elsewhere.
bool made_of_mirrored_cubes(const TetMesh& mesh) {
  std::map<std::array<int, 3>, int> opposite_of;
  size_t shared = 0, mirrored = 0;
  for (const auto& tet : mesh.tets) {
    for (size_t k = 0; k < 4; ++k) {
      std::array<int, 3> face{tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]};
      std::sort(face.begin(), face.end());
      const auto [known, is_new] = opposite_of.insert({face, tet[k]});
      if (is_new) continue;
      const Vec3 a = mesh.rest.col(known->second), b = mesh.rest.col(tet[k]), middle = 0.5 * (a + b);
      ++shared;
      for (const int i : face) mirrored += (mesh.rest.col(i) - middle).norm() < 1e-6 * (a - b).norm() ? 1 : 0;
    }
  }
  return 10 * mirrored >= shared;
}

/// Heights of the nodes along the direction in which the body is thinnest, among its principal axes and normals of its
/// surface: the width of a box is least along one of them.
Eigen::VectorXd heights_across(const TetMesh& mesh) {
  const Vec3 center = mesh.rest.rowwise().mean();
  const Nodes offset = mesh.rest.colwise() - center;
  const Mat3 moments = offset * offset.transpose();
  const Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(moments).eigenvectors();
  std::vector<Vec3> directions = {axes.col(0), axes.col(1), axes.col(2)};
  const TriangleMesh surface = boundary_of(mesh);
  constexpr size_t kMostNormals = 64;
  const size_t stride = surface.triangles.size() / kMostNormals + 1;
  for (size_t k = 0; k < surface.triangles.size(); k += stride) {
    const auto& t = surface.triangles[k];
    const Vec3 a = surface.rest.col(t[0]);
    directions.push_back((surface.rest.col(t[1]) - a).cross(surface.rest.col(t[2]) - a).normalized());
  }
  Eigen::VectorXd thinnest;
  for (const Vec3& direction : directions) {
    Eigen::VectorXd height = offset.transpose() * direction;
    const auto width = [](const Eigen::VectorXd& h) { return h.maxCoeff() - h.minCoeff(); };
    if (thinnest.size() == 0 || width(height) < (1.0 - 1e-9) * width(thinnest)) thinnest.swap(height);
  }
  return thinnest;
}

/// Thickness over the mean height of the elements.
double elements_through_thickness(const TetMesh& mesh) {
  const Eigen::VectorXd height = heights_across(mesh);
  double sum = 0.0, volume = 0.0;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& n = mesh.tets[t];
    const auto [low, high] = std::minmax({height[n[0]], height[n[1]], height[n[2]], height[n[3]]});
    sum += volume_of(mesh, t) * (high - low);
    volume += volume_of(mesh, t);
  }
  return (height.maxCoeff() - height.minCoeff()) * volume / sum;
}

}  // namespace

double expected_bending_factor(const TetMesh& mesh, double poissons_ratio) {
  const double n = elements_through_thickness(mesh), nu = std::max(0.0, poissons_ratio), x = 2.0 * nu;
  if (mesh.is_quadratic()) {
    return 1.0 / (1.0 + 0.028 * x * x + (0.063 * x * x + 0.088 * std::pow(x, 10)) / (n * n));
  }
  if (made_of_mirrored_cubes(mesh)) return 1.0 / (1.0 + (2.6 + 0.84 * std::pow(x, 8)) / (n * n));
  const double mu = 0.5 / (1.0 + nu), lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));  // of E = 1
  // Near nu = 0.5 the stiffness against bending no longer grows with lambda: what deforms then is the section.
  const double bulk = std::hypot(std::pow(n, 1.66) / (2.1 * std::pow(lambda, 0.87)), std::pow(n, 0.2) / 65.0);
  return 1.0 / (1.0 + 6.2 * mu / (n * n) + 1.0 / bulk);
}

}  // namespace deformable_sim
