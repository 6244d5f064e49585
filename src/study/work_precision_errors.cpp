#include "work_precision_errors.h"

#include <algorithm>

namespace deformable_sim::work_precision {
namespace {

/// Keeps a NaN, unlike std::max.
void take_larger(double value, double* largest) {
  if (!std::isnan(*largest) && !(value <= *largest)) *largest = value;
}

double edge_strain(const StrainEdge& edge, const Nodes& x) {
  return (x.col(edge.node[1]) - x.col(edge.node[0])).norm() / edge.rest_length - 1.0;
}

size_t common(const Trajectory& a, const Trajectory& b) {
  return std::min(a.size(), b.size());
}

}  // namespace

Yardstick::Yardstick(std::shared_ptr<const Model> model, const State& start) : model_(std::move(model)) {
  for (const Body& body : model_->bodies) {
    const auto x = start.x.middleCols(body.first_node, body.node_count);
    const double extent = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).maxCoeff();
    size_.push_back(extent > 0.0 ? extent : 1.0);
  }
  for (const auto& energy : model_->energies) stored_start_ += energy->value(start);
}

double Yardstick::distance(const Nodes& a, const Nodes& b) const {
  double sum = 0.0;
  int points = 0;
  for (size_t k = 0; k < model_->bodies.size(); ++k) {
    const Body& body = model_->bodies[k];
    const auto difference =
        a.middleCols(body.first_node, body.node_count) - b.middleCols(body.first_node, body.node_count);
    sum += difference.squaredNorm() / (size_[k] * size_[k]);
    points += body.node_count;
  }
  return std::sqrt(sum / points);
}

double Yardstick::position(const Trajectory& run, const Trajectory& reference) const {
  double largest = common(run, reference) > 0 ? 0.0 : kNone;
  for (size_t k = 0; k < common(run, reference); ++k) take_larger(distance(run[k].x, reference[k].x), &largest);
  return largest;
}

Errors Yardstick::errors(const Trajectory& run, const Trajectory& reference) const {
  Errors e;
  e.position = position(run, reference);
  if (run.size() == kQuarters && reference.size() == kQuarters) {
    e.position_end = distance(run.back().x, reference.back().x);
  }
  if (common(run, reference) == 0) return e;
  e.energy = energy_error(run, reference);
  e.measure = measure_error(run, reference);
  e.strain = strain_error(run, reference);
  e.grasp = grasp_error(run, reference);
  return e;
}

double Yardstick::measure(const Body& body, const Nodes& x) {
  double sum = 0.0;
  const auto at = [&](int node) -> Vec3 { return x.col(body.first_node + node); };
  if (body.volume) {
    for (const auto& t : body.volume->tets) {
      sum += (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).dot(at(t[3]) - at(t[0])) / 6.0;
    }
  } else if (body.surface) {
    for (const auto& t : body.surface->triangles) {
      sum += 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).norm();
    }
  } else {
    for (const StrainEdge& edge : body.strain_edges) sum += (x.col(edge.node[1]) - x.col(edge.node[0])).norm();
  }
  return sum;
}

double Yardstick::energy_error(const Trajectory& run, const Trajectory& reference) const {
  double scale = 0.0, largest = 0.0;
  for (const Sample& s : reference) scale = std::max(scale, s.kinetic + std::abs(s.stored - stored_start_));
  for (size_t k = 0; k < common(run, reference); ++k) {
    take_larger(std::abs(run[k].kinetic + run[k].stored - reference[k].kinetic - reference[k].stored), &largest);
  }
  return scale > 0.0 ? largest / scale : kNone;
}

double Yardstick::measure_error(const Trajectory& run, const Trajectory& reference) const {
  double largest = kNone;
  bool any = false;
  for (const Body& body : model_->bodies) {
    for (size_t k = 0; k < common(run, reference); ++k) {
      const double expected = measure(body, reference[k].x);
      if (!(std::abs(expected) > 0.0)) continue;
      if (!any) largest = 0.0;
      any = true;
      take_larger(std::abs(measure(body, run[k].x) / expected - 1.0), &largest);
    }
  }
  return largest;
}

double Yardstick::strain_error(const Trajectory& run, const Trajectory& reference) const {
  double largest = kNone;
  for (const Body& body : model_->bodies) {
    if (body.strain_edges.empty()) continue;
    if (std::isnan(largest)) largest = 0.0;
    for (size_t k = 0; k < common(run, reference); ++k) {
      for (const StrainEdge& edge : body.strain_edges) {
        take_larger(std::abs(edge_strain(edge, run[k].x) - edge_strain(edge, reference[k].x)), &largest);
      }
    }
  }
  return largest;
}

double Yardstick::grasp_error(const Trajectory& run, const Trajectory& reference) const {
  double scale = 0.0, largest = 0.0;
  for (const Sample& s : reference) {
    if (s.pull.cols() > 0) scale = std::max(scale, s.pull.topRows<3>().colwise().norm().maxCoeff());
  }
  if (!(scale > 0.0)) return kNone;
  const double lever = *std::max_element(size_.begin(), size_.end());
  for (size_t k = 0; k < common(run, reference); ++k) {
    if (run[k].pull.cols() != reference[k].pull.cols()) return kNone;
    const auto difference = run[k].pull - reference[k].pull;
    take_larger(difference.topRows<3>().colwise().norm().maxCoeff() / scale, &largest);
    take_larger(difference.bottomRows<3>().colwise().norm().maxCoeff() / (scale * lever), &largest);
  }
  return largest;
}

}  // namespace deformable_sim::work_precision
