// Small voxel solids for tests, and their distance by looking at every cell.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "deformable_sim/core/contact/voxel_solid.h"

namespace deformable_sim::test {

constexpr int kBlock = 16;  // cells along each edge of the block that a grid fills
constexpr double kCell = 0.02;

/// A block of cells that begins at cell (-8, -8, -8) of the frame.
struct VoxelGrid {
  using Filled = std::function<bool(int x, int y, int z)>;
  explicit VoxelGrid(const Filled& filled) : cells(kBlock * kBlock * kBlock) {
    for (int z = 0; z < kBlock; ++z)
      for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) cells[index(x, y, z)] = filled(x, y, z) ? 1 : 0;
  }

  static size_t index(int x, int y, int z) { return static_cast<size_t>((z * kBlock + y) * kBlock + x); }
  bool at(int x, int y, int z) const {
    const auto out = [](int k) { return k < 0 || k >= kBlock; };
    return !out(x) && !out(y) && !out(z) && cells[index(x, y, z)] != 0;
  }

  bool holds(const Vec3& p) const {
    const Eigen::Array3i cell = (p.array() / kCell).floor().cast<int>() + kBlock / 2;
    return at(cell.x(), cell.y(), cell.z());
  }

  /// As an octree would keep them: whole blocks of 8 as one cube.
  std::vector<VoxelCube> cubes() const {
    std::vector<VoxelCube> found;
    add_cubes(0, 0, 0, 3, &found);
    add_cubes(8, 0, 0, 3, &found);
    add_cubes(0, 8, 0, 3, &found);
    add_cubes(8, 8, 0, 3, &found);
    add_cubes(0, 0, 8, 3, &found);
    add_cubes(8, 0, 8, 3, &found);
    add_cubes(0, 8, 8, 3, &found);
    add_cubes(8, 8, 8, 3, &found);
    return found;
  }

  /// Signed: to the nearest occupied cell from outside, to the nearest free one from inside; a margin of free cells
  /// lies around the block.
  double distance(const Vec3& p) const {
    double occupied = std::numeric_limits<double>::infinity(), free = occupied;
    for (int z = -1; z <= kBlock; ++z)
      for (int y = -1; y <= kBlock; ++y)
        for (int x = -1; x <= kBlock; ++x) {
          const Vec3 low = kCell * (Vec3(x, y, z) - Vec3::Constant(kBlock / 2));
          const double away = Eigen::AlignedBox3d(low, Vec3(low + Vec3::Constant(kCell))).exteriorDistance(p);
          double& nearest = at(x, y, z) ? occupied : free;
          nearest = std::min(nearest, away);
        }
    return occupied > 0.0 ? occupied : -free;
  }

  std::vector<char> cells;

 private:
  void add_cubes(int x, int y, int z, int level, std::vector<VoxelCube>* found) const {
    const int size = 1 << level;
    int count = 0;
    for (int k = 0; k < size * size * size; ++k)
      count += at(x + k % size, y + k / size % size, z + k / size / size) ? 1 : 0;
    if (count == 0) return;
    if (count == size * size * size) {
      const auto key = [](int c) { return static_cast<std::uint16_t>(kVoxelOrigin - kBlock / 2 + c); };
      found->push_back({{{key(x), key(y), key(z)}}, level});
      return;
    }
    for (int child = 0; child < 8; ++child)
      add_cubes(x + (child & 1) * size / 2, y + (child >> 1 & 1) * size / 2, z + (child >> 2) * size / 2, level - 1,
                found);
  }
};

}  // namespace deformable_sim::test
