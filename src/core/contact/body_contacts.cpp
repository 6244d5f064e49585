#include "deformable_sim/core/contact/body_contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "deformable_sim/core/contact/stick.h"

namespace deformable_sim {
namespace {

constexpr double kMostSlack = 0.001;   // m: motion beyond what velocities foretell, at most ...
constexpr double kSlackRate = 5.0;     // m/s^2: ... this times dt^2 ...
constexpr double kLeastSlack = 1e-4;   // m: ... and at least this
constexpr double kExitSpeed = 0.3;     // m/s: what is too near comes apart no faster
constexpr double kPressedShare = 0.6;  // of the distance asked for: nearer ones are not just under load
constexpr double kMayGive = 0.2;       // of the distance asked for, under load
constexpr double kRestShare = 0.9;     // of their distance at rest that neighbours in one body keep
constexpr double kMostTravel = 0.25;   // of an edge, that what touches moves on what it touches in a part of a step ...
constexpr double kMostParts = 4.0;     // ... of which there are as many at most
constexpr double kTiny = 1e-9;         // m: closer pieces have no direction between them

/// Sum of weights times the nodes' columns.
Vec3 mean(const std::array<int, 4>& node, const std::array<double, 4>& weight, size_t count, const Nodes& x) {
  Vec3 sum = Vec3::Zero();
  for (size_t k = 0; k < count; ++k) sum += weight[k] * x.col(node[k]);
  return sum;
}

/// How many of the nodes are of the first side: those of weight above 0.
template <class Contact>
int first_side(const Contact& c) {
  int first = 0;
  while (first < c.count && c.weight[static_cast<size_t>(first)] > 0.0) ++first;
  return first;
}

}  // namespace

BodyContacts::BodyContacts(const Model* model)
    : model_(model), rest_(model->initial.x), pieces_(model), guard_(model, &pieces_), foreseen_(model->initial.x) {
  for (const Body& b : model->bodies) {
    double sum = 0.0;
    for (const StrainEdge& e : b.strain_edges) sum += e.rest_length;
    size_.push_back(sum / std::max<double>(1.0, static_cast<double>(b.strain_edges.size())));
    const Nodes* rest = b.line ? &b.line->rest : b.surface ? &b.surface->rest : nullptr;
    if (rest != nullptr && rest->cols() == b.node_count) rest_.middleCols(b.first_node, b.node_count) = *rest;
  }
}

/// Where each node gets by its velocity, held ones to their targets.
void BodyContacts::foresee(const State& s, double dt, const std::vector<int>& held, const Nodes& targets) {
  foreseen_ = s.x + dt * s.v;
  for (size_t k = 0; k < held.size(); ++k) foreseen_.col(held[k]) = targets.col(static_cast<Eigen::Index>(k));
  margin_ = std::max(kLeastSlack, std::min(kMostSlack, kSlackRate * dt * dt));
}

void BodyContacts::add_touch(const Meeting& m, const Nodes& x) {
  const ClosestPoints found = closest_points(m, x);
  const double distance = found.apart.norm();
  if (distance < kTiny) return;
  const double asked = pieces_.radius_of(m.a->body) + pieces_.radius_of(m.b->body);
  if (std::min(distance, ahead(m, found, distance)) > asked + 2.0 * margin_) return;
  Touch touch{{{-1, -1, -1, -1}}, {}, 0, found.apart / distance, distance, m.a->body, m.b->body};
  for (size_t k = 0; k < 4; ++k) {
    if (found.weight[k] == 0.0) continue;
    const auto to = static_cast<size_t>(touch.count++);
    touch.node[to] = m.node[k];
    touch.weight[to] = static_cast<int>(k) < m.first ? found.weight[k] : -found.weight[k];
  }
  touches_.push_back(touch);
}

/// Foreseen distance along the shortest connection of now, m.
double BodyContacts::ahead(const Meeting& m, const ClosestPoints& now, double distance) const {
  Vec3 apart = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<size_t>(k);
    apart += (k < m.first ? now.weight[i] : -now.weight[i]) * foreseen_.col(m.node[i]);
  }
  return now.apart.dot(apart) / distance;
}

