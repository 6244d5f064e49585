// A square towel, folded twice: how its quarters lie.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "deformable_sim/core/model.h"

namespace deformable_sim::test {

/// Which quarters of the towel a plumb line at (x, y) meets, from below: 0 ... 3 as they were laid down, faces beside
/// the creases left out.
inline std::vector<int> quarters_at(const Model& model, const Nodes& x, double px, double py) {
  const TriangleMesh& mesh = *model.bodies[0].surface;
  std::vector<std::pair<double, int>> found;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = x.col(t[0]), b = x.col(t[1]), c = x.col(t[2]);
    Mat3 corners;
    corners << a.x(), b.x(), c.x(), a.y(), b.y(), c.y(), 1.0, 1.0, 1.0;
    if (std::abs(corners.determinant()) < 1e-9) continue;
    const Vec3 weight = corners.inverse() * Vec3(px, py, 1.0);
    if (weight.minCoeff() < 0.0) continue;
    const Vec3 rest = (mesh.rest.col(t[0]) + mesh.rest.col(t[1]) + mesh.rest.col(t[2])) / 3.0;
    if (std::abs(rest.x()) < 0.06 || std::abs(rest.y()) < 0.06) continue;
    const int quarter = rest.x() < 0.0 ? (rest.y() < 0.0 ? 0 : 1) : (rest.y() > 0.0 ? 2 : 3);
    found.emplace_back(weight.dot(Vec3(a.z(), b.z(), c.z())), quarter);
  }
  std::sort(found.begin(), found.end());
  std::vector<int> quarters;
  for (const auto& [height, quarter] : found) quarters.push_back(quarter);
  return quarters;
}

}  // namespace deformable_sim::test
