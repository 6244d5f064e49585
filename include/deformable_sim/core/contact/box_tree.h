// A binary tree of boxes over pieces that move: which pairs of them may touch.
#pragma once

#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Boxes aligned with the axes, single precision, rounded outwards. The shape of the tree is that of the places it was
/// built at; boxes are fitted anew, from the leaves up, whenever the pieces have moved. One thread.
///
/// Not good at: pieces that have wandered far from their neighbours at build, whose boxes become large.
class BoxTree {
 public:
  using Box = Eigen::AlignedBox3f;

  BoxTree() = default;
  /// Halves the pieces across their longest extent until each is alone; ties by index.
  explicit BoxTree(const std::vector<Vec3>& centers);

  int piece_count() const { return static_cast<int>(piece_.size()); }
  /// Box of a piece, to be set for all of them before refit().
  Box& box_of(int piece) { return box_[static_cast<size_t>(leaf_[static_cast<size_t>(piece)])]; }
  void refit();

  /// visit(i, j) once for each two pieces whose boxes overlap; always in the same order for the same boxes.
  template <class Visit>
  void for_each_pair(const Visit& visit) {
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
      if (!box_[static_cast<size_t>(a)].intersects(box_[static_cast<size_t>(b)])) continue;
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

  std::vector<int> piece_;   // in the order of the leaves
  std::vector<int> leaf_;    // node of a piece
  std::vector<Node> nodes_;  // a parent before its children
  std::vector<Box> box_;     // of the nodes
  std::vector<Pair> stack_;
};

/// The smallest box of floats that contains `p` +- `reach`.
void extend(const Vec3& p, double reach, BoxTree::Box* box);

}  // namespace deformable_sim
