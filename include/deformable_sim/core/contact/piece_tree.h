// A binary tree over pieces that move: which pairs of them may meet in a step.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/slabs.h"

namespace deformable_sim {

/// The shape of the tree is that of the places it was built at; extents are fitted anew, from the leaves up, whenever
/// the pieces have moved. One thread.
///
/// Not good at: pieces that have wandered far from their neighbours at build, whose extents become large.
class PieceTree {
 public:
  PieceTree() = default;
  /// Halves the pieces across their longest extent until each is alone; ties by index.
  explicit PieceTree(const std::vector<Vec3>& centers);

  int piece_count() const { return static_cast<int>(piece_.size()); }
  /// Extent of a piece, to be set for all of them before refit().
  Slabs& slabs_of(int piece) { return slabs_[static_cast<size_t>(leaf_[static_cast<size_t>(piece)])]; }
  const Slabs& slabs_of(int piece) const { return slabs_[static_cast<size_t>(leaf_[static_cast<size_t>(piece)])]; }
  void refit();

  /// visit(i, j) once for each two pieces that are not apart; always in the same order for the same extents.
  template <class Visit>
  void for_each_pair(const Gaps& gaps, const Visit& visit) {
    stack_.clear();
    if (!piece_.empty()) stack_.push_back({0, 0});
    while (!stack_.empty()) {
      const auto [a, b] = stack_.back();
      stack_.pop_back();
      const Node &na = nodes_[static_cast<size_t>(a)], &nb = nodes_[static_cast<size_t>(b)];
      if (a == b) {
        if (na.left < 0) continue;
        stack_.push_back({na.left, na.right});
        stack_.push_back({na.right, na.right});
        stack_.push_back({na.left, na.left});
        continue;
      }
      if (apart(slabs_[static_cast<size_t>(a)], slabs_[static_cast<size_t>(b)], gaps)) continue;
      if (na.left < 0 && nb.left < 0) {
        visit(na.piece, nb.piece);
      } else if (nb.left < 0 || (na.left >= 0 && na.count >= nb.count)) {
        stack_.push_back({na.right, b});
        stack_.push_back({na.left, b});
      } else {
        stack_.push_back({a, nb.right});
        stack_.push_back({a, nb.left});
      }
    }
  }

 private:
  struct Node {
    int left = -1, right = -1;  // -1: a leaf
    int piece = -1;             // of a leaf
    int count = 1;              // of pieces below
  };
  struct Pair {
    int a, b;
  };
  int build(const std::vector<Vec3>& centers, int first, int last);

  std::vector<int> piece_;    // in the order of the leaves
  std::vector<int> leaf_;     // node of a piece
  std::vector<Node> nodes_;   // a parent before its children
  std::vector<Slabs> slabs_;  // of the nodes
  std::vector<Pair> stack_;
};

}  // namespace deformable_sim
