#include "deformable_sim/core/contact/body_contacts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "deformable_sim/core/contact/stick.h"

namespace deformable_sim {
namespace {

constexpr double kMostSlack = 0.002;    // m: motion beyond what velocities foretell, at most ...
constexpr double kSlackRate = 10.0;     // m/s^2: ... this times dt^2 ...
constexpr double kLeastSlack = 1e-4;    // m: ... and at least this
constexpr double kSlackShare = 0.25;    // of a node's own motion
constexpr double kExitSpeed = 0.3;      // m/s: what is too near comes apart no faster
constexpr double kPressedShare = 0.6;   // of the distance asked for: nearer ones are not just under load
constexpr double kMayGive = 0.2;        // of the distance asked for, under load
constexpr double kRestShare = 0.9;      // of their distance at rest that neighbours in one body keep
constexpr double kLeastShare = 0.1;     // of the distance asked for: what keep_apart() makes sure of
constexpr double kLeastShareNow = 0.5;  // the same, of the distance at the start of the step
constexpr int kSweeps = 20;
constexpr int kHalvings = 40;   // to place a plane
constexpr int kRounds = 4;      // of sweeps, each over the pairs that the moves of the last one brought near
constexpr double kWider = 1.1;  // than a node went
constexpr double kTiny = 1e-9;  // m: closer pieces have no direction between them

/// Sum of weights times the nodes' columns.
Vec3 mean(const std::array<int, 4>& node, const std::array<double, 4>& weight, size_t count, const Nodes& x) {
  Vec3 sum = Vec3::Zero();
  for (size_t k = 0; k < count; ++k) sum += weight[k] * x.col(node[k]);
  return sum;
}

/// What two contacts of the same place have in common: nodes, and how many are of the first side.
std::array<int, 5> place_of(const ContactConstraint& c) {
  int first = 0;
  while (first < c.count && c.weight[static_cast<size_t>(first)] > 0.0) ++first;
  return {{c.node[0], c.node[1], c.node[2], c.node[3], first}};
}

/// Whether the segment p q and the triangle a b c have a point in common that is inside both.
bool cross(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double sp = normal.dot(p - a), sq = normal.dot(q - a);
  if (sp * sq >= 0.0) return false;
  const Vec3 at = p + sp / (sp - sq) * (q - p);
  return normal.dot((b - a).cross(at - a)) > 0.0 && normal.dot((c - b).cross(at - b)) > 0.0 &&
         normal.dot((a - c).cross(at - c)) > 0.0;
}

}  // namespace

BodyContacts::BodyContacts(const Model* model)
    : model_(model), rest_(model->initial.x), on_surface_(static_cast<size_t>(model->node_count()), 0) {
  for (size_t b = 0; b < model->bodies.size(); ++b) {
    if (model->bodies[b].touches != BodyContact::kNone) add_pieces(static_cast<int>(b));
  }
  std::vector<Vec3> centers;
  for (const Piece& p : pieces_) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < p.count; ++k) sum += model->initial.x.col(p.node[static_cast<size_t>(k)]);
    centers.push_back(sum / p.count);
  }
  tree_ = BoxTree(centers);
  extent_.resize(on_surface_.size());
}

