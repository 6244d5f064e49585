#include "deformable_sim/core/grasp/selection.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/frame_motion.h"

namespace deformable_sim {
namespace {

constexpr double kNearestReach = 0.02;  // m, when the request names none

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g m", value);
  return text;
}

/// Index and distance of the node of the body nearest to p.
std::pair<int, double> nearest_node(const Body& body, const Nodes& x, const Vec3& p) {
  int nearest = 0;
  const double d2 =
      (x.middleCols(body.first_node, body.node_count).colwise() - p).colwise().squaredNorm().minCoeff(&nearest);
  return {nearest, std::sqrt(d2)};
}

[[noreturn]] void refuse_empty(const Body& body, const Nodes& x, const Vec3& p, const std::string& searched) {
  throw InputError("no node of '" + body.name + "' " + searched + "; the nearest is " +
                       metres(nearest_node(body, x, p).second) + " away",
                   Code::kNotFound);
}

void check_number(double value, const char* what) {
  if (!std::isfinite(value) || value < 0.0) throw InputError(std::string(what) + " must be a finite number >= 0");
}

std::vector<int> nodes_in_radius(const Body& body, const Nodes& x, const Vec3& p, double radius) {
  std::vector<int> nodes;
  for (int i = 0; i < body.node_count; ++i)
    if ((x.col(body.first_node + i) - p).norm() <= radius) nodes.push_back(i);
  return nodes;
}

std::vector<int> nodes_in_box(const Body& body, const Nodes& x, const Pose& world_from_box, const Vec3& size) {
  std::vector<int> nodes;
  const Pose box_from_world = world_from_box.inverse();
  for (int i = 0; i < body.node_count; ++i) {
    const Vec3 local = box_from_world * Vec3(x.col(body.first_node + i));
    if ((local.cwiseAbs() - 0.5 * size).maxCoeff() <= 0.0) nodes.push_back(i);
  }
  return nodes;
}

std::vector<int> checked_nodes(const Body& body, std::vector<int> nodes) {
  if (nodes.empty()) throw InputError("the list of nodes is empty");
  std::sort(nodes.begin(), nodes.end());
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < 0 || nodes[i] >= body.node_count)
      throw InputError("node " + std::to_string(nodes[i]) + " does not exist; '" + body.name + "' has nodes 0 to " +
                           std::to_string(body.node_count - 1),
                       Code::kOutOfRange);
    if (i > 0 && nodes[i] == nodes[i - 1]) throw InputError("node " + std::to_string(nodes[i]) + " is listed twice");
  }
  return nodes;
}

std::vector<int> feature_nodes(const Body& body, const std::string& feature) {
  const auto found = body.features.find(feature);
  if (found == body.features.end() || found->second.empty()) {
    std::string known;
    for (const auto& [name, nodes] : body.features)
      if (!nodes.empty()) known += (known.empty() ? "" : ", ") + name;
    throw InputError(
        "'" + body.name + "' has no feature '" + feature + "'; it has: " + (known.empty() ? "none" : known),
        Code::kNotFound);
  }
  std::vector<int> nodes = found->second;
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

}  // namespace

std::vector<int> select_nodes(const Body& body, const Nodes& x, const Selection& selection) {
  const bool looks_somewhere = selection.method == SelectionMethod::kNearest ||
                               selection.method == SelectionMethod::kRadius ||
                               selection.method == SelectionMethod::kBox;
  if (looks_somewhere && !is_valid_pose(selection.world_from_selection))
    throw InputError("the selection's pose must be finite, within 1e6 m, with a unit quaternion");
  const Vec3 p = selection.world_from_selection.translation();

  switch (selection.method) {
    case SelectionMethod::kNearest: {
      check_number(selection.radius, "radius");
      const double reach = selection.radius > 0.0 ? selection.radius : kNearestReach;
      const auto [node, distance] = nearest_node(body, x, p);
      if (distance > reach) refuse_empty(body, x, p, "within " + metres(reach));
      return {node};
    }
    case SelectionMethod::kRadius: {
      check_number(selection.radius, "radius");
      if (selection.radius == 0.0) throw InputError("radius must be > 0 for a selection by radius");
      std::vector<int> nodes = nodes_in_radius(body, x, p, selection.radius);
      if (nodes.empty()) refuse_empty(body, x, p, "within " + metres(selection.radius));
      return nodes;
    }
    case SelectionMethod::kBox: {
      for (int i = 0; i < 3; ++i) check_number(selection.size[i], "box size");
      if (selection.size.minCoeff() == 0.0) throw InputError("box sizes must be > 0: full edge lengths");
      std::vector<int> nodes = nodes_in_box(body, x, selection.world_from_selection, selection.size);
      if (nodes.empty()) refuse_empty(body, x, p, "in the box");
      return nodes;
    }
    case SelectionMethod::kNodes:
      return checked_nodes(body, selection.nodes);
    case SelectionMethod::kFeature:
      return feature_nodes(body, selection.feature);
  }
  throw InputError("unknown selection method; allowed: nearest, radius, box, nodes, feature");
}

std::vector<int> clamped_nodes(const Body& body, const std::vector<int>& nodes) {
  if (body.first_segment < 0 || body.line->closed || nodes.empty()) return nodes;
  std::vector<int> clamped = nodes;
  const int last = body.node_count - 1;
  if (nodes.front() == 0) clamped.push_back(1);
  if (nodes.back() == last) clamped.push_back(last - 1);
  std::sort(clamped.begin(), clamped.end());
  clamped.erase(std::unique(clamped.begin(), clamped.end()), clamped.end());
  return clamped;
}

}  // namespace deformable_sim
