#include "deformable_sim/core/integrator/penalty_contacts.h"

#include <algorithm>

namespace deformable_sim {
namespace {

constexpr double kStiffness = 1000.0;  // of a contact, in units of its inertia m / dt^2
constexpr double kCreep = 5e-5;        // m/s: sticking contacts creep no faster, whatever they carry

}  // namespace

void PenaltyContacts::begin(double dt, const State& start, const Nodes& guess, const Eigen::VectorXd& inverse_mass,
                            const ContactConstraints& constraints) {
  dt_ = dt;
  contacts_.clear();
  for (const ContactConstraint& plane : constraints) {
    Contact c;
    c.plane = plane;
    Vec3 before = Vec3::Zero(), expected = Vec3::Zero();
    double compliance = 0.0;
    for (size_t k = 0; k < static_cast<size_t>(plane.count); ++k) {
      const int node = plane.node[k];
      const double weight = plane.weight[k];
      const bool held = inverse_mass[node] == 0.0;
      before += weight * start.x.col(node);
      expected += weight * (held ? Vec3(guess.col(node)) : Vec3(start.x.col(node) + dt * start.v.col(node)));
      compliance += weight * weight * inverse_mass[node];
    }
    if (compliance > 0.0) {
      c.inertia = 1.0 / compliance;
      c.stiffness = kStiffness * c.inertia / (dt * dt);
      c.reference = before + dt * plane.surface_velocity;
      const Vec3 now = point(c, guess);
      const double gap_now = plane.normal.dot(now) - plane.offset;
      const double gap_expected = plane.normal.dot(expected) - plane.offset;
      c.normal_force = std::max(0.0, -c.stiffness * gap_now);
      if (gap_now < 0.0 || gap_expected < 0.0) {
        c.mode = Mode::kStick;
        const Vec3 sliding = expected - c.reference;
        set_friction_mode(sliding - plane.normal.dot(sliding) * plane.normal, &c);
      }
    }
    contacts_.push_back(c);
  }
}

void PenaltyContacts::update(const Nodes& x, Update what) {
  for (Contact& c : contacts_) {
    if (c.inertia == 0.0) continue;
    const Vec3 p = point(c, x);
    const double normal_force = std::max(0.0, -c.stiffness * (c.plane.normal.dot(p) - c.plane.offset));
    if (normal_force == 0.0) {
      c.mode = Mode::kOpen;
      c.normal_force = 0.0;
      continue;
    }
    if (what == Update::kAll || c.normal_force == 0.0) c.normal_force = normal_force;
    const Vec3 sliding = p - c.reference;
    set_friction_mode(sliding - c.plane.normal.dot(sliding) * c.plane.normal, &c);
  }
}

/// Sticks while k |u| <= mu lambda, u the distance slid in this step; a contact whose sliding has turned round sticks.
void PenaltyContacts::set_friction_mode(const Vec3& sliding, Contact* c) const {
  const double most = c->plane.friction * c->normal_force;
  c->stick_stiffness = std::max(c->stiffness, most / (kCreep * dt_));
  const double slid = sliding.norm();
  const bool turned = c->mode == Mode::kSlide && sliding.dot(c->direction) < 0.0;
  if (turned || slid == 0.0 || c->stick_stiffness * slid <= most) {
    c->mode = Mode::kStick;
    return;
  }
  c->mode = Mode::kSlide;
  c->direction = sliding / slid;
  c->slid = slid;
}

Vec3 PenaltyContacts::point(const Contact& c, const Nodes& x) const {
  Vec3 p = Vec3::Zero();
  for (size_t k = 0; k < static_cast<size_t>(c.plane.count); ++k) p += c.plane.weight[k] * x.col(c.plane.node[k]);
  return p;
}

Vec3 PenaltyContacts::force(const Contact& c, const Vec3& p) const {
  if (c.mode == Mode::kOpen) return Vec3::Zero();
  const Vec3& n = c.plane.normal;
  const Vec3 normal = -c.stiffness * (n.dot(p) - c.plane.offset) * n;
  if (c.plane.friction == 0.0) return normal;
  Vec3 sliding = p - c.reference;
  sliding -= n.dot(sliding) * n;
  if (c.mode == Mode::kStick) return normal - c.stick_stiffness * sliding;
  // The direction may turn within the Newton step, as in jacobian(); its change along itself is of second order.
  const Vec3 across = sliding - c.direction.dot(sliding) * c.direction;
  return normal - c.plane.friction * c.normal_force * (c.direction + across / c.slid);
}

Mat3 PenaltyContacts::jacobian(const Contact& c) const {
  const Vec3& n = c.plane.normal;
  const Mat3 normal = n * n.transpose();
  Mat3 h = c.stiffness * normal;
  if (c.plane.friction == 0.0) return h;
  const Mat3 tangent = Mat3::Identity() - normal;
  if (c.mode == Mode::kStick) {
    h += c.stick_stiffness * tangent;
  } else {
    h += (c.plane.friction * c.normal_force / c.slid) * (tangent - c.direction * c.direction.transpose());
  }
  return h;
}

void PenaltyContacts::add_force(const Nodes& x, Nodes* f) const {
  for (const Contact& c : contacts_) {
    if (c.mode == Mode::kOpen) continue;
    const Vec3 force_at_point = force(c, point(c, x));
    for (size_t k = 0; k < static_cast<size_t>(c.plane.count); ++k) {
      f->col(c.plane.node[k]) += c.plane.weight[k] * force_at_point;
    }
  }
}

void PenaltyContacts::add_jacobian(BlockMatrix* a) const {
  for (const Contact& c : contacts_) {
    if (c.mode == Mode::kOpen) continue;
    const Mat3 h = jacobian(c);
    for (size_t i = 0; i < static_cast<size_t>(c.plane.count); ++i) {
      for (size_t j = 0; j < static_cast<size_t>(c.plane.count); ++j) {
        const int slot = a->slot(c.plane.node[i], c.plane.node[j]);
        a->block(slot) += c.plane.weight[i] * c.plane.weight[j] * h;
      }
    }
  }
}

void PenaltyContacts::report(const Nodes& x, ContactConstraints* constraints) const {
  for (size_t k = 0; k < contacts_.size(); ++k) {
    (*constraints)[k].force = force(contacts_[k], point(contacts_[k], x));
  }
}

}  // namespace deformable_sim
