#include "deformable_sim/ros/body_colors.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

constexpr float kFastest = 1.0f;  // m/s shown as full colour

void color_by(const Eigen::VectorXf& values, std::vector<Color>* colors) {
  for (std::size_t i = 0; i < colors->size(); ++i) (*colors)[i] = scale_color(values[static_cast<Eigen::Index>(i)]);
}

/// Nodes with a structural edge that is stretched or compressed further than the material's law holds.
std::vector<char> nodes_beyond_validity(const Body& body, const Nodes& x) {
  std::vector<char> beyond(static_cast<std::size_t>(body.node_count), 0);
  for (const StrainEdge& edge : body.strain_edges) {
    const double strain = (x.col(edge.node[1]) - x.col(edge.node[0])).norm() / edge.rest_length - 1.0;
    if (strain >= body.valid_strain[0] && strain <= body.valid_strain[1]) continue;
    for (const int node : edge.node) beyond[static_cast<std::size_t>(node - body.first_node)] = 1;
  }
  return beyond;
}

void color_by_strain(const Snapshot& snapshot, const Body& body, double range, std::vector<Color>* colors) {
  const Color magenta(1.0f, 0.0f, 0.9f);
  color_by(shown_values(body, node_strain(body, snapshot.x)) / static_cast<float>(range), colors);
  const std::vector<char> beyond = nodes_beyond_validity(body, snapshot.x);
  for (std::size_t i = 0; i < colors->size(); ++i) {
    if (beyond[static_cast<std::size_t>(shown_node(body, static_cast<int>(i)))]) (*colors)[i] = magenta;
  }
}

void color_by_stress(const Snapshot& snapshot, const Body& body, double range, std::vector<Color>* colors) {
  Eigen::VectorXf stress = Eigen::VectorXf::Zero(body.node_count);
  if (body.stress) stress = body.stress(snapshot.x.middleCols(body.first_node, body.node_count));
  color_by(shown_values(body, stress / static_cast<float>(range)), colors);
}

/// Twice the mean force of the touching nodes, N; 0 where nothing touches.
double contact_range(const Snapshot& snapshot) {
  const Eigen::Index touching = (snapshot.contact_force.array() > 0.0f).count();
  return touching > 0 ? 2.0 * snapshot.contact_force.sum() / static_cast<double>(touching) : 0.0;
}

}  // namespace

Color scale_color(float value) {
  const float s = std::clamp(value, -1.0f, 1.0f);
  const Color grey(0.85f, 0.85f, 0.85f);
  const Color end = s < 0.0f ? Color(0.1f, 0.25f, 0.95f) : Color(0.95f, 0.1f, 0.05f);
  return grey + std::abs(s) * (end - grey);
}

ColorScale color_scale(const Snapshot& snapshot, const OutputSpec& outputs) {
  if (outputs.color_by == "strain") return {"strain", "", -outputs.strain_range, outputs.strain_range};
  if (outputs.color_by == "stress") return {"stress", "Pa", -outputs.stress_range, outputs.stress_range};
  if (outputs.color_by == "velocity") return {"velocity", "m/s", 0.0, kFastest};
  if (outputs.color_by == "contact") return {"contact force", "N", 0.0, contact_range(snapshot)};
  return {};
}

std::vector<Color> body_colors(const Snapshot& snapshot, const Body& body, const OutputSpec& outputs) {
  const Color own(static_cast<float>(body.color[0]), static_cast<float>(body.color[1]),
                  static_cast<float>(body.color[2]));
  std::vector<Color> colors(static_cast<std::size_t>(shown_count(body)), own);
  if (outputs.color_by == "strain") {
    color_by_strain(snapshot, body, outputs.strain_range, &colors);
  } else if (outputs.color_by == "stress") {
    color_by_stress(snapshot, body, outputs.stress_range, &colors);
  } else if (outputs.color_by == "velocity") {
    color_by(shown_velocities(snapshot, body).all().colwise().norm().transpose().cast<float>() / kFastest, &colors);
  } else if (outputs.color_by == "contact" && snapshot.contact_force.size() > 0) {
    const double range = contact_range(snapshot);
    const auto force = snapshot.contact_force.segment(body.first_node, body.node_count);
    color_by(shown_values(body, force / static_cast<float>(range > 0.0 ? range : 1.0)), &colors);
  }
  return colors;
}

}  // namespace deformable_sim