void BodyContacts::add_pieces(int body) {
  const Body& b = model_->bodies[static_cast<size_t>(body)];
  const Nodes* rest = b.line ? &b.line->rest : b.surface ? &b.surface->rest : nullptr;
  if (rest != nullptr && rest->cols() == b.node_count) rest_.middleCols(b.first_node, b.node_count) = *rest;
  if (b.line) {
    for (int s = 0; s < b.line->segment_count(); ++s) {
      const auto [i, j] = b.line->segment(s);
      pieces_.push_back({{{b.first_node + i, b.first_node + j, -1}}, 2, body, 0u, 1u});
    }
  } else if (b.surface) {
    for (const auto& t : b.surface->triangles) {
      pieces_.push_back({{{b.first_node + t[0], b.first_node + t[1], b.first_node + t[2]}}, 3, body, 0u, 0u});
    }
  }
  const auto edges = b.surface && !b.line ? edges_of(*b.surface) : std::vector<std::array<int, 2>>{};
  std::vector<char> owned(edges.size(), 0);
  for (Piece& p : pieces_) {
    if (p.body != body) continue;
    for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
      char& mine = on_surface_[static_cast<size_t>(p.node[k])];
      if (mine == 0) p.own_nodes |= 1u << k;
      mine = 1;
      if (p.count == 2) continue;
      const int i = p.node[k] - b.first_node, j = p.node[(k + 1) % 3] - b.first_node;
      const std::array<int, 2> edge{{std::min(i, j), std::max(i, j)}};
      char& taken = owned[static_cast<size_t>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin())];
      if (taken == 0) p.own_edges |= 1u << k;
      taken = 1;
    }
  }
}

/// How far each node may move: by its velocity, held ones to their targets, and a little more.
void BodyContacts::foresee(const State& s, double dt, const std::vector<int>& held, const Nodes& targets) {
  common_.setZero();
  double count = 0.0;
  for (size_t i = 0; i < extent_.size(); ++i) {
    if (on_surface_[i] == 0) continue;
    extent_[i].motion = dt * s.v.col(static_cast<Eigen::Index>(i));
    common_ += extent_[i].motion;
    count += 1.0;
  }
  common_ /= std::max(1.0, count);
  for (size_t k = 0; k < held.size(); ++k) {
    const int node = held[k];
    extent_[static_cast<size_t>(node)].motion = targets.col(static_cast<Eigen::Index>(k)) - s.x.col(node);
  }
  margin_ = std::max(kLeastSlack, std::min(kMostSlack, kSlackRate * dt * dt));
  for (size_t i = 0; i < extent_.size(); ++i) {
    if (on_surface_[i] != 0) extent_[i].reach = margin_ + kSlackShare * (extent_[i].motion - common_).norm();
  }
}

void BodyContacts::fit_boxes(const Nodes& x) {
  for (int i = 0; i < tree_.piece_count(); ++i) {
    Piece& p = pieces_[static_cast<size_t>(i)];
    BoxTree::Box& box = tree_.box_of(i);
    box.setEmpty();
    p.reach = 0.0;
    const double radius = radius_of(p.body);
    for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
      const Extent& e = extent_[static_cast<size_t>(p.node[k])];
      const double reach = radius + e.reach + (e.motion - common_).norm();
      extend(x.col(p.node[k]), reach, &box);
      p.reach = std::max(p.reach, reach);
    }
  }
  tree_.refit();
}

void BodyContacts::find_pairs(const Nodes& x, std::vector<Touch>* touches) {
  pairs_.clear();
  fit_boxes(x);
  tree_.for_each_pair(
      [&](int i, int j) { test(pieces_[static_cast<size_t>(i)], pieces_[static_cast<size_t>(j)], x, touches); });
}

void BodyContacts::test(const Piece& p, const Piece& q, const Nodes& x, std::vector<Touch>* touches) {
  if (p.body == q.body && model_->bodies[static_cast<size_t>(p.body)].touches != BodyContact::kAll) return;
  if (q.count == 3) test_nodes(p, q, x, touches);
  if (p.count == 3) test_nodes(q, p, x, touches);
  test_edges(p, q, x, touches);
}

void BodyContacts::test_nodes(const Piece& p, const Piece& t, const Nodes& x, std::vector<Touch>* touches) {
  for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
    const int node = p.node[k];
    if ((p.own_nodes >> k & 1u) == 0u || node == t.node[0] || node == t.node[1] || node == t.node[2]) continue;
    keep({{node, t.node[0], t.node[1], t.node[2]}}, 1,
         closest_point_triangle(x.col(node), x.col(t.node[0]), x.col(t.node[1]), x.col(t.node[2])), p, t, touches);
  }
}

