// A tree of boxes around items, to find those near a point.
#pragma once

#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Balanced binary tree over axis-aligned boxes, split at the median of their centres along the longest side: built in
/// O(n log n), asked in about O(log n). Items are numbers 0 ... n - 1.
class BoxTree {
 public:
  using Box = Eigen::AlignedBox3d;

  explicit BoxTree(const std::vector<Box>& boxes);

  /// Visits every item whose box is within sqrt(squared_distance) of p.
  template <class Visit>
  void visit_within(const Vec3& p, double squared_distance, Visit&& visit) const {
    std::vector<int> open{0};
    while (!open.empty()) {
      const Branch& branch = branches_[static_cast<size_t>(open.back())];
      open.pop_back();
      if (branch.box.squaredExteriorDistance(p) > squared_distance) continue;
      if (branch.second == 0) {
        for (int k = branch.first_item; k < branch.last_item; ++k) visit(items_[static_cast<size_t>(k)]);
      } else {
        open.push_back(branch.second);
        open.push_back(branch.second - 1);
      }
    }
  }

  /// Smallest squared_distance_to(item), which must be no less than the squared distance to the item's box, and the
  /// item that has it; of equals, any.
  template <class SquaredDistance>
  std::pair<double, int> nearest(const Vec3& p, SquaredDistance&& squared_distance_to) const {
    std::pair<double, int> best(std::numeric_limits<double>::infinity(), -1);
    std::priority_queue<std::pair<double, int>> open;  // nearest branch on top: distances are kept negative
    open.push({-branches_[0].box.squaredExteriorDistance(p), 0});
    while (!open.empty() && -open.top().first < best.first) {
      const Branch& branch = branches_[static_cast<size_t>(open.top().second)];
      open.pop();
      if (branch.second == 0) {
        for (int k = branch.first_item; k < branch.last_item; ++k) {
          const int item = items_[static_cast<size_t>(k)];
          const double distance = squared_distance_to(item);
          if (distance < best.first) best = {distance, item};
        }
      } else {
        for (const int child : {branch.second - 1, branch.second}) {
          open.push({-branches_[static_cast<size_t>(child)].box.squaredExteriorDistance(p), child});
        }
      }
    }
    return best;
  }

 private:
  struct Branch {
    Box box;
    int first_item, last_item;  // of items_
    int second;                 // its second child; the first stands before it; 0: a leaf
  };

  std::vector<Branch> branches_;
  std::vector<int> items_;
};

}  // namespace deformable_sim
