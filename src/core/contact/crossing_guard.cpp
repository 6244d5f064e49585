#include "deformable_sim/core/contact/crossing_guard.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace deformable_sim {
namespace {

constexpr double kLeastShare = 0.1;     // of the distance asked for: what keep_apart() makes sure of
constexpr double kLeastShareNow = 0.5;  // the same, of the distance at the start of the step
constexpr double kNarrow = 1e-6;        // m: what is nearer comes no nearer, but a little apart again
constexpr double kApart = 1.01;         // times the distance at the start, then
constexpr double kEnough = 0.999;       // of it
constexpr int kSweeps = 20;
constexpr int kHalvings = 40;   // to place a plane
constexpr int kRounds = 4;      // of sweeps, each over the pairs that the moves of the last one brought near as well
constexpr double kTiny = 1e-9;  // m: closer pieces have no direction between them

/// Whether the segment p q and the triangle a b c have a point in common that is inside both.
bool cross(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double sp = normal.dot(p - a), sq = normal.dot(q - a);
  if (sp * sq >= 0.0) return false;
  const Vec3 at = p + sp / (sp - sq) * (q - p);
  return normal.dot((b - a).cross(at - a)) > 0.0 && normal.dot((c - b).cross(at - b)) > 0.0 &&
         normal.dot((a - c).cross(at - c)) > 0.0;
}

/// Whether an edge of p's own crosses the triangle t.
bool edge_crosses(const Piece& p, const Piece& t, const Nodes& x) {
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
}

}  // namespace

double CrossingGuard::keep_apart(const Nodes& before, const Eigen::VectorXd& inverse_mass, double dt, State* s) {
  pairs_.clear();
  double worst = find_failing(before, s->x, inverse_mass);
  if (worst == 0.0) return 0.0;
  moved_.assign(static_cast<size_t>(s->x.cols()), 0);
  for (int round = 0; round < kRounds && worst > 0.0; ++round) {
    for (int sweep = 0; sweep < kSweeps && worst > 0.0; ++sweep) {
      worst = 0.0;
      for (const Pair& pair : pairs_) worst = std::max(worst, separate(pair, inverse_mass, &s->x));
    }
    if (worst == 0.0) worst = find_failing(before, s->x, inverse_mass);
  }
  for (size_t i = 0; i < moved_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (moved_[i] != 0) s->v.col(k) = (s->x.col(k) - before.col(k)) / dt;
  }
  return worst;
}

/// Appends to pairs_ what no plane separates; returns by how much the worst is wanting, m.
double CrossingGuard::find_failing(const Nodes& before, const Nodes& x, const Eigen::VectorXd& inverse_mass) {
  double worst = 0.0;
  pieces_->for_each_meeting({before, x, {0.0, 0.0}, {kLeastShare, 0.0}}, [&](const Meeting& m) {
    const ClosestPoints start = closest_points(m, before);
    const double distance = start.apart.norm();
    if (distance < kTiny) return;
    const double asked = pieces_->radius_of(m.a->body) + pieces_->radius_of(m.b->body);
    const double kept = std::max(kLeastShareNow * distance, std::min(kApart * distance, kNarrow));
    const Pair pair{m, start.apart / distance, std::min(kLeastShare * asked, kept)};
    const double gap = gap_along(pair.normal, m, x);
    if (gap >= kEnough * pair.least) return;
    bool free = false;
    for (size_t k = 0; k < 4; ++k) free = free || inverse_mass[m.node[k]] > 0.0;
    if (!free) return;
    const ClosestPoints end = closest_points(m, x);
    const double distance_then = end.apart.norm();
    if (distance_then >= pair.least && gap_along(end.apart / distance_then, m, before) > kTiny) {
      return;
    }
    worst = std::max(worst, pair.least - gap);
    pairs_.push_back(pair);
  });
  return worst;
}

/// Moves the parts' nodes past a plane between them, placed so that the moves have no momentum together; held nodes
/// stay where they are. Returns how much was wanting, 0 when nothing.
double CrossingGuard::separate(const Pair& pair, const Eigen::VectorXd& inverse_mass, Nodes* x) {
  constexpr double kFar = 1e300;
  std::array<double, 4> at;
  double low = kFar, high = -kFar;            // of the first, of the second part
  double held_low = kFar, held_high = -kFar;  // the same of held nodes
  for (size_t k = 0; k < 4; ++k) {
    at[k] = pair.normal.dot(x->col(pair.parts.node[k]));
    const bool held = inverse_mass[pair.parts.node[k]] == 0.0;
    if (static_cast<int>(k) < pair.parts.first) {
      low = std::min(low, at[k]);
      if (held) held_low = std::min(held_low, at[k]);
    } else {
      high = std::max(high, at[k]);
      if (held) held_high = std::max(held_high, at[k]);
    }
  }
  const double wanting = pair.least - (low - high);
  if (wanting <= (1.0 - kEnough) * pair.least || held_low - held_high < pair.least) return 0.0;
  const double half = 0.5 * pair.least;
  const auto move = [&](size_t k, double plane) {
    return static_cast<int>(k) < pair.parts.first ? std::max(0.0, plane + half - at[k])
                                                  : std::min(0.0, plane - half - at[k]);
  };
  double from = std::max(low - half, held_high + half), to = std::min(high + half, held_low - half);
  for (int k = 0; k < kHalvings && from < to; ++k) {
    const double middle = 0.5 * (from + to);
    double momentum = 0.0;
    for (size_t i = 0; i < 4; ++i) {
      if (inverse_mass[pair.parts.node[i]] > 0.0) momentum += move(i, middle) / inverse_mass[pair.parts.node[i]];
    }
    (momentum < 0.0 ? from : to) = middle;
  }
  const double plane = 0.5 * (from + to);
  for (size_t k = 0; k < 4; ++k) {
    const double way = move(k, plane);
    if (way == 0.0 || inverse_mass[pair.parts.node[k]] == 0.0) continue;
    x->col(pair.parts.node[k]) += way * pair.normal;
    moved_[static_cast<size_t>(pair.parts.node[k])] = 1;
  }
  return wanting;
}

std::string CrossingGuard::find_crossing(const Nodes& x) {
  std::string found;
  const auto name = [&](const Piece& one, const Piece& other, const char* alone, const char* two) {
    const Vec3 at = x.col(one.node[0]);
    const auto [first, second] = std::minmax(one.body, other.body);
    const std::string &a = model_->bodies[static_cast<size_t>(first)].name,
                      &b = model_->bodies[static_cast<size_t>(second)].name;
    char place[80];
    std::snprintf(place, sizeof place, " near (%.3g, %.3g, %.3g) m", at[0], at[1], at[2]);
    found = (first == second ? "'" + a + "' " + alone : "'" + a + "' and '" + b + "' " + two) + place;
  };
  const SurfacePieces::Step still{x, x, {0.0, 0.0}, {0.0, 0.0}};
  pieces_->for_each_pair(still, [&](const Piece& one, const Piece& other) {
    if (found.empty() && (edge_crosses(one, other, x) || edge_crosses(other, one, x))) {
      name(one, other, "crosses itself", "cross");
    }
  });
  if (!found.empty()) return found;
  pieces_->for_each_meeting(still, [&](const Meeting& m) {
    if (found.empty() && closest_points(m, x).apart.norm() < kTiny) {
      name(*m.a, *m.b, "touches itself at no distance", "are in one place");
    }
  });
  return found;
}

}  // namespace deformable_sim
