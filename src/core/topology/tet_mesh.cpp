// Volumes of tetrahedra: middle nodes, boundary, checks.
#include "deformable_sim/core/topology/tet_mesh.h"

#include <algorithm>
#include <map>
#include <string>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

/// Corners of the edges that middle nodes lie on, see TetMesh.
constexpr std::array<std::array<size_t, 2>, 6> kEdges = {{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
/// Corners of the faces, seen counter-clockwise from outside, and the edges from each to the next.
constexpr std::array<std::array<size_t, 3>, 4> kFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
constexpr std::array<std::array<size_t, 3>, 4> kFaceEdges = {{{1, 5, 4}, {3, 5, 2}, {0, 4, 3}, {2, 1, 0}}};

/// One face of one tetrahedron.
struct Face {
  std::array<int, 3> corner;  // ascending
  bool even;                  // the face runs round its ascending corners, not against them
  size_t tet, face;
};

/// Faces of all tetrahedra, equal ones next to each other, otherwise in the order of the tetrahedra.
std::vector<Face> faces_of(const TetMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tets.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (size_t f = 0; f < 4; ++f) {
      std::array<int, 3> c{};
      for (size_t k = 0; k < 3; ++k) c[k] = mesh.tets[t][kFaces[f][k]];
      const bool even = ((c[0] < c[1]) + (c[1] < c[2]) + (c[2] < c[0])) == 2;
      std::sort(c.begin(), c.end());
      faces.push_back({c, even, t, f});
    }
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.corner < b.corner; });
  return faces;
}

std::string text_of(const TetMesh& mesh, size_t tet) {
  const auto& t = mesh.tets[tet];
  return "tetrahedron " + std::to_string(tet) + " (" + std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " +
         std::to_string(t[2]) + ", " + std::to_string(t[3]) + ")";
}

void check_indices(const TetMesh& mesh, size_t tet, std::vector<char>* used) {
  const int n = static_cast<int>(mesh.rest.cols());
  std::vector<int> nodes(mesh.tets[tet].begin(), mesh.tets[tet].end());
  if (mesh.is_quadratic()) nodes.insert(nodes.end(), mesh.mid_nodes[tet].begin(), mesh.mid_nodes[tet].end());
  for (const int i : nodes) {
    if (i < 0 || i >= n) {
      throw InputError(text_of(mesh, tet) + " names node " + std::to_string(i) + "; indices go from 0 to " +
                       std::to_string(n - 1));
    }
    (*used)[static_cast<size_t>(i)] = 1;
  }
  std::sort(nodes.begin(), nodes.end());
  const auto twice = std::adjacent_find(nodes.begin(), nodes.end());
  if (twice != nodes.end()) {
    throw InputError(text_of(mesh, tet) + " repeats node " + std::to_string(*twice) + "; all must be different");
  }
}

void check_shape(const TetMesh& mesh, size_t tet) {
  const auto& t = mesh.tets[tet];
  double longest = 0.0;
  for (const auto& e : kEdges) longest = std::max(longest, (mesh.rest.col(t[e[0]]) - mesh.rest.col(t[e[1]])).norm());
  const double volume = volume_of(mesh, tet), least = 1e-9 / 6.0 * longest * longest * longest;
  if (volume < -least) {
    throw InputError(text_of(mesh, tet) + " is turned inside out: its volume is " + std::to_string(volume) +
                     " m^3; (b - a) x (c - a) . (d - a) must be > 0");
  }
  if (!(volume > least)) {
    throw InputError(text_of(mesh, tet) + " has no volume; its corners must not lie in a plane");
  }
  for (size_t m = 0; mesh.is_quadratic() && m < kEdges.size(); ++m) {
    const int node = mesh.mid_nodes[tet][m], a = t[kEdges[m][0]], b = t[kEdges[m][1]];
    if ((mesh.rest.col(node) - 0.5 * (mesh.rest.col(a) + mesh.rest.col(b))).norm() > 1e-9 * longest) {
      throw InputError(text_of(mesh, tet) + ": node " + std::to_string(node) + " must lie in the middle of nodes " +
                       std::to_string(a) + " and " + std::to_string(b));
    }
  }
}

void check_faces(const TetMesh& mesh) {
  const std::vector<Face> faces = faces_of(mesh);
  for (size_t first = 0; first < faces.size();) {
    size_t last = first + 1;
    while (last < faces.size() && faces[last].corner == faces[first].corner) ++last;
    const auto& c = faces[first].corner;
    const std::string face =
        "face (" + std::to_string(c[0]) + ", " + std::to_string(c[1]) + ", " + std::to_string(c[2]) + ")";
    if (last - first > 2) {
      throw InputError(face + " belongs to " + std::to_string(last - first) + " tetrahedra; at most 2 are allowed");
    }
    if (last - first == 2 && faces[first].even == faces[first + 1].even) {
      throw InputError(text_of(mesh, faces[first].tet) + " and " + text_of(mesh, faces[first + 1].tet) +
                       " lie on the same side of their common " + face);
    }
    first = last;
  }
}

