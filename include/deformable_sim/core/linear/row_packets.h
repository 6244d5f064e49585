// Sparse rows in packets, as PacketKernels want them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "deformable_sim/core/linear/packet_kernels.h"

namespace deformable_sim {

/// Where the entries of rows lie. The numbers of entries are kept by whoever has them, one a lane, size() in all.
class RowPackets {
 public:
  /// length: entries of each row. All columns are the rows themselves until they are set.
  void lay_out(const std::vector<int>& length, int width) {
    width_ = width;
    const int rows = static_cast<int>(length.size());
    start_.assign(1, 0);
    place_.clear();
    for (int first = 0; first < rows; first += width) {
      int longest = 0;
      for (int row = first; row < std::min(rows, first + width); ++row) {
        longest = std::max(longest, length[static_cast<size_t>(row)]);
      }
      start_.push_back(start_.back() + longest);
      place_.resize(static_cast<size_t>(start_.back() * width));
      for (int row = first; row < first + width; ++row) {
        for (int k = 0; k < longest; ++k) set_column(row, k, row);
      }
    }
  }
  void clear() {
    start_.clear();
    place_.clear();
  }

  /// Of the k-th entry of a row.
  size_t at(int row, int k) const {
    const int packet = row / width_;
    return static_cast<size_t>((start_[static_cast<size_t>(packet)] + k) * width_ + packet_lane(row % width_, width_));
  }
  void set_column(int row, int k, int column) { place_[at(row, k)] = 4 * column; }

  size_t size() const { return place_.size(); }
  int packets() const { return static_cast<int>(start_.size()) - 1; }
  /// Registers of entries of the packets before this one.
  int start(int packet) const { return start_[static_cast<size_t>(packet)]; }
  /// A null start when cleared.
  PacketRows rows() const { return {start_.empty() ? nullptr : start_.data(), place_.data()}; }

 private:
  int width_ = 1;
  std::vector<int> start_, place_;
};

}  // namespace deformable_sim
