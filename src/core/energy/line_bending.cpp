#include "deformable_sim/core/energy/line_bending.h"

#include <map>
#include <utility>

#include "deformable_sim/core/energy/quadratic_term.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {

LineBending::LineBending(std::vector<Joint> joints, double damping) : joints_(std::move(joints)), damping_(damping) {
  std::map<std::array<int, 2>, double> weights;
  for (const Joint& j : joints_) {
    for (size_t p = 0; p < 3; ++p) {
      for (size_t q = 0; q < 3; ++q) weights[{j.node[p], j.node[q]}] += j.stiffness * j.share[p] * j.share[q];
    }
  }
  for (const auto& [pair, weight] : weights) entries_.push_back({pair, weight});
}

double LineBending::value(const State& s) const {
  double sum = 0.0;
  for (const Joint& j : joints_) sum += 0.5 * j.stiffness * curvature(s.x, j).squaredNorm();
  return sum;
}

void LineBending::add_force(const State& s, Nodes* f) const {
  for (const Joint& j : joints_) {
    Vec3 moment = curvature(s.x, j);
    if (damping_ > 0.0) moment += damping_ * curvature(s.v, j);
    moment *= j.stiffness;
    for (size_t p = 0; p < 3; ++p) f->col(j.node[p]) -= j.share[p] * moment;
  }
}

void LineBending::add_pattern(std::vector<std::array<int, 2>>* pairs) const {
  for (const Entry& e : entries_) {
    if (e.pair[0] < e.pair[1]) pairs->push_back(e.pair);
  }
}

void LineBending::bind(const BlockMatrix& matrix) {
  slots_.clear();
  for (const Entry& e : entries_) slots_.push_back(matrix.slot(e.pair[0], e.pair[1]));
}

void LineBending::add_jacobian(const State&, double dx, double dv, Jacobian, BlockMatrix* a) const {
  const double scale = dx + damping_ * dv;
  for (size_t k = 0; k < entries_.size(); ++k) {
    a->block(slots_[k]).diagonal().array() += scale * entries_[k].weight;
  }
}

void LineBending::add_entries(std::vector<Eigen::Triplet<double>>* stiffness,
                              std::vector<Eigen::Triplet<double>>* damping) const {
  for (const Entry& e : entries_) {
    stiffness->emplace_back(e.pair[0], e.pair[1], e.weight);
    if (damping_ > 0.0) damping->emplace_back(e.pair[0], e.pair[1], damping_ * e.weight);
  }
}

std::unique_ptr<Energy> make_line_bending(const Polyline& line, double rigidity, double damping, int first_node) {
  const auto nodes = static_cast<int>(line.rest.cols());
  std::vector<LineBending::Joint> joints;
  for (int k = 0; k < (line.closed ? nodes : nodes - 2); ++k) {
    const int p = k, q = (k + 1) % nodes, r = (k + 2) % nodes;
    const double a = (line.rest.col(q) - line.rest.col(p)).norm(), b = (line.rest.col(r) - line.rest.col(q)).norm();
    if (!(a > 0.0 && b > 0.0)) throw InputError("segments of a line must be longer than 0 m");
    const double l = 0.5 * (a + b);
    joints.push_back({{p + first_node, q + first_node, r + first_node},
                      {1.0 / (a * l), -(1.0 / a + 1.0 / b) / l, 1.0 / (b * l)},
                      rigidity * l});
  }
  return std::make_unique<LineBending>(std::move(joints), damping);
}

}  // namespace deformable_sim
