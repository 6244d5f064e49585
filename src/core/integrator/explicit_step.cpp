#include "deformable_sim/core/integrator/explicit_step.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr int kContactPasses = 8;  // contacts that share nodes push each other; one pass would do otherwise

}  // namespace

void ExplicitStep::begin(double dt, Dynamics* d, const State& s) {
  dt_ = dt;
  dynamics_ = d;
  const Kinematics& k = d->kinematics;
  const auto held = static_cast<Eigen::Index>(k.node.size());
  inverse_mass_ = d->mass->cwiseInverse();
  x0_.resize(3, held);
  v0_.resize(3, held);
  mean_force_.setZero(3, held);
  for (Eigen::Index i = 0; i < held; ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    inverse_mass_[node] = 0.0;
    x0_.col(i) = s.x.col(node);
    v0_.col(i) = s.v.col(node);
  }
  if (d->mass_matrix == nullptr) return;
  v_start_ = s.v;
  prescribed_inertia_.setZero(3, s.x.cols());
  add_prescribed_inertia(dt, *d->mass_matrix, k, s.x, s.v, &prescribed_inertia_);
  if (!mass_factor_) mass_factor_ = std::make_unique<MassFactor>();
  mass_factor_->prepare(*d->mass_matrix, k.node);
}

void ExplicitStep::acceleration(const State& s, double weight, Nodes* a) {
  force_.setZero(3, s.x.cols());
  for (const Energy* energy : dynamics_->energies) energy->add_force(s, &force_);
  if (dynamics_->mass_matrix != nullptr) {
    *a = force_ + prescribed_inertia_;
    mass_factor_->solve(a);
  } else {
    a->resize(3, s.x.cols());
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) a->col(i) = inverse_mass_[i] * force_.col(i);
  }
  for (Eigen::Index i = 0; i < mean_force_.cols(); ++i) {
    mean_force_.col(i) += weight * force_.col(dynamics_->kinematics.node[static_cast<size_t>(i)]);
  }
}

void ExplicitStep::prescribe(double fraction, State* s) const {
  const Kinematics& k = dynamics_->kinematics;
  for (Eigen::Index i = 0; i < x0_.cols(); ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    const Vec3 path = k.target.col(i) - x0_.col(i);
    if (fraction == 1.0) {
      s->x.col(node) = k.target.col(i);
    } else {
      s->x.col(node) = x0_.col(i) + fraction * path;
    }
    s->v.col(node) = path / dt_;
  }
}

StepReport ExplicitStep::finish(double drift, State* s) {
  prescribe(1.0, s);
  resolve_contacts(drift, s);
  find_reactions(*s);
  s->time += dt_;
  StepReport report;
  report.converged = s->finite();
  return report;
}

/// m a - f with the means of a and f over the step.
void ExplicitStep::find_reactions(const State& s) {
  Kinematics& k = dynamics_->kinematics;
  k.reaction.resize(3, x0_.cols());
  for (Eigen::Index i = 0; i < x0_.cols(); ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    if (dynamics_->mass_matrix == nullptr) {
      k.reaction.col(i) = (*dynamics_->mass)[node] / dt_ * (s.v.col(node) - v0_.col(i)) - mean_force_.col(i);
      continue;
    }
    k.reaction.col(i) = -mean_force_.col(i);
    for (Eigen::SparseMatrix<double>::InnerIterator it(*dynamics_->mass_matrix, node); it; ++it) {
      k.reaction.col(i) += it.value() / dt_ * (s.v.col(it.row()) - v_start_.col(it.row()));
    }
  }
}

void ExplicitStep::resolve_contacts(double drift, State* s) {
  ContactConstraints& constraints = dynamics_->contacts;
  contacts_.clear();
  for (ContactConstraint& c : constraints) {
    c.force.setZero();
    double compliance = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      compliance += c.weight[k] * c.weight[k] * inverse_mass_[c.node[k]];
    }
    contacts_.push_back({compliance > 0.0 ? 1.0 / compliance : 0.0, 0.0, Vec3::Zero()});
  }
  for (int pass = 0; pass < kContactPasses; ++pass) {
    for (size_t i = 0; i < constraints.size(); ++i) {
      if (contacts_[i].mass > 0.0) resolve(constraints[i], drift, &contacts_[i], s);
    }
  }
  for (size_t i = 0; i < constraints.size(); ++i) {
    constraints[i].force = (contacts_[i].normal * constraints[i].normal + contacts_[i].friction) / dt_;
  }
}

void ExplicitStep::resolve(const ContactConstraint& c, double drift, Contact* contact, State* s) const {
  Vec3 point = Vec3::Zero(), velocity = -c.surface_velocity;
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    point += c.weight[k] * s->x.col(c.node[k]);
    velocity += c.weight[k] * s->v.col(c.node[k]);
  }
  // A scheme whose positions follow the old velocity must see the crossing of the next step in this one.
  const double gap = c.normal.dot(point) - c.offset, ahead = (1.0 - drift) * dt_;
  const double normal_velocity = c.normal.dot(velocity);
  if (gap + ahead * normal_velocity >= 0.0 && contact->normal == 0.0) return;

  if (gap < 0.0) add_to_positions(c, Vec3(-gap * contact->mass * c.normal), s);
  const double allowed = ahead > 0.0 ? -std::max(gap, 0.0) / ahead : 0.0;
  const double impulse = std::max(0.0, contact->normal + contact->mass * (allowed - normal_velocity));
  add_to_velocities(c, Vec3((impulse - contact->normal) * c.normal), s);
  contact->normal = impulse;

  const Vec3 sliding = velocity - normal_velocity * c.normal;
  Vec3 friction = contact->friction - contact->mass * sliding;
  const double size = friction.norm(), most = c.friction * contact->normal;
  if (size > most) friction *= most / size;
  const Vec3 change = friction - contact->friction;
  contact->friction = friction;
  add_to_velocities(c, change, s);
  add_to_positions(c, Vec3(drift * dt_ * change), s);
}

/// v += impulse / m, in N s, shared by the nodes of the point.
void ExplicitStep::add_to_velocities(const ContactConstraint& c, const Vec3& impulse, State* s) const {
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    s->v.col(c.node[k]) += (c.weight[k] * inverse_mass_[c.node[k]]) * impulse;
  }
}

/// x += moment / m, in kg m, shared by the nodes of the point.
void ExplicitStep::add_to_positions(const ContactConstraint& c, const Vec3& moment, State* s) const {
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    s->x.col(c.node[k]) += (c.weight[k] * inverse_mass_[c.node[k]]) * moment;
  }
}

}  // namespace deformable_sim
