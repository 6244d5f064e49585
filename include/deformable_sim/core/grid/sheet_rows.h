// A sheet on a grid as the kernels want it: rows of x, y and z apart, with margins.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/grid/sheet_kernels.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Numbers in rows with margins, zero where there is no node. Every row starts on a boundary of the widest registers.
template <class Real>
class RowArray {
 public:
  RowArray() = default;
  /// The stride is a multiple of kMargin.
  RowArray(int rows, std::ptrdiff_t stride)
      : values_(static_cast<size_t>((rows + 2 * kRowMargin) * stride + kEnd), Real(0)),
        first_(kRowMargin * stride + SheetShape<Real>::kMargin) {
    const auto past = reinterpret_cast<std::uintptr_t>(values_.data() + first_) % kBoundary;
    if (past != 0) first_ += static_cast<std::ptrdiff_t>((kBoundary - past) / sizeof(Real));
  }
  RowArray(RowArray&&) = default;
  RowArray& operator=(RowArray&&) = default;
  /// Of node (0, 0).
  Real* data() { return values_.data() + first_; }
  const Real* data() const { return values_.data() + first_; }
  bool empty() const { return values_.empty(); }
  void clear() { std::fill(values_.begin(), values_.end(), Real(0)); }

 private:
  static constexpr int kRowMargin = 2;
  static constexpr int kEnd = 5 * SheetShape<Real>::kMargin;
  static constexpr std::uintptr_t kBoundary = 64;
  std::vector<Real> values_;
  std::ptrdiff_t first_ = 0;
};

template <class Real>
class XyzArray {
 public:
  XyzArray() = default;
  XyzArray(int rows, std::ptrdiff_t stride) : x_(rows, stride), y_(rows, stride), z_(rows, stride) {}
  Xyz<Real> data() { return {x_.data(), y_.data(), z_.data()}; }
  bool empty() const { return x_.empty(); }
  void clear() {
    x_.clear();
    y_.clear();
    z_.clear();
  }

 private:
  RowArray<Real> x_, y_, z_;
};

/// The coefficients of a sheet and the space its kernels need. The sheet may go; the rows stay.
template <class Real>
class SheetRows {
 public:
  /// scratch_count: how many bands are worked on at the same time.
  explicit SheetRows(const GridSheet& sheet, int scratch_count = 1);
  SheetRows(const SheetRows&) = delete;
  SheetRows& operator=(const SheetRows&) = delete;

  const SheetShape<Real>& shape() const { return shape_; }
  const SheetScratch<Real>& scratch(int number = 0) const { return scratch_[static_cast<size_t>(number)]; }
  int first_node() const { return first_node_; }
  int node_count() const { return shape_.rows * shape_.cols; }
  /// Where a node of the sheet (counted from its first) lies in an array.
  std::ptrdiff_t place(int node) const { return node / shape_.cols * shape_.stride + node % shape_.cols; }
  int node(std::ptrdiff_t place) const {
    return static_cast<int>(place / shape_.stride) * shape_.cols + static_cast<int>(place % shape_.stride);
  }
  XyzArray<Real> make_xyz() const { return {shape_.rows, shape_.stride}; }
  RowArray<Real> make_array() const { return {shape_.rows, shape_.stride}; }

  /// Between the columns of the sheet's nodes in `nodes` (3 x all nodes) and rows.
  void load(const Nodes& nodes, Xyz<Real> rows) const;
  void store(Xyz<Real> rows, Nodes* nodes) const;
  /// nodes += rows.
  void add(Xyz<Real> rows, Nodes* nodes) const;

 private:
  const Real* keep(const std::vector<double>& values);

  SheetShape<Real> shape_;
  std::vector<SheetScratch<Real>> scratch_;
  int first_node_;
  std::vector<std::vector<Real>> coefficients_;
  std::vector<const Real*> bending_;
  RowArray<Real> passed_;
};

extern template class SheetRows<float>;
extern template class SheetRows<double>;

}  // namespace deformable_sim
