#include "deformable_sim/core/topology/embedding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/box_tree.h"

namespace deformable_sim {

namespace {

using Eigen::Vector4d;
using Triplet = Eigen::Triplet<double>;

constexpr double kSameDistance = 1e-9;  // relative: triangles and tetrahedra that touch at the nearest point
constexpr double kSearchFurther = 1.5;  // the triangle below a point need not be the nearest one
constexpr int kMaxIterations = 50;

// Pairs of corners whose middle carries a node, in the order of TetMesh::mid_nodes.
constexpr std::array<std::array<int, 2>, 6> kEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Barycentric coordinates of the point of triangle abc nearest to p.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e1 = b - a, e2 = c - a, d = p - a;
  const double g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm(), r1 = e1.dot(d), r2 = e2.dot(d);
  const double determinant = g11 * g22 - g12 * g12;
  const double u = (g22 * r1 - g12 * r2) / determinant, v = (g11 * r2 - g12 * r1) / determinant;
  if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) return {1.0 - u - v, u, v};
  // Outside: the nearest point lies on a side.
  Vec3 best = Vec3::UnitX();
  double best_distance = std::numeric_limits<double>::infinity();
  const std::array<Vec3, 3> corner{{a, b, c}};
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const Vec3 side = corner[static_cast<size_t>(l)] - corner[static_cast<size_t>(k)];
    const Vec3 from = p - corner[static_cast<size_t>(k)];
    const double s = std::clamp(from.dot(side) / side.squaredNorm(), 0.0, 1.0);
    const double distance = (from - s * side).squaredNorm();
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = Vec3::Zero();
    best[k] = 1.0 - s;
    best[l] = s;
  }
  return best;
}

void check_points(const Nodes& points) {
  for (int p = 0; p < points.cols(); ++p) {
    if (!points.col(p).allFinite()) throw InputError("surface vertex " + std::to_string(p) + " is not finite");
  }
}

/// Tetrahedra at rest: where a point lies in them.
class Volume {
 public:
  explicit Volume(const TetMesh& mesh) : mesh_(mesh) {
    for (size_t t = 0; t < mesh.tets.size(); ++t) {
      Mat3 edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = corner(t, k + 1) - corner(t, 0);
      if (!(std::abs(edges.determinant()) > 1e-14 * std::pow(edges.colwise().norm().maxCoeff(), 3))) {
        throw InputError("tetrahedron " + std::to_string(t) + " is flat");
      }
      inverse_.push_back(edges.inverse());
      Eigen::AlignedBox3d box;
      for (int k = 0; k < 4; ++k) box.extend(corner(t, k));
      boxes_.push_back(box);
    }
  }
  const std::vector<Eigen::AlignedBox3d>& boxes() const { return boxes_; }

  Vector4d barycentric(int tet, const Vec3& p) const {
    const auto t = static_cast<size_t>(tet);
    Vector4d w;
    w.tail<3>() = inverse_[t] * (p - corner(t, 0));
    w[0] = 1.0 - w.tail<3>().sum();
    return w;
  }
  /// Barycentric coordinates of the point of the tetrahedron nearest to p, whose own are w.
  Vector4d closest(int tet, const Vec3& p, const Vector4d& w) const {
    if (w.minCoeff() >= 0.0) return w;
    const auto t = static_cast<size_t>(tet);
    Vector4d best = w;
    double best_distance = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {  // the face opposite to corner k
      const std::array<int, 3> face{{(k + 1) % 4, (k + 2) % 4, (k + 3) % 4}};
      const Vec3 on_face = closest_on_triangle(p, corner(t, face[0]), corner(t, face[1]), corner(t, face[2]));
      Vector4d candidate = Vector4d::Zero();
      for (int l = 0; l < 3; ++l) candidate[face[static_cast<size_t>(l)]] = on_face[l];
      const double distance = (position(t, candidate) - p).squaredNorm();
      if (distance < best_distance) {
        best_distance = distance;
        best = candidate;
      }
    }
    return best;
  }
  double squared_distance(int tet, const Vec3& p) const {
    const Vector4d w = barycentric(tet, p);
    if (w.minCoeff() >= 0.0) return 0.0;
    return (position(static_cast<size_t>(tet), closest(tet, p, w)) - p).squaredNorm();
  }

 private:
  Vec3 corner(size_t t, int k) const { return mesh_.rest.col(mesh_.tets[t][static_cast<size_t>(k)]); }
  Vec3 position(size_t t, const Vector4d& w) const {
    return w[0] * corner(t, 0) + w[1] * corner(t, 1) + w[2] * corner(t, 2) + w[3] * corner(t, 3);
  }

