// Small vibrations of rods: beams, rings, torsion bars; and that nothing vibrates in free fall.
#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Eigenvalues>

#include "support/rods.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// Natural frequencies (rad/s), ascending, of a System about its present state over the coordinates `free` (3 node +
/// axis): K q = omega^2 M q.
std::vector<double> frequencies(System* system, const std::vector<int>& free) {
  system->build_pattern();
  system->pattern.set_zero();
  for (const Energy* term : system->dynamics.energies)
    term->add_jacobian(system->state, 1.0, 0.0, Jacobian::kExact, &system->pattern);
  const Eigen::MatrixXd all = Eigen::MatrixXd(system->pattern.to_sparse());
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const int a = free[static_cast<size_t>(i)], b = free[static_cast<size_t>(j)];
      k(i, j) = all(a, b) / std::sqrt(system->mass[a / 3] * system->mass[b / 3]);
    }
  }
  const Eigen::VectorXd squares =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly).eigenvalues();
  std::vector<double> omega;
  for (const double square : squares) omega.push_back(std::sqrt(std::max(0.0, square)));
  return omega;
}

enum class Ends { kClampedFree, kClampedClamped, kPinnedPinned };

/// Transverse frequencies of a unit beam of `segments` segments in the plane of x and z; omega L^2 sqrt(mu/B).
std::vector<double> beam_frequencies(Ends ends, int segments) {
  const int clamps = ends == Ends::kClampedClamped ? 2 : ends == Ends::kClampedFree ? 1 : 0;
  RodSystem rod(line_along(Vec3::UnitX(), 1.0 / (segments - 0.5 * clamps), segments + 1), unit_section());
  const int first = ends == Ends::kPinnedPinned ? 1 : 2;
  const int last = ends == Ends::kClampedFree ? segments : ends == Ends::kPinnedPinned ? segments - 1 : segments - 2;
  std::vector<int> free;
  for (int i = first; i <= last; ++i) free.push_back(3 * i + 2);
  return frequencies(rod.system.get(), free);
}

TEST(RodModes, BeamsVibrateAtTheirFrequencies) {
  // omega L^2 sqrt(mu / B) of the table; second order in the segment length: observed order, and the limit to 1 %.
  const auto rows = read_rows("B10_beam_modes.csv");
  const std::tuple<Ends, std::string, std::string> cases[] = {
      {Ends::kClampedFree, "clamped_free omega L^2 sqrt(mu/B)", "clamped-free"},
      {Ends::kClampedClamped, "clamped_clamped (=free_free)", "clamped-clamped"},
      {Ends::kPinnedPinned, "pinned_pinned", "pinned-pinned"}};
  for (const auto& [ends, column, name] : cases) {
    const auto b = beam_frequencies(ends, 40), c = beam_frequencies(ends, 80);
    for (size_t k = 0; k < 3; ++k) {
      const double expected = rows[k](column);
      const std::string what = "rod, beam " + name + ", mode " + std::to_string(k + 1);
      const double limit = c[k] + (c[k] - b[k]) / 3.0;
      check("B10", what + ", limit", limit, expected, 0.01);
      const double order = std::log2(std::abs((b[k] - expected) / (c[k] - expected)));
      EXPECT_GT(order, 1.8) << what << ": " << b[k] << ' ' << c[k];
    }
  }
}

TEST(RodModes, AFreeRingVibratesInItsPlane) {
  // omega R^2 sqrt(mu/B) = n (n^2 - 1) / sqrt(n^2 + 1), each twice, after three rigid motions.
  const auto rows = read_rows("B10b_free_ring_inplane_modes.csv");
  const auto ring = [](int nodes) {
    const Polyline line = make_ring(2.0 * M_PI, nodes);
    RodSystem rod(line, unit_section(0.3, 1e6), rest_as_drawn(line, Vec3::UnitZ()));
    std::vector<int> free;
    for (int i = 0; i < nodes; ++i) free.insert(free.end(), {3 * i, 3 * i + 1});
    return frequencies(rod.system.get(), free);
  };
  const auto coarse = ring(40), fine = ring(80);
  for (size_t i = 0; i < 3; ++i) EXPECT_LT(fine[i], 1e-2);
  for (size_t k = 0; k < 3; ++k) {
    const size_t i = 3 + 2 * k;
    const double expected = rows[k]("omega R^2 sqrt(mu/B) (inextensional, in plane)");
    EXPECT_NEAR(fine[i], fine[i + 1], 1e-6 * expected);
    check("B10", "rod, free ring in plane, n = " + rows[k].text("n") + ", limit", fine[i] + (fine[i] - coarse[i]) / 3.0,
          expected, 0.01);
  }
}

TEST(RodModes, ATorsionBarSwingsItsDisc) {
  // omega = sqrt(C / (I L)) with a disc of inertia I at the end of a light rod, L between the middles of the end
  // segments; without a disc (pi / 2) sqrt(C / i) / L for inertia i per length.
  const int segments = 40;
  RodSystem rod(line_along(Vec3::UnitX(), 1.0 / (segments - 1), segments + 1), unit_section(0.25));
  std::vector<int> free;
  for (int j = 1; j < segments; ++j) free.push_back(3 * (rod.points + j));
  const double per_length = rod.section.linear_density * std::pow(rod.section.radius_of_gyration, 2),
               c = rod.section.twist;
  // The far end of the bar is half a segment beyond the middle of the last one.
  const double length = 1.0 + 0.5 / (segments - 1);
  check("B12", "rod, free torsion frequency, rad/s", frequencies(rod.system.get(), free).front(),
        0.5 * M_PI / length * std::sqrt(c / per_length), 0.01);
  const double inertia = 1e4 * per_length;
  rod.system->mass[rod.points + segments - 1] = inertia / std::pow(rod.section.radius_of_gyration, 2);
  // The rod's own inertia adds a third of itself: 1/3e4.
  check("B12", "rod, torsion bar with a disc, rad/s", frequencies(rod.system.get(), free).front(),
        std::sqrt(c / inertia), 1e-4);
}

}  // namespace
}  // namespace deformable_sim::test