void BodyContacts::test_edges(const Piece& p, const Piece& q, const Nodes& x, std::vector<Touch>* touches) {
  for (size_t k = 0; k < 3; ++k) {
    if ((p.own_edges >> k & 1u) == 0u) continue;
    const int a = p.node[k], b = p.node[(k + 1) % static_cast<size_t>(p.count)];
    for (size_t l = 0; l < 3; ++l) {
      if ((q.own_edges >> l & 1u) == 0u) continue;
      const int c = q.node[l], d = q.node[(l + 1) % static_cast<size_t>(q.count)];
      if (a == c || a == d || b == c || b == d) continue;
      keep({{a, b, c, d}}, 2, closest_segment_segment(x.col(a), x.col(b), x.col(c), x.col(d)), p, q, touches);
    }
  }
}

/// Bound of the way that a point of one part may make towards one of the other, m.
double BodyContacts::foreseen_way(const std::array<int, 4>& node, int first) const {
  double motion = 0.0, slack[2] = {0.0, 0.0};
  for (int i = 0; i < 4; ++i) {
    const Extent& e = extent_[static_cast<size_t>(node[static_cast<size_t>(i)])];
    double& most = slack[i < first ? 0 : 1];
    most = std::max(most, e.reach);
    for (int j = first; i < first && j < 4; ++j) {
      const Extent& other = extent_[static_cast<size_t>(node[static_cast<size_t>(j)])];
      motion = std::max(motion, (e.motion - other.motion).squaredNorm());
    }
  }
  return std::sqrt(motion) + slack[0] + slack[1];
}

void BodyContacts::keep(const std::array<int, 4>& node, int first, const ClosestPoints& found, const Piece& p,
                        const Piece& q, std::vector<Touch>* touches) {
  const double furthest = p.reach + q.reach;
  if (found.apart.squaredNorm() > furthest * furthest) return;
  const double asked = radius_of(p.body) + radius_of(q.body);
  const double distance = found.apart.norm();
  if (distance < kTiny || distance > asked + foreseen_way(node, first)) return;
  pairs_.push_back({node, first, found.apart / distance, std::min(kLeastShare * asked, kLeastShareNow * distance)});
  if (touches == nullptr) return;

  Touch touch{{{-1, -1, -1, -1}}, {}, 0, found.apart, p.body, q.body};
  double ahead = distance;
  for (size_t k = 0; k < 4; ++k) {
    if (found.weight[k] == 0.0) continue;
    const auto to = static_cast<size_t>(touch.count++);
    const double sign = static_cast<int>(k) < first ? 1.0 : -1.0;
    touch.node[to] = node[k];
    touch.weight[to] = sign * found.weight[k];
    ahead += touch.weight[to] * found.apart.dot(extent_[static_cast<size_t>(node[k])].motion) / distance;
  }
  if (std::min(distance, ahead) <= asked + 2.0 * margin_) touches->push_back(touch);
}

