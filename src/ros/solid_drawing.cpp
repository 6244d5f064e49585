#include "deformable_sim/ros/solid_drawing.h"

#include "deformable_sim/ros/lit_triangles.h"

namespace deformable_sim {

namespace {

constexpr float kSharpEdge = 0.766f;  // cosine of 40 degrees

/// The faces around each point: those of point p are faces[first[p]] ... faces[first[p + 1] - 1].
struct FacesAround {
  std::vector<int> first, faces;

  FacesAround(const TriangleMesh& surface, Eigen::Index points)
      : first(static_cast<std::size_t>(points) + 1, 0), faces(3 * surface.triangles.size()) {
    for (const std::array<int, 3>& triangle : surface.triangles) {
      for (const int point : triangle) ++first[static_cast<std::size_t>(point) + 1];
    }
    for (std::size_t p = 1; p < first.size(); ++p) first[p] += first[p - 1];
    std::vector<int> next(first.begin(), first.end() - 1);
    for (std::size_t f = 0; f < surface.triangles.size(); ++f) {
      for (const int point : surface.triangles[f]) {
        faces[static_cast<std::size_t>(next[static_cast<std::size_t>(point)]++)] = static_cast<int>(f);
      }
    }
  }
};

}  // namespace

void draw_solid(const TriangleMesh& surface, const ShownColumns& x, const std::vector<Eigen::Vector3f>& colors,
                visualization_msgs::Marker* marker) {
  const auto count = static_cast<Eigen::Index>(surface.triangles.size());
  Eigen::Matrix3Xf areas(3, count), normals(3, count);
  for (Eigen::Index f = 0; f < count; ++f) {
    const std::array<int, 3>& t = surface.triangles[static_cast<std::size_t>(f)];
    const Vec3 a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]);
    areas.col(f) = (b - a).cross(c - a).cast<float>();
    normals.col(f) = areas.col(f).normalized();
  }
  const FacesAround around(surface, x.cols());
  const Light light;
  for (Eigen::Index f = 0; f < count; ++f) {
    for (const int point : surface.triangles[static_cast<std::size_t>(f)]) {
      const auto p = static_cast<std::size_t>(point);
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      for (int k = around.first[p]; k < around.first[p + 1]; ++k) {
        const int other = around.faces[static_cast<std::size_t>(k)];
        if (normals.col(other).dot(normals.col(f)) > kSharpEdge) normal += areas.col(other);
      }
      add_vertex(x.col(point), light.on(normal.normalized()) * colors[p], marker);
    }
  }
}

}  // namespace deformable_sim
