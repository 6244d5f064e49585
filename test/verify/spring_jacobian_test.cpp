// What the truncated Jacobian k n n^T, often published for cloth, costs and misses beside the exact one.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "deformable_sim/core/element/spring.h"
#include "support/linear_response.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// A sheet held at two corners, sagging and moving: the state in the middle of a fall, as a step begins.
std::unique_ptr<System> falling_sheet() {
  const TriangleMesh mesh = make_grid(0.3, 0.3, 6, 6);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  auto sheet = std::make_unique<System>(mesh.rest, sheet_masses(mesh, 0.2));
  sheet->add_springs(sheet_network(mesh, stiffness)).add_gravity().hold(0).hold(6);
  const auto integrator = make_integrator("implicit_euler", exact_settings(1e-8));
  for (int k = 0; k < 12; ++k) sheet->step(*integrator, 0.01);
  return sheet;
}

struct Newton {
  std::vector<double> error;  // m, RMS distance from the solution after each iteration
  int iterations = 0;         // to a residual of 1e-6 m/s^2, at most 200
};

/// One implicit Euler step of dt by undamped Newton iterations, whose matrix has springs of the given kind.
Newton newton_on_step(System* body, double dt, Jacobian kind, const Nodes& solution) {
  const State start = body->state;
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(body->mass.size()); ++i)
    if (i != 0 && i != 6)
      for (int axis = 0; axis < 3; ++axis) free.push_back(3 * i + axis);
  Newton found;
  for (; found.iterations < 200; ++found.iterations) {
    body->state.v = (body->state.x - start.x) / dt;
    Nodes r = body->forces() - (body->state.v - start.v) * (body->mass / dt).asDiagonal();
    Eigen::VectorXd b(free.size());
    double unbalanced = 0.0;
    for (size_t i = 0; i < free.size(); ++i) {
      b[static_cast<Eigen::Index>(i)] = r.data()[free[i]];
      unbalanced = std::max(unbalanced, std::abs(r.data()[free[i]]) / body->mass[free[i] / 3]);
    }
    if (unbalanced < 1e-6) break;
    body->pattern.set_zero();
    for (const Energy* term : body->dynamics.energies)
      term->add_jacobian(body->state, 1.0, 1.0 / dt, kind, &body->pattern);
    Eigen::MatrixXd a = part_of(Eigen::MatrixXd(body->pattern.to_sparse()), free, free);
    for (size_t i = 0; i < free.size(); ++i)
      a(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += body->mass[free[i] / 3] / (dt * dt);
    const Eigen::VectorXd dx = a.ldlt().solve(b);
    for (size_t i = 0; i < free.size(); ++i) body->state.x.data()[free[i]] += dx[static_cast<Eigen::Index>(i)];
    if (solution.cols() > 0)
      found.error.push_back((body->state.x - solution).norm() / std::sqrt(static_cast<double>(solution.cols())));
  }
  return found;
}

TEST(AxialJacobian, LosesTheTransverseStiffnessOfTension) {
  // Its error is exactly k (1 - L/r)(I - n n^T): of the norm sqrt(2) k |1 - L/r|.
  const Vec3 d(0.3, -0.2, 0.5), n = d.normalized();
  for (const double stretch : {0.7, 1.05, 1.5}) {
    const Spring::Rest rest{d.norm() / stretch, 80.0, 0.0};
    const Mat3 exact = Spring::stiffness(d, Vec3::Zero(), rest, 1.0, 0.0, Jacobian::kExact);
    const Mat3 axial = Spring::stiffness(d, Vec3::Zero(), rest, 1.0, 0.0, Jacobian::kAxial);
    EXPECT_LT((axial - 80.0 * n * n.transpose()).norm(), 1e-12);
    check("0.3", "error of k n n^T at a stretch of " + std::to_string(stretch) + ", N/m", (exact - axial).norm(),
          std::sqrt(2.0) * 80.0 * std::abs(1.0 - 1.0 / stretch), 1e-12);
  }
}

TEST(AxialJacobian, TakesMoreIterationsToTheSameStep) {
  // Every kind leads to the same end of the step; the cost of an iteration is the same. Newton's method with the exact
  // matrix converges quadratically, with the truncated one linearly.
  const double dt = 0.01;
  const auto run = [&](Jacobian kind, const Nodes& solution) {
    auto sheet = falling_sheet();
    Newton found = newton_on_step(sheet.get(), dt, kind, solution);
    return std::make_pair(found, Nodes(sheet->state.x));
  };
  const Nodes solution = run(Jacobian::kProjected, Nodes()).second;
  std::map<std::string, Newton> found;
  for (const auto& [name, kind] : std::map<std::string, Jacobian>{
           {"exact", Jacobian::kExact}, {"projected", Jacobian::kProjected}, {"axial", Jacobian::kAxial}}) {
    const auto [newton, end] = run(kind, solution);
    found[name] = newton;
    check("0.3", name + " Jacobian, distance from the solution of the step, m", (end - solution).norm(), 0.0, 1e-8,
          Tolerance::kAbsolute);
  }
  // Iterations to a residual of 1e-6 m/s^2, and the error after two of them, on this sheet.
  check("0.3", "exact Jacobian, Newton iterations", found["exact"].iterations, 4, 1, Tolerance::kAbsolute);
  check("0.3", "projected Jacobian, Newton iterations", found["projected"].iterations, 9, 2, Tolerance::kAbsolute);
  check("0.3", "axial Jacobian, Newton iterations", found["axial"].iterations, 83, 15, Tolerance::kAbsolute);
  check("0.3", "exact Jacobian, error after two iterations, m", found["exact"].error.at(1), 3.7e-6, 0.2);
  check("0.3", "projected Jacobian, error after two iterations, m", found["projected"].error.at(1), 1.55e-5, 0.2);
  check("0.3", "axial Jacobian, error after two iterations, m", found["axial"].error.at(1), 1.94e-5, 0.2);
}

}  // namespace
}  // namespace deformable_sim::test