/// One order for both ways round: nodes of a side ascending, the side of the smallest node first.
void BodyContacts::sort_sides(Touch* t) {
  const auto split = static_cast<size_t>(first_side(*t)), count = static_cast<size_t>(t->count);
  const auto sort_side = [t](size_t from, size_t to) {
    for (size_t i = from + 1; i < to; ++i) {
      for (size_t j = i; j > from && t->node[j] < t->node[j - 1]; --j) {
        std::swap(t->node[j], t->node[j - 1]);
        std::swap(t->weight[j], t->weight[j - 1]);
      }
    }
  };
  sort_side(0, split);
  sort_side(split, count);
  if (t->node[0] < t->node[split]) return;
  std::rotate(t->node.begin(), t->node.begin() + static_cast<std::ptrdiff_t>(split), t->node.begin() + t->count);
  std::rotate(t->weight.begin(), t->weight.begin() + static_cast<std::ptrdiff_t>(split), t->weight.begin() + t->count);
  for (size_t k = 0; k < count; ++k) t->weight[k] = -t->weight[k];
  t->normal = -t->normal;
  std::swap(t->body_a, t->body_b);
}

void BodyContacts::find(const State& s, double dt, const std::vector<int>& held, const Nodes& targets,
                        ContactConstraints* contacts) {
  foresee(s, dt, held, targets);
  touches_.clear();
  const SurfacePieces::Reach near{1.0, 2.0 * margin_};
  pieces_.for_each_meeting({s.x, foreseen_, near, near}, [&](const Meeting& m) { add_touch(m, s.x); });
  // The same corner or edge is met by several pieces around it: in order of places, one each.
  order_.clear();
  for (Touch& t : touches_) {
    sort_sides(&t);
    order_.push_back({ContactPlace(t.node, first_side(t)), static_cast<int>(order_.size())});
  }
  std::sort(order_.begin(), order_.end());
  const auto same = [](const Ordered& a, const Ordered& b) { return a.place == b.place; };
  order_.erase(std::unique(order_.begin(), order_.end(), same), order_.end());
  memory_.rewind();
  double rates = 0.0;
  for (const Ordered& o : order_) {
    const Touch& t = touches_[static_cast<size_t>(o.touch)];
    add_constraint(t, o.place, dt, contacts);
    const double size = std::min(size_[static_cast<size_t>(t.body_a)], size_[static_cast<size_t>(t.body_b)]);
    rates += mean(t.node, t.weight, static_cast<size_t>(t.count), s.v).squaredNorm() / (size * size);
  }
  rate_ = order_.empty() ? 0.0 : std::sqrt(rates / static_cast<double>(order_.size()));
}

int BodyContacts::parts_for(double dt) const {
  return static_cast<int>(std::clamp(std::ceil(dt * rate_ / kMostTravel), 1.0, kMostParts));
}

double BodyContacts::rest_distance(const Touch& t) const {
  return mean(t.node, t.weight, static_cast<size_t>(t.count), rest_).norm();
}

void BodyContacts::add_constraint(const Touch& t, const ContactPlace& place, double dt, ContactConstraints* contacts) {
  const Body &a = model_->bodies[static_cast<size_t>(t.body_a)], &b = model_->bodies[static_cast<size_t>(t.body_b)];
  double asked = a.contact_radius + b.contact_radius;
  if (t.body_a == t.body_b) asked = std::min(asked, kRestShare * rest_distance(t));
  ContactConstraint c;
  c.node = t.node;
  c.weight = t.weight;
  c.count = t.count;
  c.normal = t.normal;
  // A load may have pressed them together; what began far too near comes apart without a bang.
  c.offset = t.distance > kPressedShare * asked ? asked : std::min(asked, t.distance + kExitSpeed * dt);
  c.friction = std::sqrt(a.friction * b.friction);
  const Vec3 stuck = memory_.recall(place);
  c.stuck = stuck - c.normal.dot(stuck) * c.normal;
  contacts->push_back(c);
}

void BodyContacts::keep_stuck(const ContactConstraints& contacts) {
  for (const ContactConstraint& c : contacts) {
    if (c.collider < 0) memory_.store(ContactPlace(c.node, first_side(c)), c.stuck);
  }
  memory_.end_part();
}

double BodyContacts::violation(const Nodes& before, const Nodes& x, const ContactConstraints& contacts) {
  double worst = 0.0;
  for (const ContactConstraint& c : contacts) {
    if (c.collider >= 0) continue;
    const double gap = c.normal.dot(contact_position(c, x));
    if (gap < c.normal.dot(contact_position(c, before))) {
      worst = std::max(worst, (1.0 - kMayGive) * c.offset - gap);
    }
  }
  return worst;
}

}  // namespace deformable_sim
