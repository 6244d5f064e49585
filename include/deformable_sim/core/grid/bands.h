// The rows of a sheet, shared out among threads.
#pragma once

#include <algorithm>
#include <array>

#include "deformable_sim/core/grid/sheet_kernels.h"
#include "deformable_sim/core/parallel/workers.h"

namespace deformable_sim {

/// Neighbouring rows of a grid in bands of about the same size. How many depends on the grid alone.
class Bands {
 public:
  /// A sheet of fewer nodes stays whole: its loops are too short for threads to pay (doc/performance.md).
  static constexpr int kLeastNodes = 2400;
  static constexpr int kLeastRows = 8;  // a band reckons a row of springs that belongs to the band above as well
  static constexpr int kMost = 12;      // what 2, 3, 4 and 6 threads share evenly

  Bands(int rows, int count) : rows_(rows), count_(count) {}
  static Bands of(int rows, int cols) {
    return {rows, rows * cols < kLeastNodes ? 1 : std::clamp(rows / kLeastRows, 1, kMost)};
  }

  int rows() const { return rows_; }
  int count() const { return count_; }
  int first(int band) const { return rows_ * band / count_; }
  int end(int band) const { return first(band + 1); }

 private:
  int rows_, count_;
};

/// Loops over bands: by workers, each band by itself, or on one thread, one after the other.
class BandLoop {
 public:
  /// workers: null is one thread.
  BandLoop(const Bands& bands, const Workers* workers)
      : bands_(bands), workers_(bands.count() > 1 ? workers : nullptr) {}

  int count() const { return bands_.count(); }
  /// Whether bands are worked on at the same time, each with scratch of its own.
  bool apart() const { return workers_ != nullptr; }
  int scratch_count() const { return apart() ? count() : 1; }

  /// work(rows, scratch) for all rows, `scratch` counted; one thread takes all rows at once.
  template <class Work>
  void run(const Work& work) const {
    if (workers_ == nullptr) return work(RowBand{0, bands_.rows(), true}, 0);
    workers_->for_each(count(), [&](int k) { work(RowBand{bands_.first(k), bands_.end(k), false}, k); });
  }
  /// work(band, rows, scratch), band by band on one thread too.
  template <class Work>
  void run_each(const Work& work) const {
    if (workers_ != nullptr) return run([&](const RowBand& rows, int k) { work(k, rows, k); });
    for (int k = 0; k < count(); ++k) work(k, RowBand{bands_.first(k), bands_.end(k), true}, 0);
  }
  /// The sum of work(rows, scratch) of all bands, in their order.
  template <class Work>
  double sum(const Work& work) const {
    std::array<double, Bands::kMost> parts;
    run_each([&](int k, const RowBand& rows, int scratch) { parts[static_cast<size_t>(k)] = work(rows, scratch); });
    double sum = parts[0];
    for (int k = 1; k < count(); ++k) sum += parts[static_cast<size_t>(k)];
    return sum;
  }

 private:
  Bands bands_;
  const Workers* workers_;  // null also where there is but one band
};

}  // namespace deformable_sim