void BodyContacts::find(const State& s, double dt, const std::vector<int>& held, const Nodes& targets,
                        ContactConstraints* contacts) {
  foresee(s, dt, held, targets);
  touches_.clear();
  find_pairs(s.x, &touches_);
  // The same corner or edge is met by several pieces around it.
  for (Touch& t : touches_) {
    // One order for both ways round: nodes of a side ascending, the side of the smallest node first.
    const auto split = static_cast<size_t>(
        std::find_if(t.weight.begin(), t.weight.begin() + t.count, [](double w) { return w < 0.0; }) -
        t.weight.begin());
    const auto sort_side = [&](size_t from, size_t to) {
      for (size_t i = from + 1; i < to; ++i) {
        for (size_t j = i; j > from && t.node[j] < t.node[j - 1]; --j) {
          std::swap(t.node[j], t.node[j - 1]);
          std::swap(t.weight[j], t.weight[j - 1]);
        }
      }
    };
    const auto count = static_cast<size_t>(t.count);
    sort_side(0, split);
    sort_side(split, count);
    if (t.node[split] < t.node[0]) {
      std::rotate(t.node.begin(), t.node.begin() + static_cast<std::ptrdiff_t>(split), t.node.begin() + t.count);
      std::rotate(t.weight.begin(), t.weight.begin() + static_cast<std::ptrdiff_t>(split), t.weight.begin() + t.count);
      for (size_t k = 0; k < count; ++k) t.weight[k] = -t.weight[k];
      t.apart = -t.apart;
      std::swap(t.body_a, t.body_b);
    }
  }
  const auto key = [](const Touch& t) {
    int first = 0;
    while (first < t.count && t.weight[static_cast<size_t>(first)] > 0.0) ++first;
    return std::pair(t.node, first);
  };
  std::sort(touches_.begin(), touches_.end(), [&](const Touch& a, const Touch& b) { return key(a) < key(b); });
  const auto end =
      std::unique(touches_.begin(), touches_.end(), [&](const Touch& a, const Touch& b) { return key(a) == key(b); });
  touches_.erase(end, touches_.end());
  memory_.rewind();
  for (const Touch& t : touches_) add_constraint(t, dt, contacts);
}

double BodyContacts::rest_distance(const Touch& t) const {
  return mean(t.node, t.weight, static_cast<size_t>(t.count), rest_).norm();
}

void BodyContacts::add_constraint(const Touch& t, double dt, ContactConstraints* contacts) {
  const Body &a = model_->bodies[static_cast<size_t>(t.body_a)], &b = model_->bodies[static_cast<size_t>(t.body_b)];
  double asked = a.contact_radius + b.contact_radius;
  if (t.body_a == t.body_b) asked = std::min(asked, kRestShare * rest_distance(t));
  const double distance = t.apart.norm();
  ContactConstraint c;
  c.node = t.node;
  c.weight = t.weight;
  c.count = t.count;
  c.normal = t.apart / distance;
  // A load may have pressed them together; what began far too near comes apart without a bang.
  c.offset = distance > kPressedShare * asked ? asked : std::min(asked, distance + kExitSpeed * dt);
  c.friction = std::sqrt(a.friction * b.friction);
  const Vec3 stuck = memory_.recall(place_of(c));
  c.stuck = stuck - c.normal.dot(stuck) * c.normal;
  contacts->push_back(c);
}