void check_mid_nodes(const TetMesh& mesh) {
  if (mesh.mid_nodes.size() != mesh.tets.size()) {
    throw InputError("the mesh has " + std::to_string(mesh.tets.size()) + " tetrahedra and middle nodes for " +
                     std::to_string(mesh.mid_nodes.size()) + "; all need them, or none");
  }
  std::map<std::array<int, 2>, int> middle;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (size_t m = 0; m < kEdges.size(); ++m) {
      const int a = mesh.tets[t][kEdges[m][0]], b = mesh.tets[t][kEdges[m][1]], node = mesh.mid_nodes[t][m];
      const auto [known, is_new] = middle.insert({{std::min(a, b), std::max(a, b)}, node});
      if (!is_new && known->second != node) {
        throw InputError(text_of(mesh, t) + " has node " + std::to_string(node) + " between nodes " +
                         std::to_string(a) + " and " + std::to_string(b) + ", a neighbour has node " +
                         std::to_string(known->second) + "; they must be the same");
      }
    }
  }
}

}  // namespace

double volume_of(const TetMesh& mesh, size_t tet) {
  const auto& t = mesh.tets[tet];
  const Vec3 a = mesh.rest.col(t[0]), b = mesh.rest.col(t[1]), c = mesh.rest.col(t[2]), d = mesh.rest.col(t[3]);
  return (b - a).cross(c - a).dot(d - a) / 6.0;
}

TetMesh with_mid_nodes(const TetMesh& mesh) {
  TetMesh quadratic;
  quadratic.tets = mesh.tets;
  quadratic.mid_nodes.reserve(mesh.tets.size());
  std::map<std::array<int, 2>, int> middle;
  std::vector<Vec3> added;
  for (const auto& t : mesh.tets) {
    std::array<int, 6> nodes{};
    for (size_t m = 0; m < kEdges.size(); ++m) {
      const int a = t[kEdges[m][0]], b = t[kEdges[m][1]];
      const int next = static_cast<int>(mesh.rest.cols()) + static_cast<int>(added.size());
      const auto [known, is_new] = middle.insert({{std::min(a, b), std::max(a, b)}, next});
      if (is_new) added.emplace_back(0.5 * (mesh.rest.col(a) + mesh.rest.col(b)));
      nodes[m] = known->second;
    }
    quadratic.mid_nodes.push_back(nodes);
  }
  quadratic.rest.resize(3, mesh.rest.cols() + static_cast<Eigen::Index>(added.size()));
  quadratic.rest.leftCols(mesh.rest.cols()) = mesh.rest;
  for (size_t k = 0; k < added.size(); ++k) {
    quadratic.rest.col(mesh.rest.cols() + static_cast<Eigen::Index>(k)) = added[k];
  }
  return quadratic;
}

TriangleMesh boundary_of(const TetMesh& mesh) {
  TriangleMesh surface;
  surface.rest = mesh.rest;
  const std::vector<Face> faces = faces_of(mesh);
  for (size_t k = 0; k < faces.size(); ++k) {
    const bool shared = (k > 0 && faces[k - 1].corner == faces[k].corner) ||
                        (k + 1 < faces.size() && faces[k + 1].corner == faces[k].corner);
    if (shared) continue;
    const auto& tet = mesh.tets[faces[k].tet];
    const auto& corner = kFaces[faces[k].face];
    const int a = tet[corner[0]], b = tet[corner[1]], c = tet[corner[2]];
    if (!mesh.is_quadratic()) {
      surface.triangles.push_back({a, b, c});
      continue;
    }
    const auto& mid = mesh.mid_nodes[faces[k].tet];
    const auto& edge = kFaceEdges[faces[k].face];
    const int ab = mid[edge[0]], bc = mid[edge[1]], ca = mid[edge[2]];
    surface.triangles.insert(surface.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return surface;
}

void check_mesh(const TetMesh& mesh) {
  if (mesh.tets.empty()) throw InputError("the mesh has no tetrahedron; at least one is needed");
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    if (!mesh.rest.col(i).allFinite()) {
      throw InputError("node " + std::to_string(i) + " is not finite; all coordinates must be finite");
    }
  }
  if (mesh.is_quadratic()) check_mid_nodes(mesh);
  std::vector<char> used(static_cast<size_t>(mesh.rest.cols()), 0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    check_indices(mesh, t, &used);
    check_shape(mesh, t);
  }
  const auto unused = std::find(used.begin(), used.end(), 0);
  if (unused != used.end()) {
    throw InputError("node " + std::to_string(unused - used.begin()) +
                     " belongs to no tetrahedron; every node must be used");
  }
  check_faces(mesh);
}

}  // namespace deformable_sim
