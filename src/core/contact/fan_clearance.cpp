#include "deformable_sim/core/contact/fan_clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {
namespace {

constexpr int kRetry = 8;           // looks after which what was in vain is found anew
constexpr float kRounding = 1e-5f;  // of what single precision makes of edges and distances

Eigen::Vector3f edge(const Nodes& x, int from, int to) {
  return (x.col(to) - x.col(from)).cast<float>();
}

/// Distance of the nearest two vertices and triangles, or edges, without common nodes, m.
double distance(const Piece& p, const Piece& q, const Nodes& x) {
  double least = std::numeric_limits<double>::max();
  const auto has = [](const Piece& piece, int node) {
    return node == piece.node[0] || node == piece.node[1] || node == piece.node[2];
  };
  const auto look = [&](const Meeting& m) { least = std::min(least, closest_points(m, x).apart.norm()); };
  for (size_t k = 0; k < 3; ++k) {
    if (!has(q, p.node[k])) look({{{p.node[k], q.node[0], q.node[1], q.node[2]}}, 1, &p, &q});
    if (!has(p, q.node[k])) look({{{q.node[k], p.node[0], p.node[1], p.node[2]}}, 1, &q, &p});
    const int a = p.node[k], b = p.node[(k + 1) % 3];
    for (size_t l = 0; l < 3; ++l) {
      const int c = q.node[l], d = q.node[(l + 1) % 3];
      if (a != c && a != d && b != c && b != d) look({{{a, b, c, d}}, 2, &p, &q});
    }
  }
  return least;
}

}  // namespace

FanClearance::FanClearance(int nodes, const std::vector<Piece>& pieces) : free_(static_cast<size_t>(nodes), 0) {
  std::vector<std::vector<const Piece*>> around(static_cast<size_t>(nodes));
  for (const Piece& p : pieces) {
    if (p.count < 3) continue;
    for (const int node : p.node) around[static_cast<size_t>(node)].push_back(&p);
  }
  for (int node = 0; node < nodes; ++node) {
    const std::vector<const Piece*>& mine = around[static_cast<size_t>(node)];
    if (mine.size() < 2) continue;
    Fan fan;
    fan.node = node;
    fan.body = mine[0]->body;
    fan.first_piece = piece_.size();
    fan.pieces = mine.size();
    fan.first_edge = neighbour_.size();
    piece_.insert(piece_.end(), mine.begin(), mine.end());
    for (const Piece* p : mine) {
      for (const int other : p->node) {
        const auto first = neighbour_.begin() + static_cast<std::ptrdiff_t>(fan.first_edge);
        if (other != node && std::find(first, neighbour_.end(), other) == neighbour_.end()) neighbour_.push_back(other);
      }
    }
    fan.edges = neighbour_.size() - fan.first_edge;
    fans_.push_back(fan);
  }
  edge_.resize(neighbour_.size());
  forget();
}

void FanClearance::forget() {
  for (Fan& fan : fans_) {
    fan.clearance = -1.0f;
    fan.retry = fan.node % kRetry;  // not all in one step
  }
}

/// m of the class comment.
float FanClearance::moved(const Fan& fan, const Nodes& x) const {
  float most = 0.0f;
  for (size_t k = fan.first_edge; k < fan.first_edge + fan.edges; ++k) {
    most = std::max(most, (edge(x, fan.node, neighbour_[k]) - edge_[k]).squaredNorm());
  }
  return std::sqrt(most);
}

void FanClearance::measure(const Nodes& x, Fan* fan) {
  double least = std::numeric_limits<double>::max();
  for (size_t i = 0; i < fan->pieces; ++i) {
    for (size_t j = 0; j < i; ++j) {
      least = std::min(least, distance(*piece_[fan->first_piece + i], *piece_[fan->first_piece + j], x));
    }
  }
  fan->clearance = static_cast<float>(least);
  for (size_t k = fan->first_edge; k < fan->first_edge + fan->edges; ++k) edge_[k] = edge(x, fan->node, neighbour_[k]);
}

void FanClearance::find_free(const Nodes& x, const Nodes& end, const std::vector<double>& asked) {
  for (Fan& fan : fans_) {
    const auto least = static_cast<float>(asked[static_cast<size_t>(fan.body)]);
    const auto keeps = [&](const Nodes& at) {
      return (1.0f - kRounding) * fan.clearance - 2.0f * moved(fan, at) > least;
    };
    const auto keeps_both = [&] { return fan.clearance > least && keeps(x) && keeps(end); };
    bool free = keeps_both();
    if (!free && --fan.retry < 0) {
      fan.retry = kRetry;
      measure(x, &fan);
      free = keeps_both();
    }
    free_[static_cast<size_t>(fan.node)] = free ? 1 : 0;
  }
}

}  // namespace deformable_sim
