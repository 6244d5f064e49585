#include "deformable_sim/core/integrator/impulse_contacts.h"

#include <algorithm>

namespace deformable_sim {
namespace {

/// nodes += moment / m, shared by the nodes of the point.
void add(const ContactConstraint& c, const Eigen::VectorXd& inverse_mass, const Vec3& moment, Nodes* nodes) {
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    nodes->col(c.node[k]) += (c.weight[k] * inverse_mass[c.node[k]]) * moment;
  }
}

}  // namespace

void ImpulseContacts::resolve(const ContactConstraints& contacts, const Eigen::VectorXd& inverse_mass, double dt,
                              double drift, State* s, int passes) {
  points_.clear();
  for (const ContactConstraint& c : contacts) {
    double compliance = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      compliance += c.weight[k] * c.weight[k] * inverse_mass[c.node[k]];
    }
    points_.push_back({compliance > 0.0 ? 1.0 / compliance : 0.0, 0.0, Vec3::Zero(), 0.0});
  }
  bool touching = true;
  for (int pass = 0; pass < passes && touching; ++pass) {
    touching = false;
    for (size_t i = 0; i < contacts.size(); ++i) {
      if (points_[i].mass > 0.0) touching |= resolve(contacts[i], inverse_mass, dt, drift, &points_[i], s);
    }
  }
}

bool ImpulseContacts::resolve(const ContactConstraint& c, const Eigen::VectorXd& inverse_mass, double dt, double drift,
                              Point* contact, State* s) const {
  Vec3 point = Vec3::Zero(), velocity = -c.surface_velocity;
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
    point += c.weight[k] * s->x.col(c.node[k]);
    velocity += c.weight[k] * s->v.col(c.node[k]);
  }
  // A scheme whose positions follow the old velocity must see the crossing of the next step in this one.
  const double gap = c.normal.dot(point) - c.offset, ahead = (1.0 - drift) * dt;
  const double normal_velocity = c.normal.dot(velocity);
  if (gap + ahead * normal_velocity >= 0.0 && contact->normal == 0.0) return false;

  if (gap < 0.0) {
    add(c, inverse_mass, Vec3(-gap * contact->mass * c.normal), &s->x);
    contact->pushed -= gap * contact->mass / dt;
  }
  const double allowed = ahead > 0.0 ? -std::max(gap, 0.0) / ahead : 0.0;
  const double impulse = std::max(0.0, contact->normal + contact->mass * (allowed - normal_velocity));
  add(c, inverse_mass, Vec3((impulse - contact->normal) * c.normal), &s->v);
  contact->normal = impulse;

  const Vec3 sliding = velocity - normal_velocity * c.normal;
  Vec3 friction = contact->friction - contact->mass * sliding;
  const double size = friction.norm(), most = c.friction * std::max(contact->normal, contact->pushed);
  if (size > most) friction *= most / size;
  const Vec3 change = friction - contact->friction;
  contact->friction = friction;
  add(c, inverse_mass, change, &s->v);
  add(c, inverse_mass, Vec3(drift * dt * change), &s->x);
  return true;
}

}  // namespace deformable_sim
