// Provot's sheet: three sets of four neighbours.
#include <array>
#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

// One of each pair of opposite neighbours, {columns, rows}.
constexpr std::array<std::array<int, 2>, 2> kStructural{{{1, 0}, {0, 1}}};
constexpr std::array<std::array<int, 2>, 2> kShear{{{1, 1}, {-1, 1}}};
constexpr std::array<std::array<int, 2>, 2> kFlexion{{{2, 0}, {0, 2}}};

void check(const ProvotStiffness& s) {
  const auto refuse_unless = [](bool good, const std::string& what, double value, const std::string& allowed) {
    if (!good || !std::isfinite(value))
      throw InputError(what + " is " + std::to_string(value) + "; it must be " + allowed);
  };
  refuse_unless(s.structural > 0.0, "structural", s.structural, "finite and > 0 (N/m)");
  refuse_unless(s.shear >= 0.0, "shear", s.shear, "finite and >= 0 (N/m)");
  refuse_unless(s.flexion >= 0.0, "flexion", s.flexion, "finite and >= 0 (N/m)");
  refuse_unless(s.damping_time >= 0.0, "damping_time", s.damping_time, "finite and >= 0 (s)");
}

}  // namespace

SpringNetwork provot_network(const TriangleMesh& grid, const ProvotStiffness& stiffness) {
  if (!grid.is_grid()) throw InputError("a Provot sheet is a grid; other meshes take sheet_network's springs");
  check(stiffness);
  const auto add = [&](const std::array<std::array<int, 2>, 2>& neighbours, double k, std::vector<SpringLink>* links) {
    if (k == 0.0) return;
    for (int row = 0; row < grid.rows; ++row) {
      for (int col = 0; col < grid.cols; ++col) {
        for (const auto& [right, up] : neighbours) {
          const int c = col + right, r = row + up;
          if (c < 0 || c >= grid.cols || r >= grid.rows) continue;
          const bool along_edge =
              up == 0 ? (row == 0 || row == grid.rows - 1) : right == 0 && (col == 0 || col == grid.cols - 1);
          const double own = along_edge && stiffness.edge == SheetEdge::kHalved ? 0.5 * k : k;
          const int a = row * grid.cols + col, b = r * grid.cols + c;
          links->push_back({a, b, (grid.rest.col(b) - grid.rest.col(a)).norm(), own, stiffness.damping_time * own});
        }
      }
    }
  };
  SpringNetwork network;
  add(kStructural, stiffness.structural, &network.stretch);
  add(kShear, stiffness.shear, &network.shear);
  add(kFlexion, stiffness.flexion, &network.bend);
  return network;
}

}  // namespace deformable_sim
