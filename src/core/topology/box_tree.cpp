#include "deformable_sim/core/topology/box_tree.h"

#include <algorithm>
#include <numeric>

namespace deformable_sim {

namespace {

constexpr int kLeafSize = 4;

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) : items_(boxes.size()) {
  std::iota(items_.begin(), items_.end(), 0);
  branches_.push_back({Box(), 0, static_cast<int>(items_.size()), 0});
  // Children are appended behind their parents, so the loop reaches them all.
  for (size_t b = 0; b < branches_.size(); ++b) {
    Branch branch = branches_[b];
    Box centers;
    for (int k = branch.first_item; k < branch.last_item; ++k) {
      const Box& box = boxes[static_cast<size_t>(items_[static_cast<size_t>(k)])];
      branch.box.extend(box);
      centers.extend(box.center());
    }
    if (branch.last_item - branch.first_item > kLeafSize) {
      Eigen::Index axis;
      centers.sizes().maxCoeff(&axis);
      const int middle = (branch.first_item + branch.last_item) / 2;
      std::nth_element(items_.begin() + branch.first_item, items_.begin() + middle, items_.begin() + branch.last_item,
                       [&](int i, int j) {
                         return boxes[static_cast<size_t>(i)].center()[axis] <
                                boxes[static_cast<size_t>(j)].center()[axis];
                       });
      branches_.push_back({Box(), branch.first_item, middle, 0});
      branch.second = static_cast<int>(branches_.size());
      branches_.push_back({Box(), middle, branch.last_item, 0});
    }
    branches_[b] = branch;
  }
}

}  // namespace deformable_sim
