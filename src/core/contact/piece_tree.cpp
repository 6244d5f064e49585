#include "deformable_sim/core/contact/piece_tree.h"

#include <algorithm>
#include <numeric>

namespace deformable_sim {

PieceTree::PieceTree(const std::vector<Vec3>& centers) : piece_(centers.size()), leaf_(centers.size()) {
  std::iota(piece_.begin(), piece_.end(), 0);
  nodes_.reserve(2 * centers.size());
  if (!centers.empty()) build(centers, 0, piece_count());
  slabs_.resize(nodes_.size());
  stack_.reserve(1024);
}

int PieceTree::build(const std::vector<Vec3>& centers, int first, int last) {
  const auto index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  nodes_.back().count = last - first;
  if (last - first == 1) {
    const int piece = piece_[static_cast<size_t>(first)];
    nodes_.back().piece = piece;
    leaf_[static_cast<size_t>(piece)] = index;
    return index;
  }
  Eigen::AlignedBox3d extent;
  for (int i = first; i < last; ++i) extent.extend(centers[static_cast<size_t>(piece_[static_cast<size_t>(i)])]);
  int axis = 0;
  extent.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  std::nth_element(piece_.begin() + first, piece_.begin() + middle, piece_.begin() + last, [&](int a, int b) {
    const double xa = centers[static_cast<size_t>(a)][axis], xb = centers[static_cast<size_t>(b)][axis];
    return xa < xb || (xa == xb && a < b);
  });
  const int left = build(centers, first, middle), right = build(centers, middle, last);
  nodes_[static_cast<size_t>(index)].left = left;
  nodes_[static_cast<size_t>(index)].right = right;
  return index;
}

void PieceTree::refit() {
  for (size_t k = nodes_.size(); k-- > 0;) {
    const Node& node = nodes_[k];
    if (node.left < 0) continue;
    slabs_[k] = slabs_[static_cast<size_t>(node.left)];
    slabs_[k].extend(slabs_[static_cast<size_t>(node.right)]);
  }
}

}  // namespace deformable_sim
