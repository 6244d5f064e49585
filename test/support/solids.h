// Laws, meshes and states of volumes for tests.
#pragma once

#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "deformable_sim/core/energy/solid_terms.h"

namespace deformable_sim::test {

constexpr std::array<SolidLaw, 6> kSolidLaws = {
    SolidLaw::kHooke,      SolidLaw::kCorotational,     SolidLaw::kStVenantKirchhoff,
    SolidLaw::kNeoHookean, SolidLaw::kStableNeoHookean, SolidLaw::kMooneyRivlin};

inline std::string name_of(SolidLaw law) {
  return solid_law_names()[static_cast<size_t>(law)];
}

/// What tables call the laws.
inline std::string table_name(SolidLaw law) {
  constexpr std::array<const char*, 6> kNames = {
      "linear_Hooke", "corotational", "StVK", "NeoHookean_log", "StableNeoHookean_Smith2018", "MooneyRivlin_C10eqC01"};
  return kNames[static_cast<size_t>(law)];
}

/// make_box with all cubes cut alike, along the diagonal from low to high x, y, z: what tables were computed with.
inline TetMesh make_uniform_box(const Vec3& size, const std::array<int, 3>& cells) {
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  TetMesh mesh = make_box(size, cells);
  mesh.tets.clear();
  for (int cell = 0; cell < cells[0] * cells[1] * cells[2]; ++cell) {
    for (size_t p = 0; p < kOrders.size(); ++p) {
      std::array<int, 3> at = {cell % cells[0], cell / cells[0] % cells[1], cell / cells[0] / cells[1]};
      std::array<int, 4> tet{};
      for (size_t step = 0; step < 4; ++step) {
        if (step > 0) ++at[static_cast<size_t>(kOrders[p][step - 1])];
        tet[step] = at[0] + (cells[0] + 1) * (at[1] + (cells[1] + 1) * at[2]);
      }
      if (p >= 3) std::swap(tet[2], tet[3]);
      mesh.tets.push_back(tet);
    }
  }
  return mesh;
}

/// Is a node of a box on its surface?
inline bool on_surface(const Vec3& size, const Vec3& x) {
  return ((x.cwiseAbs() - 0.5 * size).array().abs() < 1e-9 * size.maxCoeff()).any();
}

/// A box whose inner nodes are moved by up to a fifth of a cell.
inline TetMesh make_irregular_box(const Vec3& size, const std::array<int, 3>& cells, unsigned seed) {
  TetMesh mesh = make_box(size, cells);
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    if (on_surface(size, mesh.rest.col(i))) continue;
    for (int axis = 0; axis < 3; ++axis) {
      mesh.rest(axis, i) += uniform(generator) * size[axis] / cells[static_cast<size_t>(axis)];
    }
  }
  return mesh;
}

inline Mat3 random_matrix(std::mt19937* generator) {
  std::normal_distribution<double> normal;
  return Mat3::NullaryExpr([&] { return normal(*generator); });
}

inline Mat3 random_rotation(std::mt19937* generator) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond q(normal(*generator), normal(*generator), normal(*generator), normal(*generator));
  return q.normalized().toRotationMatrix();
}

/// R diag(s) Q with random rotations R, Q.
inline Mat3 with_stretches(const Vec3& s, std::mt19937* generator) {
  const Mat3 left = random_rotation(generator);
  return left * s.asDiagonal() * random_rotation(generator);
}

}  // namespace deformable_sim::test
