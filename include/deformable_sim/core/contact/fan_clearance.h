// How far apart the triangles around a vertex keep: most of a sheet need not look at its own neighbours at all.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/meeting.h"

namespace deformable_sim {

/// Triangles that share a vertex v are always close, and hardly ever meet. For each v the distance c of the nearest two
/// of their vertices, triangles and edges without common nodes is found once, at edge vectors e_i = x_i - x_v, and then
/// bounded: no point of the fan has moved further against another than twice
///
///   m = max_i |e_i(now) - e_i(then)|,
///
/// so that all keep c - 2 m. Where that is no longer enough, c is found anew.
///
/// Not good at: triangles smaller than what they are asked to keep apart, and fans that are folded: those are tested
/// one by one as strangers are. Fast rotation wears the bound out within a few steps.
class FanClearance {
 public:
  FanClearance() = default;
  /// Keeps pointers to the pieces.
  FanClearance(int nodes, const std::vector<Piece>& pieces);

  /// Whoever shares a vertex that is free here need not be tested: while nodes go evenly from x to `end` (3 x nodes, m)
  /// they keep more than `asked` (m, by body) apart, for the length of a change that grows evenly is nowhere larger
  /// than at its ends. Finds some of the distances anew.
  void find_free(const Nodes& x, const Nodes& end, const std::vector<double>& asked);
  /// Finds them all anew.
  void forget();
  /// Whether two pieces share a vertex that is free.
  bool keeps_apart(const Piece& p, const Piece& q) const {
    for (const int node : p.node) {
      const bool shared = node == q.node[0] || node == q.node[1] || node == q.node[2];
      if (shared && node >= 0 && free_[static_cast<size_t>(node)] != 0) return true;
    }
    return false;
  }

 private:
  struct Fan {
    int node = -1, body = 0;
    size_t first_edge = 0, edges = 0, first_piece = 0, pieces = 0;
    float clearance = -1.0f;  // m; below 0: not known
    int retry = 0;            // looks until it is found anew
  };

  float moved(const Fan& fan, const Nodes& x) const;
  void measure(const Nodes& x, Fan* fan);

  std::vector<Fan> fans_;
  std::vector<int> neighbour_;         // of each fan's edges: the other node
  std::vector<Eigen::Vector3f> edge_;  // m, when the clearance was found
  std::vector<const Piece*> piece_;    // of each fan
  std::vector<char> free_;             // by node
};

}  // namespace deformable_sim