  const TetMesh& mesh_;
  std::vector<Mat3> inverse_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

/// The tetrahedron that carries p: one that contains it, otherwise of the nearest ones the one it is least outside of.
int carrier(const Volume& volume, const BoxTree& tree, const Vec3& p) {
  const auto [distance, nearest] = tree.nearest(p, [&](int tet) { return volume.squared_distance(tet, p); });
  if (distance == 0.0) return nearest;
  int best = nearest;
  double least = -std::numeric_limits<double>::infinity();
  const double reach = (1.0 + kSameDistance) * distance;
  tree.visit_within(p, reach, [&](int tet) {
    const double inside = volume.barycentric(tet, p).minCoeff();
    if (inside > least && volume.squared_distance(tet, p) <= reach) {
      least = inside;
      best = tet;
    }
  });
  return best;
}

/// Quadratic shape functions at the point `at` (barycentric), continued linearly to `at + step`:
/// N_a = l_a (2 l_a - 1) at corner a, N_ab = 4 l_a l_b in the middle of ab.
Eigen::Matrix<double, 10, 1> quadratic_weights(const Vector4d& at, const Vector4d& step) {
  Eigen::Matrix<double, 10, 1> n;
  for (int a = 0; a < 4; ++a) n[a] = at[a] * (2.0 * at[a] - 1.0) + (4.0 * at[a] - 1.0) * step[a];
  for (int e = 0; e < 6; ++e) {
    const int a = kEdges[static_cast<size_t>(e)][0], b = kEdges[static_cast<size_t>(e)][1];
    n[4 + e] = 4.0 * (at[a] * at[b] + at[a] * step[b] + at[b] * step[a]);
  }
  return n;
}

Eigen::SparseMatrix<double> gather(Eigen::Index nodes, Eigen::Index points, const std::vector<Triplet>& entries) {
  Eigen::SparseMatrix<double> weights(nodes, points);
  weights.setFromTriplets(entries.begin(), entries.end());
  weights.makeCompressed();
  return weights;
}

/// Where p lies in the prism over a triangle that its corners sweep along their normals.
struct PrismPoint {
  bool found = false;
  double height = 0.0;  // m
  Vec3 weights;         // of the corners, which move by the height
};

/// The height at which p lies in the plane through the moved corners solves
///   (p - a - h n_a) . ((e1 + h d1) x (e2 + h d2)) = 0,   e1 = b - a, d1 = n_b - n_a, ...
/// a cubic in h, by Newton from the height above the triangle itself.
PrismPoint locate_in_prism(const Vec3& p, const std::array<Vec3, 3>& x, const std::array<Vec3, 3>& n) {
  const Vec3 r = p - x[0], e1 = x[1] - x[0], e2 = x[2] - x[0], d1 = n[1] - n[0], d2 = n[2] - n[0];
  const Vec3 c0 = e1.cross(e2), c1 = e1.cross(d2) + d1.cross(e2), c2 = d1.cross(d2);
  const double k0 = r.dot(c0), k1 = r.dot(c1) - n[0].dot(c0), k2 = r.dot(c2) - n[0].dot(c1), k3 = -n[0].dot(c2);
  PrismPoint point;
  double h = k0 / c0.norm();
  const double scale = std::max(r.norm(), c0.norm() / std::max(e1.norm(), e2.norm()));
  for (int i = 0; i < kMaxIterations && !point.found; ++i) {
    const double slope = k1 + h * (2.0 * k2 + 3.0 * h * k3);
    const double change = -(k0 + h * (k1 + h * (k2 + h * k3))) / slope;
    if (!std::isfinite(change)) return point;
    h += change;
    point.found = std::abs(change) <= 32.0 * std::numeric_limits<double>::epsilon() * scale;
  }
  const Vec3 q = r - h * n[0], f1 = e1 + h * d1, f2 = e2 + h * d2, normal = f1.cross(f2);
  // A prism turned inside out has passed its focus: no neighbourhood of the sheet reaches there.
  point.found = point.found && normal.dot(c0) > 1e-6 * c0.squaredNorm();
  if (!point.found) return point;
  point.height = h;
  point.weights[1] = q.cross(f2).dot(normal) / normal.squaredNorm();
  point.weights[2] = f1.cross(q).dot(normal) / normal.squaredNorm();
  point.weights[0] = 1.0 - point.weights[1] - point.weights[2];
  return point;
}

/// Comes before another place of the same point: a prism that contains it, then the lower one, then that which it is
/// least outside of.
bool better(const PrismPoint& a, const PrismPoint& b) {
  const double inside_a = a.weights.minCoeff(), inside_b = b.weights.minCoeff();
  const bool in_a = inside_a >= -kSameDistance, in_b = inside_b >= -kSameDistance;
  if (in_a != in_b) return in_a;
  return in_a ? std::abs(a.height) < std::abs(b.height) : inside_a > inside_b;
}

/// Triangles at rest, with the normals of their corners.
class Sheet {
 public:
  explicit Sheet(const TriangleMesh& mesh) : mesh_(mesh), normals_(vertex_normals(mesh, mesh.rest)) {
    for (const std::array<int, 3>& triangle : mesh.triangles) {
      Eigen::AlignedBox3d box;
      for (const int node : triangle) box.extend(Vec3(mesh.rest.col(node)));
      boxes_.push_back(box);
    }
  }
  const std::vector<Eigen::AlignedBox3d>& boxes() const { return boxes_; }

