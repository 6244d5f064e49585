// Volumes made of cubes: boxes, and lattices around a closed surface.
#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/tet_mesh.h"

namespace deformable_sim {
namespace {

using Index3 = std::array<int, 3>;

constexpr double kMostCells = 1e7;

/// A box of cells, some of them solid.
struct CellGrid {
  CellGrid(const Vec3& origin_, const Vec3& spacing_, const Index3& count_, char fill)
      : origin(origin_), spacing(spacing_), count(count_), solid(size(count_), fill) {}
  static size_t size(const Index3& n) {
    return static_cast<size_t>(n[0]) * static_cast<size_t>(n[1]) * static_cast<size_t>(n[2]);
  }
  size_t cell(int i, int j, int k) const { return static_cast<size_t>(i + count[0] * (j + count[1] * k)); }
  bool is_solid(int i, int j, int k) const {
    const bool inside = i >= 0 && j >= 0 && k >= 0 && i < count[0] && j < count[1] && k < count[2];
    return inside && solid[cell(i, j, k)] != 0;
  }
  Vec3 corner(int i, int j, int k) const { return origin + spacing.cwiseProduct(Vec3(i, j, k)); }

  Vec3 origin, spacing;
  Index3 count;
  std::vector<char> solid;
};

/// The six tetrahedra of a cube: one for each order of the axes, along the path from corner 0 to corner 7 that takes
/// them in this order. `mirror` has a bit for each axis along which the path runs backwards.
void cut_cube(const std::array<int, 8>& corner, int mirror, std::vector<std::array<int, 4>>* tets) {
  constexpr std::array<Index3, 6> kOrders = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  const int turns = (mirror & 1) + (mirror >> 1 & 1) + (mirror >> 2 & 1);
  for (size_t p = 0; p < kOrders.size(); ++p) {
    std::array<int, 4> tet{};
    int at = 0;
    for (size_t step = 0; step < 4; ++step) {
      if (step > 0) at |= 1 << kOrders[p][step - 1];
      tet[step] = corner[static_cast<size_t>(at ^ mirror)];
    }
    if ((p >= 3) != (turns % 2 == 1)) std::swap(tet[2], tet[3]);
    tets->push_back(tet);
  }
}

TetMesh mesh_of(const CellGrid& grid) {
  const Index3 n = {grid.count[0] + 1, grid.count[1] + 1, grid.count[2] + 1};
  std::vector<int> node(CellGrid::size(n), -1);
  const auto at = [&](int i, int j, int k) -> int& { return node[static_cast<size_t>(i + n[0] * (j + n[1] * k))]; };
  std::vector<Vec3> points;
  for (int k = 0; k < n[2]; ++k) {
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        bool used = false;
        for (int c = 0; c < 8; ++c) used = used || grid.is_solid(i - (c & 1), j - (c >> 1 & 1), k - (c >> 2));
        if (!used) continue;
        at(i, j, k) = static_cast<int>(points.size());
        points.push_back(grid.corner(i, j, k));
      }
    }
  }
  TetMesh mesh;
  mesh.rest.resize(3, static_cast<Eigen::Index>(points.size()));
  for (size_t p = 0; p < points.size(); ++p) mesh.rest.col(static_cast<Eigen::Index>(p)) = points[p];
  for (int k = 0; k < grid.count[2]; ++k) {
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        if (!grid.is_solid(i, j, k)) continue;
        std::array<int, 8> corner{};
        for (int c = 0; c < 8; ++c) corner[static_cast<size_t>(c)] = at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        cut_cube(corner, (i & 1) | (j & 1) << 1 | (k & 1) << 2, &mesh.tets);
      }
    }
  }
  return mesh;
}

/// Do a triangle and an axis-parallel box share a point? By separating axes [Akenine-Moller 2001].
bool overlap(const std::array<Vec3, 3>& triangle, const Vec3& center, const Vec3& half) {
  std::array<Vec3, 3> p, edge;
  for (size_t k = 0; k < 3; ++k) p[k] = triangle[k] - center;
  for (size_t k = 0; k < 3; ++k) edge[k] = p[(k + 1) % 3] - p[k];
  const auto separates = [&](const Vec3& axis) {
    const double reach = half.dot(axis.cwiseAbs());
    const double a = axis.dot(p[0]), b = axis.dot(p[1]), c = axis.dot(p[2]);
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (separates(Vec3::Unit(axis))) return false;
    for (const Vec3& e : edge) {
      if (separates(Vec3::Unit(axis).cross(e))) return false;
    }
  }
  return !separates(edge[0].cross(edge[1]));
}

/// Is `p` left of the line from a to b, in the y-z plane? A point on the line is left of it one way round and right of
/// it the other, so that exactly one of two triangles at an edge holds it.
bool left_of(const Nodes& x, int a, int b, const Vec3& p) {
  const int low = std::min(a, b), high = std::max(a, b);
  const Vec3 along = x.col(high) - x.col(low), to = p - x.col(low);
  return (along.y() * to.z() - along.z() * to.y() >= 0.0) == (a < b);
}

Index3 cell_at(const CellGrid& grid, const Vec3& p) {
  Index3 cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const double position = std::floor((p[axis] - grid.origin[axis]) / grid.spacing[axis]);
    cell[static_cast<size_t>(axis)] =
        static_cast<int>(std::clamp(position, 0.0, grid.count[static_cast<size_t>(axis)] - 1.0));
  }
  return cell;
}

