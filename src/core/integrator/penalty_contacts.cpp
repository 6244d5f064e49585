#include "deformable_sim/core/integrator/penalty_contacts.h"

#include <algorithm>

namespace deformable_sim {
namespace {

constexpr double kStiffness = 100.0;  // of a contact, in units of its inertia m / dt^2
constexpr int kPushes = 4;            // sweeps of push_out()

}  // namespace

void PenaltyContacts::begin(const Span& span, const Nodes& start, const Nodes& x, const Eigen::VectorXd& inverse_mass,
                            const ContactConstraints& constraints) {
  unit_ = span.unit;
  contacts_.clear();
  for (const ContactConstraint& plane : constraints) {
    Contact c;
    c.plane = plane;
    if (span.remaining > 0.0) c.plane.offset -= span.remaining * plane.normal.dot(plane.surface_velocity);
    double compliance = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(plane.count); ++k) {
      compliance += plane.weight[k] * plane.weight[k] * inverse_mass[plane.node[k]];
    }
    if (compliance > 0.0) c.stiffness = kStiffness / (compliance * unit_ * unit_);
    c.reference = point(c, start) + span.duration * plane.surface_velocity - plane.stuck;
    c.normal_force = std::max(0.0, -c.stiffness * gap(c, point(c, x)));
    contacts_.push_back(c);
  }
}

void PenaltyContacts::add_resting_force(Nodes* f) const {
  for (const Contact& c : contacts_) {
    const Vec3 at_point = c.normal_force * (c.plane.normal - c.plane.friction / kStickGive * c.plane.stuck);
    for (size_t k = 0; k < static_cast<size_t>(c.plane.count); ++k) {
      f->col(c.plane.node[k]) += c.plane.weight[k] * at_point;
    }
  }
}

void PenaltyContacts::update_normal_forces(const Nodes& x) {
  for (Contact& c : contacts_) c.normal_force = std::max(0.0, -c.stiffness * gap(c, point(c, x)));
}

bool PenaltyContacts::any_deeper(double depth, const Nodes& x) const {
  return std::any_of(contacts_.begin(), contacts_.end(),
                     [&](const Contact& c) { return c.stiffness > 0.0 && gap(c, point(c, x)) < -depth; });
}

void PenaltyContacts::push_out(double depth, const Eigen::VectorXd& inverse_mass, Nodes* x) const {
  for (int pass = 0; pass < kPushes; ++pass) {
    for (const Contact& c : contacts_) {
      if (c.stiffness == 0.0) continue;
      const double excess = -depth - gap(c, point(c, *x));
      if (excess <= 0.0) continue;
      const double per_compliance = excess * c.stiffness * unit_ * unit_ / kStiffness;
      for (size_t k = 0; k < static_cast<size_t>(c.plane.count); ++k) {
        const int node = c.plane.node[k];
        x->col(node) += per_compliance * c.plane.weight[k] * inverse_mass[node] * c.plane.normal;
      }
    }
  }
}

Vec3 PenaltyContacts::sliding(const Contact& c, const Vec3& p) {
  const Vec3 moved = p - c.reference;
  return moved - c.plane.normal.dot(moved) * c.plane.normal;
}

Vec3 PenaltyContacts::force(const Contact& c, const Vec3& p) const {
  const double g = gap(c, p);
  if (g >= 0.0 || c.stiffness == 0.0) return Vec3::Zero();
  const Vec3 normal = (-c.stiffness * g) * c.plane.normal;
  const double most = c.plane.friction * c.normal_force;
  if (most == 0.0) return normal;
  const Vec3 u = sliding(c, p);
  return normal - (most / std::max(u.norm(), kStickGive)) * u;
}

Mat3 PenaltyContacts::jacobian(Contact* c, const Vec3& p) const {
  const Vec3& n = c->plane.normal;
  const Mat3 normal = n * n.transpose();
  Mat3 h = c->stiffness * normal;
  const double most = c->plane.friction * c->normal_force;
  if (most == 0.0) return h;
  const Vec3 u = sliding(*c, p);
  if (u.dot(c->sliding) < 0.0) c->cautious = ++c->turns;
  c->sliding = u;
  const double slid = u.norm();
  const Mat3 tangent = Mat3::Identity() - normal;
  if (slid <= kStickGive) {
    h += (most / kStickGive) * tangent;
  } else if (c->cautious > 0) {
    --c->cautious;
    h += (most / slid) * tangent;  // bounds the potential from above: cannot jump back and forth over u = 0
  } else {
    h += (most / slid) * (tangent - u * u.transpose() / (slid * slid));
  }
  return h;
}

void PenaltyContacts::add_force(const Nodes& x, Nodes* f) const {
  for (const Contact& c : contacts_) {
    const Vec3 at_point = force(c, point(c, x));
    for (size_t k = 0; k < static_cast<size_t>(c.plane.count); ++k) {
      f->col(c.plane.node[k]) += c.plane.weight[k] * at_point;
    }
  }
}

void PenaltyContacts::add_jacobian(const Nodes& x, const Eigen::VectorXd& inverse_mass, BlockMatrix* a,
                                   NodeCouplings* couplings) {
  couplings->clear();
  for_each_jacobian(x, [&](const ContactConstraint& c, const Mat3& h) {
    if (c.collider < 0 && c.count > 1) {
      NodeCouplings::Coupling coupling{c.node, c.weight, c.count, h};
      for (size_t i = 0; i < static_cast<size_t>(c.count); ++i) {
        if (inverse_mass[c.node[i]] == 0.0) coupling.weight[i] = 0.0;
        a->block(a->diagonal_slot(c.node[i])) += coupling.weight[i] * coupling.weight[i] * h;
      }
      couplings->add(coupling);
      return;
    }
    for (size_t i = 0; i < static_cast<size_t>(c.count); ++i) {
      for (size_t j = 0; j < static_cast<size_t>(c.count); ++j) {
        a->block(a->slot(c.node[i], c.node[j])) += c.weight[i] * c.weight[j] * h;
      }
    }
  });
}

void PenaltyContacts::report(const Nodes& x, ContactConstraints* constraints) const {
  for (size_t k = 0; k < contacts_.size(); ++k) {
    const Contact& c = contacts_[k];
    const Vec3 p = point(c, x);
    ContactConstraint& plane = (*constraints)[k];
    plane.force = force(c, p);
    plane.stuck = gap(c, p) < 0.0 ? stick_remainder(c.plane, p - c.reference) : Vec3::Zero();
  }
}

}  // namespace deformable_sim
