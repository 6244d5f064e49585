#include "deformable_sim/core/energy/limit_springs.h"

#include <algorithm>

namespace deformable_sim {

double LimitSprings::tension(const Element& e, const Nodes& x) {
  if (e.stiffness == 0.0) return 0.0;
  return std::max(0.0, e.tension + e.stiffness * ((x.col(e.b) - x.col(e.a)).norm() - e.longest));
}

double LimitSprings::value(const State& s) const {
  double sum = 0.0;
  for (const Element& e : elements_) {
    const double t = tension(e, s.x);
    if (t > 0.0) sum += 0.5 * t * t / e.stiffness;
  }
  return sum;
}

void LimitSprings::add_force(const State& s, Nodes* f) const {
  for (const Element& e : elements_) {
    const double t = tension(e, s.x);
    if (t == 0.0) continue;
    const Vec3 force = t * (s.x.col(e.b) - s.x.col(e.a)).normalized();
    f->col(e.a) += force;
    f->col(e.b) -= force;
  }
}

void LimitSprings::add_pattern(std::vector<std::array<int, 2>>* pairs) const {
  for (const Element& e : elements_) pairs->push_back({e.a, e.b});
}

void LimitSprings::bind(const BlockMatrix& matrix) {
  slots_.clear();
  for (const Element& e : elements_)
    slots_.push_back({matrix.slot(e.a, e.a), matrix.slot(e.a, e.b), matrix.slot(e.b, e.a), matrix.slot(e.b, e.b)});
}

void LimitSprings::add_jacobian(const State& s, double dx, double, Jacobian kind, BlockMatrix* a) const {
  for (size_t k = 0; k < elements_.size(); ++k) {
    const Element& e = elements_[k];
    const double t = tension(e, s.x);
    if (t == 0.0) continue;
    const Vec3 d = s.x.col(e.b) - s.x.col(e.a);
    const double r = d.norm(), transverse = kind == Jacobian::kAxial ? 0.0 : t / r;
    const Vec3 n = d / r;
    Mat3 h = (dx * (e.stiffness - transverse)) * n * n.transpose();
    h.diagonal().array() += dx * transverse;
    a->block(slots_[k][0]) += h;
    a->block(slots_[k][1]) -= h;
    a->block(slots_[k][2]) -= h;
    a->block(slots_[k][3]) += h;
  }
}

}  // namespace deformable_sim
