#include "deformable_sim/core/topology/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

/// One side of a face: the edge as the face runs along it, and the face.
struct Side {
  std::array<int, 2> edge;  // ascending
  bool ascending;           // the face runs from the lower to the higher node
  int face;
  int opposite;
};

/// All sides of all faces, those of one edge next to each other in the order of their faces.
std::vector<Side> sides_of(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    const auto& t = mesh.triangles[f];
    for (size_t k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      sides.push_back({{std::min(i, j), std::max(i, j)}, i < j, static_cast<int>(f), t[(k + 2) % 3]});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.edge != b.edge ? a.edge < b.edge : a.face < b.face; });
  return sides;
}

std::string face_text(const TriangleMesh& mesh, int face) {
  const auto& t = mesh.triangles[static_cast<size_t>(face)];
  return "face " + std::to_string(face) + " (" + std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " +
         std::to_string(t[2]) + ")";
}

void check_vertices(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw InputError("the mesh has no face; at least one triangle is needed");
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    if (!mesh.rest.col(i).allFinite()) {
      throw InputError("vertex " + std::to_string(i) + " is not finite; all coordinates must be finite");
    }
  }
}

void check_faces(const TriangleMesh& mesh) {
  const int n = static_cast<int>(mesh.rest.cols());
  std::vector<char> used(static_cast<size_t>(n), 0);
  for (int f = 0; f < static_cast<int>(mesh.triangles.size()); ++f) {
    const auto& t = mesh.triangles[static_cast<size_t>(f)];
    for (int i : t) {
      if (i < 0 || i >= n) {
        throw InputError(face_text(mesh, f) + " names vertex " + std::to_string(i) + "; indices go from 0 to " +
                         std::to_string(n - 1));
      }
      used[static_cast<size_t>(i)] = 1;
    }
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      throw InputError(face_text(mesh, f) + " repeats a vertex; three different ones are needed");
    }
    const Vec3 e1 = mesh.rest.col(t[1]) - mesh.rest.col(t[0]), e2 = mesh.rest.col(t[2]) - mesh.rest.col(t[0]);
    const double scale = std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()});
    if (!(e1.cross(e2).norm() > 1e-9 * scale)) {
      throw InputError(face_text(mesh, f) + " has zero area; its vertices must not lie on a line");
    }
  }
  for (int i = 0; i < n; ++i) {
    if (!used[static_cast<size_t>(i)]) {
      throw InputError("vertex " + std::to_string(i) + " belongs to no face; every vertex must be used");
    }
  }
}

void check_edges(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sides_of(mesh);
  for (size_t first = 0; first < sides.size();) {
    size_t last = first + 1;
    while (last < sides.size() && sides[last].edge == sides[first].edge) ++last;
    const std::string edge =
        "edge (" + std::to_string(sides[first].edge[0]) + ", " + std::to_string(sides[first].edge[1]) + ")";
    if (last - first > 2) {
      throw InputError(edge + " is shared by " + std::to_string(last - first) + " faces; at most 2 are allowed");
    }
    if (last - first == 2 && sides[first].ascending == sides[first + 1].ascending) {
      throw InputError(edge + ": " + face_text(mesh, sides[first].face) + " and " +
                       face_text(mesh, sides[first + 1].face) +
                       " are wound the same way along it; neighbours must run along it in opposite directions");
    }
    first = last;
  }
}

}  // namespace

TriangleMesh make_grid(double size_x, double size_y, int cells_x, int cells_y) {
  if (!(size_x > 0.0) || !(size_y > 0.0) || !std::isfinite(size_x) || !std::isfinite(size_y)) {
    throw InputError("grid size is " + std::to_string(size_x) + " x " + std::to_string(size_y) +
                     " m; both must be finite and > 0");
  }
  if (cells_x < 1 || cells_y < 1) {
    throw InputError("grid has " + std::to_string(cells_x) + " x " + std::to_string(cells_y) +
                     " cells; at least 1 x 1 is needed");
  }
  TriangleMesh mesh;
  mesh.rows = cells_y + 1;
  mesh.cols = cells_x + 1;
  mesh.rest = Nodes::Zero(3, mesh.rows * mesh.cols);
  for (int r = 0; r < mesh.rows; ++r) {
    for (int c = 0; c < mesh.cols; ++c) {
      mesh.rest.col(r * mesh.cols + c) = Vec3(size_x * (static_cast<double>(c) / cells_x - 0.5),
                                              size_y * (static_cast<double>(r) / cells_y - 0.5), 0.0);
    }
  }
  mesh.triangles.reserve(static_cast<size_t>(2 * cells_x * cells_y));
  for (int r = 0; r < cells_y; ++r) {
    for (int c = 0; c < cells_x; ++c) {
      const int a = r * mesh.cols + c, b = a + 1, d = a + mesh.cols, e = d + 1;
      if ((r + c) % 2 == 0) {
        mesh.triangles.push_back({a, b, e});
        mesh.triangles.push_back({a, e, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, e, d});
      }
    }
  }
  return mesh;
}

std::vector<std::array<int, 2>> edges_of(const TriangleMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  for (const Side& side : sides_of(mesh)) {
    if (edges.empty() || edges.back() != side.edge) edges.push_back(side.edge);
  }
  return edges;
}

std::vector<std::array<int, 4>> hinges_of(const TriangleMesh& mesh) {
  std::vector<std::array<int, 4>> hinges;
  const std::vector<Side> sides = sides_of(mesh);
  for (size_t k = 0; k + 1 < sides.size(); ++k) {
    if (sides[k].edge == sides[k + 1].edge) {
      hinges.push_back({sides[k].edge[0], sides[k].edge[1], sides[k].opposite, sides[k + 1].opposite});
    }
  }
  return hinges;
}

Nodes vertex_normals(const TriangleMesh& mesh, const Eigen::Ref<const Nodes>& x) {
  Nodes normals = Nodes::Zero(3, x.cols());
  for (const auto& t : mesh.triangles) {
    const Vec3 a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]), area = (b - a).cross(c - a);
    for (const int node : t) normals.col(node) += area;
  }
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    const double length = normals.col(i).norm();
    normals.col(i) = length > 0.0 ? Vec3(normals.col(i) / length) : Vec3(Vec3::UnitZ());
  }
  return normals;
}

double enclosed_volume(const TriangleMesh& mesh) {
  double six = 0.0;
  for (const auto& t : mesh.triangles) {
    six += mesh.rest.col(t[0]).dot(mesh.rest.col(t[1]).cross(mesh.rest.col(t[2])));
  }
  return six / 6.0;
}

bool is_closed(const TriangleMesh& mesh) {
  return hinges_of(mesh).size() == edges_of(mesh).size();
}

void check_mesh(const TriangleMesh& mesh) {
  check_vertices(mesh);
  check_faces(mesh);
  check_edges(mesh);
}

}  // namespace deformable_sim