/// Marks the cells whose inside the surface cuts, and those whose centre it winds around.
void mark_solid(const TriangleMesh& surface, CellGrid* grid) {
  // A surface that lies in the faces of cells cuts none of them.
  const Vec3 half = (0.5 - 1e-6) * grid->spacing;
  // Lines through the centres along x, a little off them: a line through a vertex would be counted wrongly.
  const Vec3 off = Vec3(0.0, 1.37e-5, 2.11e-5).cwiseProduct(grid->spacing);
  std::vector<int> winding(grid->solid.size(), 0);
  for (const auto& t : surface.triangles) {
    const std::array<Vec3, 3> p = {surface.rest.col(t[0]), surface.rest.col(t[1]), surface.rest.col(t[2])};
    const Index3 low = cell_at(*grid, p[0].cwiseMin(p[1]).cwiseMin(p[2]) - 1e-3 * grid->spacing);
    const Index3 high = cell_at(*grid, p[0].cwiseMax(p[1]).cwiseMax(p[2]) + 1e-3 * grid->spacing);
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
    for (int k = low[2]; k <= high[2]; ++k) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int i = low[0]; i <= high[0]; ++i) {
          char& solid = grid->solid[grid->cell(i, j, k)];
          if (!solid) solid = overlap(p, grid->corner(i, j, k) + 0.5 * grid->spacing, half) ? 1 : 0;
        }
        const Vec3 center = grid->corner(0, j, k) + 0.5 * grid->spacing + off;
        const int left = left_of(surface.rest, t[0], t[1], center) + left_of(surface.rest, t[1], t[2], center) +
                         left_of(surface.rest, t[2], t[0], center);
        if (left != (normal.x() > 0.0 ? 3 : 0)) continue;
        // The line meets the triangle's plane here; centres before it are behind or before one more face.
        const double x = p[0].x() + normal.tail<2>().dot((p[0] - center).tail<2>()) / normal.x();
        for (int i = 0; i < grid->count[0] && center.x() + i * grid->spacing.x() < x; ++i) {
          winding[grid->cell(i, j, k)] += left == 3 ? 1 : -1;
        }
      }
    }
  }
  for (size_t c = 0; c < winding.size(); ++c) {
    if (winding[c] != 0) grid->solid[c] = 1;
  }
}

/// Do all marked cells of a block of eight hang together by faces?
bool hangs_together(int block) {
  int reached = block & -block;
  for (int before = 0; before != reached;) {
    before = reached;
    for (int c = 0; c < 8; ++c) {
      if (reached >> c & 1) reached |= (1 << (c ^ 1) | 1 << (c ^ 2) | 1 << (c ^ 4)) & block;
    }
  }
  return reached == block;
}

/// Fills blocks of eight whose solid or whose empty cells touch by an edge or a corner only: the surface becomes a
/// manifold.
void fill_loose_blocks(CellGrid* grid) {
  for (bool changed = true; changed;) {
    changed = false;
    for (int k = -1; k < grid->count[2]; ++k) {
      for (int j = -1; j < grid->count[1]; ++j) {
        for (int i = -1; i < grid->count[0]; ++i) {
          int block = 0;
          for (int c = 0; c < 8; ++c) {
            if (grid->is_solid(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))) block |= 1 << c;
          }
          if (hangs_together(block) && hangs_together(~block & 255)) continue;
          changed = true;
          for (int c = 0; c < 8; ++c) {
            const int a = i + (c & 1), b = j + (c >> 1 & 1), d = k + (c >> 2);
            const bool inside =
                a >= 0 && b >= 0 && d >= 0 && a < grid->count[0] && b < grid->count[1] && d < grid->count[2];
            if (inside) grid->solid[grid->cell(a, b, d)] = 1;
          }
        }
      }
    }
  }
}

void check_count(const Vec3& count) {
  if (count.prod() > kMostCells) {
    throw InputError("the volume takes " + std::to_string(count[0]) + " x " + std::to_string(count[1]) + " x " +
                     std::to_string(count[2]) + " cells; at most ten million are allowed");
  }
}

}  // namespace

TetMesh make_box(const Vec3& size, const std::array<int, 3>& cells) {
  if (!size.allFinite() || !(size.minCoeff() > 0.0)) {
    throw InputError("box size is " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
                     std::to_string(size[2]) + " m; all three must be finite and > 0");
  }
  if (cells[0] < 1 || cells[1] < 1 || cells[2] < 1) {
    throw InputError("box has " + std::to_string(cells[0]) + " x " + std::to_string(cells[1]) + " x " +
                     std::to_string(cells[2]) + " cells; at least 1 x 1 x 1 is needed");
  }
  const Vec3 count(cells[0], cells[1], cells[2]);
  check_count(count);
  return mesh_of(CellGrid(-0.5 * size, size.cwiseQuotient(count), cells, 1));
}

TetMesh make_lattice_around(const TriangleMesh& surface, double cell) {
  check_mesh(surface);
  if (!is_closed(surface)) {
    throw InputError("the surface is not closed: an edge has a face on one side only");
  }
  if (!(cell > 0.0) || !std::isfinite(cell)) {
    throw InputError("the cell's edge is " + std::to_string(cell) + " m; it must be finite and > 0");
  }
  const Vec3 low = surface.rest.rowwise().minCoeff(), high = surface.rest.rowwise().maxCoeff();
  // A surface as long as a whole number of cells takes just these.
  const Vec3 count = ((high - low) / cell - Vec3::Constant(1e-6)).array().ceil().max(1.0);
  check_count(count);
  const Vec3 origin = 0.5 * (low + high - cell * count);
  CellGrid grid(origin, Vec3::Constant(cell),
                {static_cast<int>(count[0]), static_cast<int>(count[1]), static_cast<int>(count[2])}, 0);
  mark_solid(surface, &grid);
  fill_loose_blocks(&grid);
  return mesh_of(grid);
}

}  // namespace deformable_sim
