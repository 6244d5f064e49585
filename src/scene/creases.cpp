#include "creases.h"

#include <algorithm>

#include "build_parts.h"
#include "schema.h"

namespace deformable_sim {
namespace {

constexpr double kBeside = 0.05;  // of an edge's length: how far its ends may lie off the line
constexpr double kCovered = 0.9;  // of the line's length: what edges must cover

/// Distance from p to the line's points between its ends, m.
double distance_to(const CreaseSpec& line, const Eigen::Vector2d& p) {
  const Eigen::Vector2d along = line.to - line.from;
  const double t = std::clamp((p - line.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - line.from - t * along).norm();
}

[[noreturn]] void refuse(const CreaseSpec& line, const std::string& what) {
  const std::string place = line.where.file + (line.where.line > 0 ? ":" + std::to_string(line.where.line) : "");
  throw PlacedError(place + ": " + line.path + ": " + what);
}

}  // namespace

std::vector<Crease> find_creases(const TriangleMesh& mesh, const std::vector<CreaseSpec>& lines) {
  std::vector<Crease> creases;
  if (lines.empty()) return creases;
  const std::vector<std::array<int, 4>> hinges = hinges_of(mesh);
  for (const CreaseSpec& line : lines) {
    const double length = (line.to - line.from).norm();
    if (length == 0.0) refuse(line, "the crease has no length: from and to are the same");
    double covered = 0.0;
    for (const std::array<int, 4>& hinge : hinges) {
      const Eigen::Vector2d a = mesh.rest.col(hinge[0]).head<2>(), b = mesh.rest.col(hinge[1]).head<2>();
      const double edge = (b - a).norm();
      if (std::max(distance_to(line, a), distance_to(line, b)) > kBeside * edge) continue;
      covered += edge;
      creases.push_back({hinge[0], hinge[1], line.angle});
    }
    if (covered < kCovered * length) {
      refuse(line, "edges of the mesh cover " + format_number(covered) + " m of this crease of " +
                       format_number(length) +
                       " m; it must run along edges inside the sheet: choose cells so that "
                       "nodes lie on it");
    }
  }
  return creases;
}

}  // namespace deformable_sim
