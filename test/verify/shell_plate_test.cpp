// The bending of sheets as that of a plate: stiffness by direction and mesh, frequencies, deflections.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Cholesky>

#include "deformable_sim/core/element/hinge.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/material/plate_patches.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// Warp 3 N m, weft 1 N m, turned by `angle` (rad) from x.
BendingMaterial woven(double angle) {
  BendingMaterial material;
  material.warp = 3.0;
  material.weft = 1.0;
  material.poissons_ratio = 0.4;
  material.twist = 0.5;
  material.warp_direction = Vec3(std::cos(angle), std::sin(angle), 0.0);
  return material;
}

std::vector<std::pair<std::string, TriangleMesh>> meshes() {
  const double degree = M_PI / 180.0;
  return {{"uniform diagonals", uniform_grid(1.0, 1.0, 8, 8)},
          {"alternating diagonals", make_grid(1.0, 1.0, 8, 8)},
          {"equilateral", equilateral_mesh(0.125, 8, 8)},
          {"cells 3 : 1, alternating", make_grid(1.0, 1.0, 4, 12)},
          {"cells 3 : 1, uniform", uniform_grid(1.0, 1.0, 4, 12)},
          {"lattice at 30 degrees", cut_strip(1.0, 1.0, 0.125, 30.0 * degree, Diagonals::kAlternating)},
          {"irregular", irregular_mesh(1.0, 1.0, 8, 8, 0.35)}};
}

/// z = x^T K x / 2 over the mesh, K = (k_xx, k_yy, 2 k_xy), of a slope so small that angles are slopes.
// (Quadratic bending knows z only: any slope will do, a larger one for less round-off.)
constexpr double kSmall = 1e-5;
Nodes bent(const TriangleMesh& mesh, const Vec3& k, double small = kSmall) {
  Nodes x = mesh.rest;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    x(2, i) = 0.5 * small * (k[0] * x(0, i) * x(0, i) + k[1] * x(1, i) * x(1, i) + k[2] * x(0, i) * x(1, i));
  }
  return x;
}

TEST(PlateCurvature, IsExactForEveryQuadraticSurfaceOnEveryMesh) {
  // kappa = curvature . angles = K in every triangle that has no free edge; small angles: relative error of 1e-9.
  for (const auto& [name, mesh] : meshes()) {
    const PlateMesh plate = plate_mesh(mesh, plate_stiffness(isotropic_bending(1.0, 0.3)), Vec3::UnitX());
    ASSERT_EQ(plate.patches.size(), mesh.triangles.size());
    std::set<std::array<int, 2>> shared;
    for (const auto& h : plate.hinges) shared.insert({std::min(h[0], h[1]), std::max(h[0], h[1])});
    double off = 0.0;
    int inner = 0;
    for (const Vec3& k : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      const Nodes x = bent(mesh, k);
      for (size_t f = 0; f < plate.patches.size(); ++f) {
        const auto& t = mesh.triangles[f];
        bool free_edge = false;
        for (size_t e = 0; e < 3; ++e) {
          const int a = t[e], b = t[(e + 1) % 3];
          free_edge = free_edge || shared.count({std::min(a, b), std::max(a, b)}) == 0;
        }
        if (free_edge) continue;
        ++inner;
        Vec3 kappa = Vec3::Zero();
        const PlatePatch& patch = plate.patches[f];
        for (int h = 0; h < patch.count; ++h) {
          const auto& hinge = plate.hinges[static_cast<size_t>(patch.hinge[static_cast<size_t>(h)])];
          Hinge::Points points;
          for (size_t p = 0; p < 4; ++p) points.col(static_cast<Eigen::Index>(p)) = x.col(hinge[p]);
          kappa += Hinge(points).angle() * patch.curvature.col(h);
        }
        off = std::max(off, (kappa / kSmall - k).norm());
      }
    }
    EXPECT_GT(inner, 100);
    check("C4", "curvature of quadratic surfaces, " + name + ", largest error", off, 0.0, 1e-8, Tolerance::kAbsolute);
  }
}

TEST(PlateMoments, AreInEquilibriumWhenConstantOnEveryMesh) {
  // Constant curvature is constant moment: no force on nodes inside. (Hinges weighted one by one fail this.)
  for (const auto& [name, mesh] : meshes()) {
    int moment = 1;
    for (const Vec3& k : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      System system(bent(mesh, k), Eigen::VectorXd::Ones(mesh.rest.cols()));
      system.add(make_bending(mesh, woven(0.3), 0));
      const Nodes f = system.forces() / kSmall;
      double inside = 0.0, border = 0.0;
      for (int i = 0; i < f.cols(); ++i) {
        double& largest = distance_to_border(mesh, i) > 0.36 ? inside : border;
        largest = std::max(largest, std::abs(f(2, i)));
      }
      check("C4", "force inside under constant moment " + std::to_string(moment++) + ", " + name + ", N",
            inside / border, 0.0, 1e-8, Tolerance::kAbsolute);
    }
  }
}

