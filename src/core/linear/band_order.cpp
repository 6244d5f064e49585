#include "band_order.h"

#include <algorithm>
#include <cstdlib>

namespace deformable_sim {
namespace {

class Orders {
 public:
  explicit Orders(const BlockMatrix& a) : a_(a), position_(static_cast<size_t>(a.rows()), kUnseen) {}

  BandParts find(int widest) {
    BandParts result;
    // Points first: a part without any consists of rows of one unknown alone.
    for (int node = 0; node < a_.rows(); ++node) {
      if (position_[static_cast<size_t>(node)] != kUnseen) continue;
      BandPart part;
      if (order(node, widest, &part)) {
        result.parts.push_back(std::move(part));
      } else {
        result.others.insert(result.others.end(), members_.begin(), members_.end());
      }
    }
    std::sort(result.others.begin(), result.others.end());
    return result;
  }

 private:
  static constexpr int kUnseen = -2, kListed = -1;

  bool is_scalar(int node) const { return node >= a_.first_scalar_row(); }
  template <class F>
  void each_neighbour(int node, const F& f) const {
    for (int k = a_.row_start()[static_cast<size_t>(node)]; k < a_.row_start()[static_cast<size_t>(node) + 1]; ++k) {
      const int other = a_.column()[static_cast<size_t>(k)];
      if (other != node) f(other);
    }
  }
  int degree(int node) const {
    return a_.row_start()[static_cast<size_t>(node) + 1] - a_.row_start()[static_cast<size_t>(node)];
  }

  /// The part around `node`; false if its band is wider than `widest`.
  bool order(int node, int widest, BandPart* part) {
    members_ = reach(node, [](int) { return true; });
    const bool points = std::any_of(members_.begin(), members_.end(), [&](int i) { return !is_scalar(i); });
    const auto among = [&](int i) { return !points || !is_scalar(i); };
    int end = *std::find_if(members_.begin(), members_.end(), among);
    // Twice to the far side of where it began: an end of a line.
    for (int k = 0; k < 2; ++k) end = reach(end, among).back();
    std::vector<int> line = reach(end, among);
    for (int i : members_) position_[static_cast<size_t>(i)] = kListed;
    for (size_t p = 0; p < line.size(); ++p) position_[static_cast<size_t>(line[p])] = static_cast<int>(p);
    for (int i : line) part->group.push_back({i, -1});
    if (points && !join_scalars(part)) return false;
    for (int i : members_) {
      if (position_[static_cast<size_t>(i)] == kListed) return false;  // points held together by angles alone
      each_neighbour(i, [&](int j) {
        part->bandwidth =
            std::max(part->bandwidth, std::abs(position_[static_cast<size_t>(i)] - position_[static_cast<size_t>(j)]));
      });
    }
    return part->bandwidth <= widest;
  }

  /// Breadth first from `start`, neighbours by degree.
  template <class Among>
  std::vector<int> reach(int start, const Among& among) {
    std::vector<int> found{start}, next;
    mark_.resize(position_.size(), 0);
    ++stamp_;
    mark_[static_cast<size_t>(start)] = stamp_;
    for (size_t k = 0; k < found.size(); ++k) {
      next.clear();
      each_neighbour(found[k], [&](int j) {
        if (mark_[static_cast<size_t>(j)] == stamp_ || !among(j)) return;
        mark_[static_cast<size_t>(j)] = stamp_;
        next.push_back(j);
      });
      std::stable_sort(next.begin(), next.end(), [&](int i, int j) { return degree(i) < degree(j); });
      found.insert(found.end(), next.begin(), next.end());
    }
    return found;
  }

  bool join_scalars(BandPart* part) {
    struct Scalar {
      int first, last, row;
    };
    std::vector<Scalar> scalars;
    for (int i : members_) {
      if (!is_scalar(i)) continue;
      Scalar s{a_.rows(), -1, i};
      each_neighbour(i, [&](int j) {
        if (is_scalar(j)) return;
        s.first = std::min(s.first, position_[static_cast<size_t>(j)]);
        s.last = std::max(s.last, position_[static_cast<size_t>(j)]);
      });
      if (s.last < 0) return false;
      scalars.push_back(s);
    }
    std::sort(scalars.begin(), scalars.end(), [](const Scalar& s, const Scalar& t) {
      return s.first + s.last != t.first + t.last ? s.first + s.last < t.first + t.last : s.row < t.row;
    });
    for (const Scalar& s : scalars) {
      auto p = static_cast<size_t>(std::max(0, s.first));
      while (p < part->group.size() && part->group[p][1] >= 0) ++p;
      if (p == part->group.size()) return false;
      part->group[p][1] = s.row;
      position_[static_cast<size_t>(s.row)] = static_cast<int>(p);
    }
    part->has_scalars = !scalars.empty();
    return true;
  }

  const BlockMatrix& a_;
  std::vector<int> position_;  // by block row: group in its part
  std::vector<int> members_;   // of the part at hand
  std::vector<int> mark_;
  int stamp_ = 0;
};

}  // namespace

BandParts band_parts(const BlockMatrix& pattern, int widest) {
  return Orders(pattern).find(widest);
}

}  // namespace deformable_sim
