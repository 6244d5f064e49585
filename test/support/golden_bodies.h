// The bodies whose trajectories an independent program has computed; test/verify/data/README.md says what they are.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "support/system.h"
#include "support/table.h"

namespace deformable_sim::test {

/// Ten masses along +x, node 0 held.
inline std::unique_ptr<System> golden_chain(double stiffness, double damping) {
  Nodes x = Nodes::Zero(3, 10);
  std::vector<SpringLink> links;
  for (int i = 0; i < 10; ++i) {
    x(0, i) = 0.1 * i;
    if (i > 0) links.push_back({i - 1, i, 0.1, stiffness, damping});
  }
  auto chain = std::make_unique<System>(x, Eigen::VectorXd::Constant(10, 0.01));
  chain->add(make_springs("springs", links, 0)).add_gravity().hold(0);
  return chain;
}

/// A closed loop of 16 masses, stretched by a tenth, spinning and buckling out of its plane.
inline std::unique_ptr<System> golden_ring() {
  const int n = 16;
  const double radius = 0.3;
  Nodes x(3, n), v(3, n);
  std::vector<SpringLink> links;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * M_PI * i / n;
    x.col(i) = 1.1 * radius * Vec3(std::cos(angle), std::sin(angle), 0.0);
    v.col(i) = 5.0 * Vec3(-x(1, i), x(0, i), 0.0) + Vec3(0, 0, 0.2 * std::cos(2.0 * angle));
    links.push_back({i, (i + 1) % n, 2.0 * radius * std::sin(M_PI / n), 500.0, 0.0});
  }
  auto ring = std::make_unique<System>(x, Eigen::VectorXd::Constant(n, 0.01));
  ring->state.v = v;
  ring->add(make_springs("springs", links, 0));
  return ring;
}

/// Provot's sheet of 6 x 6 masses: structural, shear and flexion springs; corners (0, 0) and (0, 5) held.
inline std::unique_ptr<System> golden_provot_sheet() {
  const int n = 6;
  const double a = 0.05;
  Nodes x(3, n * n);
  std::vector<SpringLink> links;
  const auto link = [&](int i, int j, int di, int dj, double stiffness) {
    if (i + di >= n || j + dj < 0 || j + dj >= n) return;
    links.push_back({i * n + j, (i + di) * n + j + dj, a * std::hypot(di, dj), stiffness, 0.0});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      x.col(i * n + j) = Vec3(a * i, a * j, 0.002 * std::sin(3.0 * i + 2.0 * j));
      for (const auto& [di, dj] : {std::array<int, 2>{1, 0}, {0, 1}}) {
        link(i, j, di, dj, 100.0);
        link(i, j, 2 * di, 2 * dj, 10.0);
      }
      link(i, j, 1, 1, 50.0);
      link(i, j, 1, -1, 50.0);
    }
  }
  auto sheet = std::make_unique<System>(x, Eigen::VectorXd::Constant(n * n, 0.001));
  sheet->add(make_springs("springs", links, 0)).add_gravity().hold(0).hold(n - 1);
  return sheet;
}

/// A cube of 3 x 3 x 3 masses with all 26 neighbours, twisted and let go; the face i = 0 is held.
inline std::unique_ptr<System> golden_lattice() {
  const int n = 3;
  const double a = 0.1, stiffness[] = {0.0, 500.0, 250.0, 125.0};
  Nodes x(3, n * n * n);
  std::vector<SpringLink> links;
  const auto index = [](int i, int j, int k) { return (i * n + j) * n + k; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        const double angle = 0.3 * i / (n - 1.0), y = a * j - a, z = a * k - a;
        x.col(index(i, j, k)) =
            Vec3(a * i, a + std::cos(angle) * y - std::sin(angle) * z, a + std::sin(angle) * y + std::cos(angle) * z);
        for (int to = index(i, j, k) + 1; to < n * n * n; ++to) {
          const int di = to / (n * n) - i, dj = to / n % n - j, dk = to % n - k;
          if (std::abs(di) > 1 || std::abs(dj) > 1 || std::abs(dk) > 1) continue;
          const int steps = di * di + dj * dj + dk * dk;
          links.push_back({index(i, j, k), to, a * std::sqrt(steps), stiffness[steps], 0.0});
        }
      }
    }
  }
  auto lattice = std::make_unique<System>(x, Eigen::VectorXd::Constant(n * n * n, 0.01));
  lattice->add(make_springs("springs", links, 0)).add_gravity();
  for (int node = 0; node < n * n; ++node) lattice->hold(node);
  return lattice;
}

inline std::unique_ptr<System> golden_body(const std::string& name) {
  if (name == "chain10_soft") return golden_chain(1e3, 0.0);
  if (name == "chain10_soft_damped") return golden_chain(1e3, 0.05);
  if (name == "chain10_stiff") return golden_chain(1e5, 0.0);
  if (name == "ring16") return golden_ring();
  if (name == "provot6") return golden_provot_sheet();
  return golden_lattice();
}

/// A tabulated instant.
struct Instant {
  double time;  // s
  Nodes x, v;
};

/// The table golden_NAME.csv.
inline std::vector<Instant> golden_instants(const std::string& name, Eigen::Index nodes) {
  std::vector<Instant> instants;
  for (const TableRow& row : read_rows("golden_" + name + ".csv")) {
    if (instants.empty() || row("t") != instants.back().time)
      instants.push_back({row("t"), Nodes::Zero(3, nodes), Nodes::Zero(3, nodes)});
    const auto node = static_cast<Eigen::Index>(row("node"));
    instants.back().x.col(node) = Vec3(row("x"), row("y"), row("z"));
    instants.back().v.col(node) = Vec3(row("vx"), row("vy"), row("vz"));
  }
  return instants;
}

/// Root mean square over the nodes of their distance.
inline double rms(const Nodes& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<double>(difference.cols()));
}

}  // namespace deformable_sim::test
