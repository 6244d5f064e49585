// Triangles and segments of bodies that touch, and which vertices and edges of them may meet in a step.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "deformable_sim/core/contact/fan_clearance.h"
#include "deformable_sim/core/contact/meeting.h"
#include "deformable_sim/core/contact/piece_tree.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// The surfaces of all bodies whose Body::touches asks for it: triangles of sheets and of skins of soft bodies,
/// segments of ropes. Every vertex and edge belongs to one piece, so that each pair is met once.
class SurfacePieces {
 public:
  explicit SurfacePieces(const Model* model);
  SurfacePieces(const SurfacePieces&) = delete;
  SurfacePieces& operator=(const SurfacePieces&) = delete;

  int piece_count() const { return tree_.piece_count(); }
  bool is_on_surface(int node) const { return on_surface_[static_cast<size_t>(node)] != 0; }
  double radius_of(int body) const { return model_->bodies[static_cast<size_t>(body)].contact_radius; }

  /// Forgets what it knows from earlier steps, so that the next one does not depend on them.
  void forget();
  /// What counts as near: pieces within `share` of the sum of their bodies' radii, and `wide` (m).
  struct Reach {
    double share, wide;  // 1, m
  };
  /// A step: nodes go from the columns of `start` to those of `end` (3 x nodes of the world, m), straight and evenly.
  struct Step {
    const Nodes &start, &end;
    Reach near_start, near_end;
  };
  /// visit(p, q) for each two pieces, but those that along one direction are out of reach both at the start and at the
  /// end of the step, on the same side. Always in the same order for the same state.
  template <class Visit>
  void for_each_pair(const Step& step, const Visit& visit) {
    if (pieces_.empty()) return;
    const bool known = is_covered(step);
    place(step);
    if (known) {
      for (const auto& [i, j] : near_) {
        if (!apart(tree_.slabs_of(i), tree_.slabs_of(j), gaps_)) {
          visit(pieces_[static_cast<size_t>(i)], pieces_[static_cast<size_t>(j)]);
        }
      }
      return;
    }
    const Lanes more = all_lanes(static_cast<int>(remember(step) * scale_));
    tree_.refit();
    tree_.for_each_pair({gaps_.start + more, gaps_.end + more}, [&](int i, int j) {
      const Piece &p = pieces_[static_cast<size_t>(i)], &q = pieces_[static_cast<size_t>(j)];
      if (p.body == q.body && model_->bodies[static_cast<size_t>(p.body)].touches != BodyContact::kAll) return;
      near_.push_back({i, j});
      if (!apart(tree_.slabs_of(i), tree_.slabs_of(j), gaps_)) visit(p, q);
    });
  }
  /// visit(Meeting) for each vertex and triangle, and each two edges, without common nodes, that are not so far apart.
  template <class Visit>
  void for_each_meeting(const Step& step, const Visit& visit) {
    for (size_t b = 0; b < asked_.size(); ++b) {
      asked_[b] = 2.0 * step.near_end.share * radius_of(static_cast<int>(b)) + step.near_end.wide;
    }
    fans_.find_free(step.start, step.end, asked_);
    for_each_pair(step, [&](const Piece& p, const Piece& q) {
      if (fans_.keeps_apart(p, q)) return;
      if (q.count == 3 && p.own_nodes != 0u) visit_nodes(p, q, visit);
      if (p.count == 3 && q.own_nodes != 0u) visit_nodes(q, p, visit);
      visit_edges(p, q, visit);
    });
  }

 private:
  struct Place {
    Lanes start, end;
  };

  void add_pieces(int body);
  void place(const Step& step);
  /// Whether near_ has all that is near in this step, for the last one that was walked through the tree for began at
  /// the same places, looked further, and ended not far from where this one ends.
  bool is_covered(const Step& step) const;
  double remember(const Step& step);
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
  void visit_nodes(const Piece& p, const Piece& t, const Visit& visit) const {
    const auto body = static_cast<size_t>(p.body);
    const Gaps gaps{gaps_.start + radius_start_[body], gaps_.end + radius_end_[body]};
    const Slabs& triangle = tree_.slabs_of(static_cast<int>(&t - pieces_.data()));
    for (size_t k = 0; k < static_cast<size_t>(p.count); ++k) {
      const int node = p.node[k];
      if ((p.own_nodes >> k & 1u) == 0u || node == t.node[0] || node == t.node[1] || node == t.node[2]) continue;
      if (apart(slabs_of(&node, 1), triangle, gaps)) continue;
      visit(Meeting{{{node, t.node[0], t.node[1], t.node[2]}}, 1, &p, &t});
    }
  }

  template <class Visit>
  void visit_edges(const Piece& p, const Piece& q, const Visit& visit) const {
    const auto i = static_cast<size_t>(&p - pieces_.data()), j = static_cast<size_t>(&q - pieces_.data());
    for (size_t k = first_edge_[i]; k < first_edge_[i + 1]; ++k) {
      for (size_t l = first_edge_[j]; l < first_edge_[j + 1]; ++l) {
        if (apart(edge_slabs_[k], edge_slabs_[l], gaps_)) continue;
        const std::array<int, 2>&a = edges_[k], &b = edges_[l];
        if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) continue;
        visit(Meeting{{{a[0], a[1], b[0], b[1]}}, 2, &p, &q});
      }
    }
  }

  const Model* model_;
  std::vector<Piece> pieces_;
  std::vector<char> on_surface_;                  // by node
  std::vector<Place> place_;                      // by node
  std::vector<Lanes> radius_start_, radius_end_;  // by body: its share
  Gaps gaps_;                                     // without radii
  double least_radius_ = 0.0;                     // m
  double scale_ = 1.0;                            // 1/m
  std::vector<size_t> first_edge_;                // by piece, and the end: of its own in ...
  std::vector<std::array<int, 2>> edges_;         // ... the nodes of all edges
  std::vector<Slabs> edge_slabs_;                 // with radii
  std::vector<double> asked_;                     // m, by body
  FanClearance fans_;

  // Of the last step that was walked through the tree for.
  std::vector<std::array<int, 2>> near_;  // pieces, of bodies that touch
  Nodes last_start_, last_end_;
  Reach last_near_start_{0.0, 0.0}, last_near_end_{0.0, 0.0};
  PieceTree tree_;
};

}  // namespace deformable_sim