void BodyContacts::keep_stuck(const ContactConstraints& contacts) {
  for (const ContactConstraint& c : contacts) {
    if (c.collider < 0) memory_.store(place_of(c), c.stuck);
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

double BodyContacts::keep_apart(const Nodes& before, const Eigen::VectorXd& inverse_mass, double dt, State* s) {
  moved_.assign(extent_.size(), 0);
  double worst = 0.0;
  bool known = true;
  for (int round = 0; round < kRounds; ++round) {
    known = !widen(before, s->x);
    if (known && round > 0) break;
    if (!known) find_pairs(before, nullptr);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      worst = 0.0;
      for (const Pair& pair : pairs_) worst = std::max(worst, separate(pair, inverse_mass, &s->x));
      if (worst == 0.0) break;
    }
  }
  for (size_t i = 0; i < moved_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (moved_[i] != 0) s->v.col(k) = (s->x.col(k) - before.col(k)) / dt;
  }
  return known ? worst : std::max(worst, margin_);
}

/// Whether a node went further than was foreseen; then foresees it.
bool BodyContacts::widen(const Nodes& before, const Nodes& x) {
  bool further = false;
  for (size_t i = 0; i < extent_.size(); ++i) {
    if (on_surface_[i] == 0) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const double beyond = (x.col(k) - before.col(k) - extent_[i].motion).norm();
    if (beyond <= extent_[i].reach) continue;
    extent_[i].reach = kWider * beyond;
    further = true;
  }
  return further;
}

/// Moves the parts' nodes past a plane between them, placed so that the moves have no momentum together; held nodes
/// stay where they are. Returns how much was wanting, 0 when nothing.
double BodyContacts::separate(const Pair& pair, const Eigen::VectorXd& inverse_mass, Nodes* x) {
  constexpr double kFar = 1e300;
  std::array<double, 4> at;
  double low = kFar, high = -kFar;            // of the first, of the second part
  double held_low = kFar, held_high = -kFar;  // the same of held nodes
  for (size_t k = 0; k < 4; ++k) {
    at[k] = pair.normal.dot(x->col(pair.node[k]));
    const bool held = inverse_mass[pair.node[k]] == 0.0;
    if (static_cast<int>(k) < pair.first) {
      low = std::min(low, at[k]);
      if (held) held_low = std::min(held_low, at[k]);
    } else {
      high = std::max(high, at[k]);
      if (held) held_high = std::max(held_high, at[k]);
    }
  }
  const double wanting = pair.least - (low - high);
  if (wanting <= 1e-3 * pair.least || held_low - held_high < pair.least) return 0.0;
  const double half = 0.5 * pair.least;
  const auto move = [&](size_t k, double plane) {
    return static_cast<int>(k) < pair.first ? std::max(0.0, plane + half - at[k]) : std::min(0.0, plane - half - at[k]);
  };
  double from = std::max(low - half, held_high + half), to = std::min(high + half, held_low - half);
  for (int k = 0; k < kHalvings && from < to; ++k) {
    const double middle = 0.5 * (from + to);
    double momentum = 0.0;
    for (size_t i = 0; i < 4; ++i) {
      if (inverse_mass[pair.node[i]] > 0.0) momentum += move(i, middle) / inverse_mass[pair.node[i]];
    }
    (momentum < 0.0 ? from : to) = middle;
  }
  const double plane = 0.5 * (from + to);
  for (size_t k = 0; k < 4; ++k) {
    const double way = move(k, plane);
    if (way == 0.0 || inverse_mass[pair.node[k]] == 0.0) continue;
    x->col(pair.node[k]) += way * pair.normal;
    moved_[static_cast<size_t>(pair.node[k])] = 1;
  }
  return wanting;
}

std::string BodyContacts::find_crossing(const Nodes& x) {
  for (Extent& e : extent_) e = {0.0, Vec3::Zero()};
  common_.setZero();
  fit_boxes(x);
  std::string found;
  tree_.for_each_pair([&](int i, int j) {
    const Piece &one = pieces_[static_cast<size_t>(i)], &other = pieces_[static_cast<size_t>(j)];
    if (!found.empty()) return;
    if (one.body == other.body && model_->bodies[static_cast<size_t>(one.body)].touches != BodyContact::kAll) return;
    const auto crosses = [&](const Piece& p, const Piece& t) {
      if (t.count != 3) return false;
      for (size_t k = 0; k < 3; ++k) {
        if ((p.own_edges >> k & 1u) == 0u) continue;
        const int a = p.node[k], b = p.node[(k + 1) % static_cast<size_t>(p.count)];
        const auto mine = [&](int node) { return node == t.node[0] || node == t.node[1] || node == t.node[2]; };
        if (!mine(a) && !mine(b) && cross(x.col(a), x.col(b), x.col(t.node[0]), x.col(t.node[1]), x.col(t.node[2]))) {
          return true;
        }
      }
      return false;
    };
    if (!crosses(one, other) && !crosses(other, one)) return;
    const Vec3 at = x.col(one.node[0]);
    const auto [first, second] = std::minmax(one.body, other.body);
    const std::string &a = model_->bodies[static_cast<size_t>(first)].name,
                      &b = model_->bodies[static_cast<size_t>(second)].name;
    char place[80];
    std::snprintf(place, sizeof place, " near (%.3g, %.3g, %.3g) m", at[0], at[1], at[2]);
    found = (one.body == other.body ? "'" + a + "' crosses itself" : "'" + a + "' and '" + b + "' cross") + place;
  });
  return found;
}

}  // namespace deformable_sim
