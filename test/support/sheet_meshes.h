// Meshes of flat sheets for tests: rectangles cut out of lattices at any angle, and irregular ones.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include <Eigen/LU>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim::test {

using Points2 = std::vector<Eigen::Vector2d>;

/// The regular triangulation of points in the plane under heights z: the lower hull of (x, y, z). With z = x^2 + y^2 it
/// is Delaunay's; a little more or less at some points chooses among equals. By insertion: n up to some thousands.
inline std::vector<std::array<int, 3>> triangulate(Points2 points, std::vector<double> height) {
  const int n = static_cast<int>(points.size());
  double size = 0.0;
  for (const auto& p : points) size = std::max(size, p.cwiseAbs().maxCoeff());
  const double far = 30.0 * size;
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(-far, -0.9 * far), Eigen::Vector2d(1.1 * far, -far), Eigen::Vector2d(0.1 * far, far)}) {
    points.push_back(p);
    height.push_back(p.squaredNorm());
  }
  const auto below = [&](const std::array<int, 3>& t, int i) {
    Eigen::Matrix3d m;
    for (int k = 0; k < 3; ++k) {
      const auto corner = static_cast<size_t>(t[static_cast<size_t>(k)]), at = static_cast<size_t>(i);
      m.row(k) << (points[corner] - points[at]).transpose(), height[corner] - height[at];
    }
    return m.determinant() >
           1e-9 * m.row(0).head<2>().norm() * m.row(1).head<2>().norm() * m.col(2).cwiseAbs().maxCoeff();
  };
  std::vector<std::array<int, 3>> triangles = {{n, n + 1, n + 2}};
  for (int i = 0; i < n; ++i) {
    std::map<std::array<int, 2>, int> rim;
    std::vector<std::array<int, 3>> kept;
    for (const auto& t : triangles) {
      if (!below(t, i)) {
        kept.push_back(t);
        continue;
      }
      for (size_t k = 0; k < 3; ++k) ++rim[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& entry : rim) {
      const auto& edge = entry.first;
      if (rim.count({edge[1], edge[0]}) == 0) kept.push_back({edge[0], edge[1], i});
    }
    triangles = std::move(kept);
  }
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                 [n](const std::array<int, 3>& t) {
                                   return std::max({t[0], t[1], t[2]}) >= n;
                                 }),
                  triangles.end());
  return triangles;
}

inline TriangleMesh mesh_of(const Points2& points, const std::vector<double>& height) {
  TriangleMesh mesh;
  mesh.rest = Nodes::Zero(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) mesh.rest.col(static_cast<Eigen::Index>(i)).head<2>() = points[i];
  mesh.triangles = triangulate(points, height);
  return mesh;
}

enum class Diagonals { kUniform, kAlternating };

/// The grid of make_grid with all diagonals running the same way, from lower left to upper right.
inline TriangleMesh uniform_grid(double size_x, double size_y, int cells_x, int cells_y) {
  TriangleMesh mesh = make_grid(size_x, size_y, cells_x, cells_y);
  mesh.triangles.clear();
  for (int r = 0; r < cells_y; ++r) {
    for (int c = 0; c < cells_x; ++c) {
      const int a = r * mesh.cols + c, b = a + 1, d = a + mesh.cols, e = d + 1;
      mesh.triangles.push_back({a, b, e});
      mesh.triangles.push_back({a, e, d});
    }
  }
  return mesh;
}

inline TriangleMesh grid(Diagonals diagonals, double size_x, double size_y, int cells_x, int cells_y) {
  return diagonals == Diagonals::kUniform ? uniform_grid(size_x, size_y, cells_x, cells_y)
                                          : make_grid(size_x, size_y, cells_x, cells_y);
}

/// Rows of equilateral triangles of edge `edge` along x: rows + 1 rows of `columns` + 1 nodes, every other row shifted.
inline TriangleMesh equilateral_mesh(double edge, int columns, int rows) {
  TriangleMesh mesh;
  mesh.rest = Nodes::Zero(3, (columns + 1) * (rows + 1));
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= columns; ++c) {
      mesh.rest.col(r * (columns + 1) + c) =
          edge * Vec3(c + 0.5 * (r % 2) - 0.5 * columns, std::sqrt(0.75) * (r - 0.5 * rows), 0.0);
    }
  }
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int a = r * (columns + 1) + c, b = a + 1, d = a + columns + 1, e = d + 1;
      if (r % 2 == 0) {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, e, d});
      } else {
        mesh.triangles.push_back({a, b, e});
        mesh.triangles.push_back({a, e, d});
      }
    }
  }
  return mesh;
}

/// Rectangle [0, length] x [-width/2, width/2] of cells of about `cell`, filled with a square lattice turned by `angle`
/// (rad), nodes along the border evenly spaced. The first column of cells has straight sides across: a clamp.
inline TriangleMesh cut_strip(double length, double width, double cell, double angle, Diagonals diagonals) {
  const int along = static_cast<int>(std::lround(length / cell)), across = static_cast<int>(std::lround(width / cell));
  const double dx = length / along, dy = width / across;
  Points2 points;
  std::vector<double> height;
  const auto add = [&](double x, double y, double extra) {
    points.emplace_back(x, y);
    height.push_back(x * x + y * y + extra);
  };
  for (int i = 0; i <= along; ++i) {
    for (const double y : {-0.5 * width, 0.5 * width}) add(i * dx, y, 0.0);
  }
  for (int j = 1; j < across; ++j) {
    for (const double x : {0.0, dx, length}) add(x, -0.5 * width + j * dy, 0.0);
  }
  const int reach = static_cast<int>(1.5 * (length + width) / cell);
  const double margin = 0.45 * cell, c = std::cos(angle), s = std::sin(angle);
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      const double x = 0.5 * length + cell * (c * i - s * j), y = cell * (s * i + c * j);
      if (x < dx + margin || x > length - margin || std::abs(y) > 0.5 * width - margin) continue;
      // Of the two diagonals of a cell the one with the smaller sum of heights at its ends is drawn.
      const double extra = diagonals == Diagonals::kUniform ? 1e-3 * ((i - j) * (i - j)) : 1e-3 * std::abs((i + j) % 2);
      add(x, y, extra * cell * cell);
    }
  }
  return mesh_of(points, height);
}

/// Rectangle [0, length] x [-width/2, width/2], border evenly spaced, inner nodes of a grid moved by up to `jitter`
/// cells.
inline TriangleMesh irregular_mesh(double length, double width, int cells_x, int cells_y, double jitter,
                                   unsigned seed = 1) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-jitter, jitter);
  Points2 points;
  std::vector<double> height;
  for (int r = 0; r <= cells_y; ++r) {
    for (int c = 0; c <= cells_x; ++c) {
      const bool inner = r > 0 && r < cells_y && c > 0 && c < cells_x;
      const double x = length * (c + (inner ? uniform(generator) : 0.0)) / cells_x;
      const double y = width * ((r + (inner ? uniform(generator) : 0.0)) / cells_y - 0.5);
      points.emplace_back(x, y);
      height.push_back(x * x + y * y);
    }
  }
  return mesh_of(points, height);
}

}  // namespace deformable_sim::test
