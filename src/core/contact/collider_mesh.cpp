#include "deformable_sim/core/contact/collider_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>

#include "deformable_sim/core/contact/grid_cache.h"
#include "piece_planes.h"

namespace deformable_sim {
namespace {

/// Below this share of the size a distance is too much rounding to tell a direction.
constexpr double kLeastDistance = 1e-10;
/// Vertices this share of the size in front of a face still make a convex solid: coordinates in files are rounded to
/// single precision.
constexpr double kConvexSlack = 1e-6;
/// Pairs of face and vertex that are looked at to see whether a solid is convex; a larger one counts as not convex,
/// which costs time only.
constexpr double kMostConvexPairs = 4e8;

double angle_at(const Vec3& corner, const Vec3& a, const Vec3& b) {
  const Vec3 u = a - corner, v = b - corner;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

}  // namespace

ColliderMesh::ColliderMesh(SolidPart part, const MeshBuild& build)
    : part_(std::move(part)), tree_(part_.vertices, part_.triangles) {
  for (const Vec3& v : part_.vertices) {
    box_.extend(v);
    radius_ = std::max(radius_, v.norm());
  }
  least_ = kLeastDistance * box_.diagonal().norm();
  vertex_normals_.assign(part_.vertices.size(), Vec3::Zero());
  for (const std::array<int, 3>& t : part_.triangles) {
    const std::array<Vec3, 3> x{part_.vertices[static_cast<size_t>(t[0])], part_.vertices[static_cast<size_t>(t[1])],
                                part_.vertices[static_cast<size_t>(t[2])]};
    face_normals_.push_back((x[1] - x[0]).cross(x[2] - x[0]).normalized());
    for (size_t k = 0; k < 3; ++k)
      vertex_normals_[static_cast<size_t>(t[k])] +=
          angle_at(x[k], x[(k + 1) % 3], x[(k + 2) % 3]) * face_normals_.back();
  }
  convex_ = is_convex();
  grid_ = DistanceGrid(box_);
  if (build.cache_folder.empty()) {
    fill_grid(build.progress);
    return;
  }
  const std::uint64_t hash = content_hash(part_);
  if (read_grid(build.cache_folder, hash, &grid_)) return;
  fill_grid(build.progress);
  write_grid(build.cache_folder, hash, grid_);
}

bool ColliderMesh::is_convex() const {
  const double slack = kConvexSlack * box_.diagonal().norm();
  const auto above = [&](size_t face, int vertex) {
    const Vec3& on_face = part_.vertices[static_cast<size_t>(part_.triangles[face][0])];
    return face_normals_[face].dot(part_.vertices[static_cast<size_t>(vertex)] - on_face) > slack;
  };
  // Most solids that are not convex show it at an edge.
  for (size_t t = 0; t < part_.triangles.size(); ++t)
    for (const int n : part_.neighbours[t])
      for (const int v : part_.triangles[static_cast<size_t>(n)])
        if (above(t, v)) return false;
  if (static_cast<double>(part_.triangles.size()) * static_cast<double>(part_.vertices.size()) > kMostConvexPairs)
    return false;
  for (size_t t = 0; t < part_.triangles.size(); ++t)
    for (int v = 0; v < static_cast<int>(part_.vertices.size()); ++v)
      if (above(t, v)) return false;
  return true;
}

void ColliderMesh::fill_grid(const DistanceGrid::Progress& progress) {
  // The one FCL query of a mesh and a shape that is exact: a sphere of no size against a tree of OBBRSS, never
  // refitted.
  std::vector<fcl::Triangle> faces;
  for (const std::array<int, 3>& v : part_.triangles)
    faces.emplace_back(static_cast<size_t>(v[0]), static_cast<size_t>(v[1]), static_cast<size_t>(v[2]));
  fcl::BVHModel<fcl::OBBRSSd> model;
  model.beginModel(static_cast<int>(faces.size()), static_cast<int>(part_.vertices.size()));
  model.addSubModel(part_.vertices, faces);
  model.endModel();
  const fcl::Sphered point(0.0);
  fcl::Transform3d world_from_point = fcl::Transform3d::Identity();
  const fcl::DistanceRequestd request;
  const auto distance = [&](const Vec3& p, double reach) {
    world_from_point.translation() = p;
    fcl::DistanceResultd result(reach);
    fcl::distance(&model, fcl::Transform3d::Identity(), &point, world_from_point, request, result);
    MeshPoint found;
    if (result.b1 < 0 || result.b1 >= static_cast<std::intptr_t>(part_.triangles.size())) {
      exact(p, reach, &found);
      return found.distance;
    }
    const std::array<int, 3>& t = part_.triangles[static_cast<size_t>(result.b1)];
    TrianglePoint nearest =
        nearest_on_triangle(p, part_.vertices[static_cast<size_t>(t[0])], part_.vertices[static_cast<size_t>(t[1])],
                            part_.vertices[static_cast<size_t>(t[2])]);
    nearest.triangle = static_cast<int>(result.b1);
    return at(p, nearest).distance;
  };
  grid_.fill(distance, progress);
}

Vec3 ColliderMesh::pseudonormal(int triangle, TriangleFeature feature) const {
  const auto t = static_cast<size_t>(triangle);
  const int k = static_cast<int>(feature) - 1;
  if (k < 0) return face_normals_[t];
  if (k < 3) return face_normals_[t] + face_normals_[static_cast<size_t>(part_.neighbours[t][static_cast<size_t>(k)])];
  return vertex_normals_[static_cast<size_t>(part_.triangles[t][static_cast<size_t>(k - 3)])];
}

MeshPoint ColliderMesh::at(const Vec3& p, const TrianglePoint& nearest) const {
  const Vec3 outward = pseudonormal(nearest.triangle, nearest.feature);
  const Vec3 way = p - nearest.point;
  const double side = way.dot(outward) >= 0.0 ? 1.0 : -1.0;
  const double away = std::sqrt(nearest.squared_distance);
  MeshPoint found;
  found.triangle = nearest.triangle;
  found.distance = side * away;
  // Above a face its normal is exact; above edges and corners, where there is none, the way is taken.
  const bool by_way = nearest.feature != TriangleFeature::kFace && away > least_;
  found.normal = by_way ? Vec3(side * way.normalized()) : Vec3(outward.normalized());
  return found;
}

bool ColliderMesh::exact(const Vec3& p, double reach, MeshPoint* found) const {
  TrianglePoint nearest;
  if (!tree_.nearest(p, reach, &nearest)) return false;
  *found = at(p, nearest);
  return true;
}

bool ColliderMesh::nearest(const Vec3& p, double reach, MeshPoint* found) const {
  DistanceBounds bounds;
  double search = reach;  // beyond the grid everything is outside
  if (grid_.bounds(p, &bounds)) {
    if (bounds.low > reach) return false;
    const double farthest = std::max(bounds.high, -bounds.low);
    search = bounds.low > 0.0 ? std::min(reach, farthest) : farthest;
  }
  return exact(p, search, found) && found->distance <= reach;
}

double ColliderMesh::height_above(const Vec3& p, const MeshPoint& plane, int triangle) const {
  double highest = -std::numeric_limits<double>::infinity();
  for (const int v : part_.triangles[static_cast<size_t>(triangle)])
    highest = std::max(highest, plane.normal.dot(part_.vertices[static_cast<size_t>(v)] - p));
  return highest + plane.distance;
}

void ColliderMesh::gather(const Vec3& p, double reach, double clearance, double padding,
                          std::vector<TrianglePoint>* work, std::vector<MeshPoint>* planes) const {
  work->clear();
  tree_.within(p, reach + padding, work);
  const auto number_of = [](const TrianglePoint& c) { return c.triangle; };
  const auto height = [&](const MeshPoint& by, const TrianglePoint& c) { return height_above(p, by, c.triangle); };
  // From in front of a triangle or from behind, the plane has it below and p above.
  const auto facing = [&](const TrianglePoint& c) {
    MeshPoint plane = at(p, c);
    if (plane.distance < -least_) plane.normal = -plane.normal;
    plane.distance = std::abs(plane.distance);
    return plane;
  };
  gather_planes({clearance, padding, least_}, number_of, facing, height, work, planes);
}

void ColliderMesh::planes(const Vec3& p, const MeshPoint& surface, double reach, double clearance, double padding,
                          std::vector<TrianglePoint>* work, std::vector<MeshPoint>* planes) const {
  planes_at(
      p, surface, reach, {clearance, padding, least_},
      [this](const Vec3& from, double within, MeshPoint* found) { return exact(from, within, found); },
      [&](const Vec3& from, double within) { gather(from, within, clearance, padding, work, planes); }, planes);
}

std::vector<std::shared_ptr<const ColliderMesh>> make_collider_meshes(const TriangleMesh& mesh,
                                                                      const MeshBuild& build) {
  std::vector<std::shared_ptr<const ColliderMesh>> meshes;
  for (SolidPart& part : split_into_solids(mesh))
    meshes.push_back(std::make_shared<const ColliderMesh>(std::move(part), build));
  return meshes;
}

}  // namespace deformable_sim
