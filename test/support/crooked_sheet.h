// A sheet whose mesh is no grid.
#pragma once

#include <random>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim::test {

/// side x side nodes on a unit square, those inside moved by up to a quarter of a cell; cells cut at random.
inline TriangleMesh crooked_sheet(int side) {
  std::mt19937 generator(static_cast<unsigned>(side));
  std::uniform_real_distribution<double> move(-0.25, 0.25);
  TriangleMesh mesh;
  mesh.rest.resize(3, side * side);
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side, col = i % side;
    const bool in_row = row > 0 && row + 1 < side, in_col = col > 0 && col + 1 < side;
    mesh.rest.col(i) =
        Vec3(col + (in_col ? move(generator) : 0.0), row + (in_row ? move(generator) : 0.0), 0.0) / (side - 1.0);
  }
  for (int row = 0; row + 1 < side; ++row) {
    for (int col = 0; col + 1 < side; ++col) {
      const int a = row * side + col, b = a + 1, c = a + side + 1, d = a + side;
      if (generator() % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  }
  return mesh;
}

}  // namespace deformable_sim::test