/// Energy per area over kappa^2 / 2 of a cylinder bent along `t` (rad), away from the edges: over patches of n x n
/// cells the energy is a n^2 + b n + c, and the second difference leaves a.
template <class MakeMesh, class MakeBending>
double rigidity(const MakeMesh& make_mesh, const MakeBending& make_bending_of, double t, double small = kSmall) {
  const double c = std::cos(t), s = std::sin(t);
  double second = 0.0, area = 0.0;
  const double weight[] = {1.0, -2.0, 1.0};
  for (int k = 0; k < 3; ++k) {
    const TriangleMesh mesh = make_mesh(8 + 2 * k);
    System system(bent(mesh, Vec3(c * c, s * s, 2.0 * c * s), small), Eigen::VectorXd::Ones(mesh.rest.cols()));
    system.add(make_bending_of(mesh));
    second += weight[k] * system.potential_energy();
    area += weight[k] * face_areas(mesh).sum();
  }
  return 2.0 * second / (area * small * small);
}

TEST(PlateStiffness, IsTheMaterialsInEveryDirectionOnEveryLattice) {
  // D(t) = D11 c^4 + D22 s^4 + (2 D12 + 4 D33) c^2 s^2; isotropic: D = B / (1 - nu^2) whatever t.
  const std::vector<std::pair<std::string, std::function<TriangleMesh(int)>>> lattices = {
      {"uniform diagonals", [](int n) { return uniform_grid(n * 0.1, n * 0.1, n, n); }},
      {"alternating diagonals", [](int n) { return make_grid(n * 0.1, n * 0.1, n, n); }},
      {"equilateral", [](int n) { return equilateral_mesh(0.1, n, n); }}};
  for (const auto& [name, lattice] : lattices) {
    for (const int degrees : {0, 45, -45, 90, 30}) {
      const double t = degrees * M_PI / 180.0, c = std::cos(t), s = std::sin(t);
      const std::string what = name + ", " + std::to_string(degrees) + " degrees, N m";
      const auto isotropic = [](const TriangleMesh& mesh) {
        return make_bending(mesh, isotropic_bending(2.0, 0.3), 0);
      };
      const auto quadratic = [](const TriangleMesh& mesh) {
        return make_quadratic_bending(mesh, isotropic_bending(2.0, 0.3), 0);
      };
      const auto orthotropic = [](const TriangleMesh& mesh) { return make_bending(mesh, woven(0.0), 0); };
      check("C4", "plate stiffness, " + what, rigidity(lattice, isotropic, t), 2.0 / 0.91, 1e-7);
      check("C4", "plate stiffness, quadratic, " + what, rigidity(lattice, quadratic, t, 1.0), 2.0 / 0.91, 1e-7);
      const Mat3 d = plate_stiffness(woven(0.0));
      check("C4", "plate stiffness, orthotropic, " + what, rigidity(lattice, orthotropic, t),
            d(0, 0) * std::pow(c, 4) + d(1, 1) * std::pow(s, 4) + (2.0 * d(0, 1) + 4.0 * d(2, 2)) * c * c * s * s,
            1e-7);
    }
  }
}

TEST(PlateStiffness, OfAFreeStripIsThatOfABeam) {
  // A strip bent to k_xx = k, k_yy = -nu k has M_yy = 0: energy per length B w k^2 / 2, edges included, at any width.
  const double nu = 0.3;
  for (const int across : {1, 2, 5}) {
    for (const Diagonals diagonals : {Diagonals::kUniform, Diagonals::kAlternating}) {
      double energy[2];
      for (int k = 0; k < 2; ++k) {
        const int along = 20 + 10 * k;
        const TriangleMesh mesh = grid(diagonals, 0.1 * along, 0.1 * across, along, across);
        System system(bent(mesh, Vec3(1.0, -nu, 0.0)), Eigen::VectorXd::Ones(mesh.rest.cols()));
        system.add(make_bending(mesh, isotropic_bending(2.0, nu), 0));
        energy[k] = system.potential_energy();
      }
      check("C4",
            "strip of " + std::to_string(across) + " cells, " +
                (diagonals == Diagonals::kUniform ? "uniform" : "alternating") + " diagonals, B, N m",
            2.0 * (energy[1] - energy[0]) / (kSmall * kSmall * 1.0 * 0.1 * across), 2.0, 1e-7);
    }
  }
}

/// Side 1 m, n cells, D = 1 N m, nu = 0.3, 1 kg/m^2, on `kind` of mesh.
TriangleMesh square(const std::string& kind, int n) {
  if (kind == "uniform") return uniform_grid(1.0, 1.0, n, n);
  if (kind == "irregular") return irregular_mesh(1.0, 1.0, n, n, 0.3);
  return make_grid(1.0, 1.0, n, n);
}

struct Plate {
  Plate(const TriangleMesh& rest, const std::string& element)
      : mesh(rest), system(rest.rest, triangle_masses(rest, 1.0)) {
    const BendingMaterial material = isotropic_bending(0.91, 0.3);
    system.add(element == "hinges" ? make_bending(mesh, material, 0) : make_quadratic_bending(mesh, material, 0));
  }
  TriangleMesh mesh;
  System system;
};