  /// The place of p and the triangle it is in. `index` names the point in a refusal.
  std::pair<PrismPoint, int> find(const BoxTree& tree, const Vec3& p, int index) const {
    const auto [nearest, first] = tree.nearest(p, [&](int triangle) { return squared_distance(triangle, p); });
    const double size = boxes_[static_cast<size_t>(first)].sizes().norm();
    const double reach = kSearchFurther * std::sqrt(nearest) + kSameDistance * size;
    PrismPoint best;
    int carrier = -1;
    tree.visit_within(p, reach * reach, [&](int triangle) {
      if (squared_distance(triangle, p) > reach * reach) return;
      const PrismPoint found = locate_in_prism(p, corners(mesh_.rest, triangle), corners(normals_, triangle));
      if (!found.found || (carrier >= 0 && !better(found, best))) return;
      best = found;
      carrier = triangle;
    });
    if (carrier < 0) {
      throw InputError("surface vertex " + std::to_string(index) + " is " + std::to_string(std::sqrt(nearest)) +
                       " m off the sheet, beyond its radius of curvature; bring the surface closer");
    }
    return {best, carrier};
  }

 private:
  std::array<Vec3, 3> corners(const Nodes& of, int triangle) const {
    const std::array<int, 3>& nodes = mesh_.triangles[static_cast<size_t>(triangle)];
    return {{of.col(nodes[0]), of.col(nodes[1]), of.col(nodes[2])}};
  }
  double squared_distance(int triangle, const Vec3& p) const {
    const std::array<Vec3, 3> x = corners(mesh_.rest, triangle);
    const Vec3 w = closest_on_triangle(p, x[0], x[1], x[2]);
    return (w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - p).squaredNorm();
  }

  const TriangleMesh& mesh_;
  Nodes normals_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

}  // namespace

Embedding embed_in_volume(const Nodes& points, const TetMesh& mesh) {
  if (mesh.tets.empty()) throw InputError("the mesh has no tetrahedron to carry a surface");
  check_points(points);
  const Volume volume(mesh);
  const BoxTree tree(volume.boxes());
  std::vector<Triplet> entries;
  entries.reserve(static_cast<size_t>(points.cols()) * (mesh.is_quadratic() ? 10 : 4));
  for (int p = 0; p < points.cols(); ++p) {
    const Vec3 point = points.col(p);
    const int tet = carrier(volume, tree, point);
    const Vector4d w = volume.barycentric(tet, point);
    const std::array<int, 4>& corners = mesh.tets[static_cast<size_t>(tet)];
    if (!mesh.is_quadratic()) {
      for (int a = 0; a < 4; ++a) entries.emplace_back(corners[static_cast<size_t>(a)], p, w[a]);
      continue;
    }
    const Vector4d at = volume.closest(tet, point, w);
    const auto n = quadratic_weights(at, w - at);
    const std::array<int, 6>& middles = mesh.mid_nodes[static_cast<size_t>(tet)];
    for (int a = 0; a < 4; ++a) entries.emplace_back(corners[static_cast<size_t>(a)], p, n[a]);
    for (int e = 0; e < 6; ++e) entries.emplace_back(middles[static_cast<size_t>(e)], p, n[4 + e]);
  }
  return {gather(mesh.rest.cols(), points.cols(), entries), {}};
}

Embedding embed_in_sheet(const Nodes& points, const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw InputError("the sheet has no triangle to carry a surface");
  check_points(points);
  const Sheet sheet(mesh);
  const BoxTree tree(sheet.boxes());
  Embedding embedding;
  embedding.height.resize(points.cols());
  std::vector<Triplet> entries;
  entries.reserve(3 * static_cast<size_t>(points.cols()));
  for (int p = 0; p < points.cols(); ++p) {
    const auto [place, triangle] = sheet.find(tree, points.col(p), p);
    embedding.height[p] = place.height;
    for (int k = 0; k < 3; ++k) {
      entries.emplace_back(mesh.triangles[static_cast<size_t>(triangle)][static_cast<size_t>(k)], p, place.weights[k]);
    }
  }
  embedding.weights = gather(mesh.rest.cols(), points.cols(), entries);
  return embedding;
}

}  // namespace deformable_sim
