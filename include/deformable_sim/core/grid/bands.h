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

/// Loops over bands: on one thread one after the other, by workers several runs of neighbouring bands at a time, two
/// for each thread. Within a run nothing is reckoned twice.
class BandLoop {
 public:
  /// workers: null is one thread.
  BandLoop(const Bands& bands, const Workers* workers)
      : bands_(bands),
        workers_(bands.count() > 1 ? workers : nullptr),
        runs_(bands.count(), workers_ != nullptr ? std::min(2 * workers_->threads(), bands.count()) : 1) {}

  int count() const { return bands_.count(); }
  /// Whether bands are worked on at the same time, each run with scratch of its own.
  bool apart() const { return workers_ != nullptr; }
  int scratch_count() const { return runs_.count(); }

  /// work(rows, scratch) for all rows, `scratch` counted; a run is one band here.
  template <class Work>
  void run(const Work& work) const {
    if (workers_ == nullptr) return work(RowBand{0, bands_.rows(), false, true}, 0);
    workers_->for_each(runs_.count(), [&](int r) {
      work(RowBand{bands_.first(runs_.first(r)), bands_.first(runs_.end(r)), false, false}, r);
    });
  }
  /// work(band, rows, scratch), band by band.
  template <class Work>
  void run_each(const Work& work) const {
    for_each_piece(workers_, runs_.count(), [&](int r) {
      for (int k = runs_.first(r); k < runs_.end(r); ++k) {
        work(k, RowBand{bands_.first(k), bands_.end(k), k > runs_.first(r), workers_ == nullptr}, r);
      }
    });
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
  Bands runs_;              // of bands
};

}  // namespace deformable_sim
