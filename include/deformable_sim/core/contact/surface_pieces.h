// Triangles and segments of bodies that touch, and which vertices and edges of them may meet in a step.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "deformable_sim/core/contact/piece_tree.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// A vertex and a triangle (1 + 3 nodes), or two edges (2 + 2).
struct Meeting {
  std::array<int, 4> node;  // world node indices
  int first;                // how many are of the first part
  int body_a, body_b;
};

/// The surfaces of all bodies whose Body::touches asks for it: triangles of sheets and of skins of soft bodies,
/// segments of ropes. Every vertex and edge belongs to one piece, so that each pair is met once.
class SurfacePieces {
 public:
  /// A triangle or a segment, with the corners and edges that it answers for: each is one piece's only.
  struct Piece {
    std::array<int, 3> node{{-1, -1, -1}};
    int count = 3;
    int body = 0;
    unsigned own_nodes = 0, own_edges = 0;  // bit k: node k, edge k to k + 1
  };
  explicit SurfacePieces(const Model* model);

  int piece_count() const { return tree_.piece_count(); }
  bool is_on_surface(int node) const { return on_surface_[static_cast<size_t>(node)] != 0; }
  double radius_of(int body) const { return model_->bodies[static_cast<size_t>(body)].contact_radius; }

  /// What counts as near: pieces within `share` of the sum of their bodies' radii, and `wide` (m).
  struct Reach {
    double share, wide;  // 1, m
  };
  /// A step: nodes go from the columns of `start` to those of `end` (3 x nodes of the world, m), straight and evenly.
  struct Step {
    const Nodes &start, &end;
    Reach near_start, near_end;
  };
  /// visit(p, q, gaps) for each two pieces, but those that along one direction are out of reach both at the start and
  /// at the end of the step, on the same side. Always in the same order for the same state. `gaps`: those of these two.
  template <class Visit>
  void for_each_pair(const Step& step, const Visit& visit) {
    if (pieces_.empty()) return;
    place(step);
    const Gaps gaps{lanes_of(step.near_start.wide), lanes_of(step.near_end.wide)};
    tree_.for_each_pair(gaps, [&](int i, int j) {
      const Piece &p = pieces_[static_cast<size_t>(i)], &q = pieces_[static_cast<size_t>(j)];
      if (p.body == q.body && model_->bodies[static_cast<size_t>(p.body)].touches != BodyContact::kAll) return;
      visit(p, q,
            Gaps{gaps.start + radius_start_[static_cast<size_t>(p.body)] + radius_start_[static_cast<size_t>(q.body)],
                 gaps.end + radius_end_[static_cast<size_t>(p.body)] + radius_end_[static_cast<size_t>(q.body)]});
    });
  }
  /// visit(Meeting) for each vertex and triangle, and each two edges, without common nodes, that are not so far apart.
  template <class Visit>
  void for_each_meeting(const Step& step, const Visit& visit) {
    for_each_pair(step, [&](const Piece& p, const Piece& q, const Gaps& gaps) {
      if (q.count == 3) visit_nodes(p, q, gaps, visit);
      if (p.count == 3) visit_nodes(q, p, gaps, visit);
      visit_edges(p, q, gaps, visit);
    });
  }

 private:
  struct Place {
    Lanes start, end;
  };

  void add_pieces(int body);
  void place(const Step& step);
  /// m in steps, rounded so that what is further apart in whole steps is so in m.
  Lanes lanes_of(double length) const { return all_lanes(static_cast<int>(std::ceil(length * scale_)) + 1); }
  Slabs slabs_of(const int* node, int count) const {
    Slabs s;
    const Place& first = place_[static_cast<size_t>(node[0])];
    s.low_start = s.high_start = first.start;
    s.low_end = s.high_end = first.end;
    for (int k = 1; k < count; ++k) {
      const Place& p = place_[static_cast<size_t>(node[k])];
      s.extend(p.start, p.end);
    }
    return s;
  }

  template <class Visit>
  void visit_nodes(const Piece& p, const Piece& t, const Gaps& gaps, const Visit& visit) const {
    if (p.own_nodes == 0u) return;
    const Slabs triangle = slabs_of(t.node.data(), 3);
    for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
      const int node = p.node[k];
      if ((p.own_nodes >> k & 1u) == 0u || node == t.node[0] || node == t.node[1] || node == t.node[2]) continue;
      if (apart(slabs_of(&node, 1), triangle, gaps)) continue;
      visit(Meeting{{{node, t.node[0], t.node[1], t.node[2]}}, 1, p.body, t.body});
    }
  }

  template <class Visit>
  void visit_edges(const Piece& p, const Piece& q, const Gaps& gaps, const Visit& visit) const {
    if (p.own_edges == 0u || q.own_edges == 0u) return;
    for (size_t k = 0; k < 3; ++k) {
      if ((p.own_edges >> k & 1u) == 0u) continue;
      const std::array<int, 2> one{{p.node[k], p.node[(k + 1) % static_cast<size_t>(p.count)]}};
      const Slabs extent = slabs_of(one.data(), 2);
      for (size_t l = 0; l < 3; ++l) {
        if ((q.own_edges >> l & 1u) == 0u) continue;
        const std::array<int, 2> other{{q.node[l], q.node[(l + 1) % static_cast<size_t>(q.count)]}};
        if (one[0] == other[0] || one[0] == other[1] || one[1] == other[0] || one[1] == other[1]) continue;
        if (apart(extent, slabs_of(other.data(), 2), gaps)) continue;
        visit(Meeting{{{one[0], one[1], other[0], other[1]}}, 2, p.body, q.body});
      }
    }
  }

  const Model* model_;
  std::vector<Piece> pieces_;
  std::vector<char> on_surface_;                  // by node
  std::vector<Place> place_;                      // by node
  std::vector<Lanes> radius_start_, radius_end_;  // by body: its share
  double scale_ = 1.0;                            // 1/m
  PieceTree tree_;
};

}  // namespace deformable_sim