/// Numbers of cells: coarse in a fast run.
int cells() {
  return verify_all() ? 32 : 20;
}

TEST(SquarePlate, VibratesAtItsFrequencies) {
  // omega a^2 sqrt(rho / D). Held nodes on the border: simply supported, for free edges bear no moment. Two held rings:
  // clamped half way between them. Free: three rigid motions first.
  for (const std::string kind : {"uniform", "alternating", "irregular"}) {
    const int n = cells();
    Plate plate(square(kind, n), "hinges");
    const double ring = 1.0 / n + 1e-9, clamped_side = 1.0 - 1.0 / n;
    const auto at = [&](const Eigen::VectorXd& omega, int k, double side) { return omega[k] * side * side; };

    const Eigen::VectorXd supported =
        normal_frequencies(&plate.system, [&](int i) { return on_border(plate.mesh, i); });
    check("C3", "SSSS 1, " + kind, at(supported, 0, 1.0), 19.7392088, 0.02);
    check("C3", "SSSS 2, " + kind, at(supported, 1, 1.0), 49.34802201, 0.02);
    check("C3", "SSSS 3, " + kind, at(supported, 2, 1.0), 49.34802201, 0.02);

    const Eigen::VectorXd free = normal_frequencies(&plate.system, [](int) { return false; });
    EXPECT_LT(free[2], 1e-2);
    check("C3", "FFFF 1, " + kind, at(free, 3, 1.0), 13.46819942, 0.02);
    check("C3", "FFFF 2, " + kind, at(free, 4, 1.0), 19.59613737, 0.02);
    check("C3", "FFFF 3, " + kind, at(free, 5, 1.0), 24.27020117, 0.02);
    if (kind == "irregular") continue;  // its rings are not straight

    const Eigen::VectorXd clamped =
        normal_frequencies(&plate.system, [&](int i) { return distance_to_border(plate.mesh, i) < ring; });
    check("C3", "CCCC 1, " + kind, at(clamped, 0, clamped_side), 35.98519113, 0.02);
    check("C3", "CCCC 2, " + kind, at(clamped, 1, clamped_side), 73.39384612, 0.02);
  }
}

TEST(SquarePlate, VibratesAsACantilever) {
  // n x n cells beyond a clamp half way along one more column.
  for (const Diagonals diagonals : {Diagonals::kUniform, Diagonals::kAlternating}) {
    const std::string kind = diagonals == Diagonals::kUniform ? "uniform" : "alternating";
    const int n = cells();
    const double h = 1.0 / (n - 0.5);
    Plate plate(grid(diagonals, n * h, 1.0, n, n), "hinges");
    const double clamp = plate.mesh.rest.row(0).minCoeff() + h + 1e-9;
    const Eigen::VectorXd omega =
        normal_frequencies(&plate.system, [&](int i) { return plate.mesh.rest(0, i) < clamp; });
    check("C3", "cantilever 1, " + kind, omega[0], 3.471095391, 0.02);
    check("C3", "cantilever 2, " + kind, omega[1], 8.506883498, 0.02);
    check("C3", "cantilever 3, " + kind, omega[2], 21.28530196, 0.02);
  }
}

double center_deflection(Plate* plate, const std::function<bool(int)>& held, const std::function<double(int)>& load) {
  std::vector<int> free;
  const Eigen::MatrixXd k = stiffness_across(&plate->system, held, &free);
  Eigen::VectorXd f(k.rows());
  Eigen::Index center = 0;
  for (Eigen::Index i = 0; i < f.size(); ++i) {
    const int node = free[static_cast<size_t>(i)];
    f[i] = load(node);
    if (plate->mesh.rest.col(node).norm() < 1e-9) center = i;
  }
  return k.ldlt().solve(f)[center];
}

TEST(SquarePlate, SagsAsTimoshenkoSays) {
  // w = 0.00406235 q a^4 / D and 0.0116008 P a^2 / D (supported), 0.00126532 q a^4 / D (clamped).
  for (const std::string kind : {"uniform", "alternating"}) {
    for (const std::string element : {"hinges", "quadratic"}) {
      const int n = 28;  // the point load is the hardest: 1.5 % here, falling with the square of the cells
      Plate plate(square(kind, n), element);
      const std::string what = kind + ", " + element;
      const auto uniform = [&](int i) { return plate.system.mass[i]; };
      const auto border = [&](int i) { return on_border(plate.mesh, i); };
      const auto two_rings = [&](int i) { return distance_to_border(plate.mesh, i) < 1.0 / n + 1e-9; };
      const auto point = [&](int i) { return plate.mesh.rest.col(i).norm() < 1e-9 ? 1.0 : 0.0; };
      check("C3", "SSSS uniform, " + what, center_deflection(&plate, border, uniform), 0.004062352661, 0.02);
      check("C3", "SSSS point, " + what, center_deflection(&plate, border, point), 0.01160083519, 0.02);
      check("C3", "CCCC uniform, " + what, center_deflection(&plate, two_rings, uniform) / std::pow(1.0 - 1.0 / n, 4),
            0.001265319028, 0.02);
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
