// A sheet on a grid as the kernels of explicit steps want it: columns dealt out to the lanes of registers.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/grid/motion_kernels.h"
#include "deformable_sim/core/grid/sheet_rows.h"

namespace deformable_sim {

/// The coefficients of a sheet and the space its kernels need, see MotionShape. The sheet may go; the rows stay.
template <class Real>
class MotionRows {
 public:
  /// width: numbers a register.
  MotionRows(const GridSheet& sheet, int width);
  MotionRows(const MotionRows&) = delete;
  MotionRows& operator=(const MotionRows&) = delete;

  const MotionShape<Real>& shape() const { return shape_; }
  int first_node() const { return first_node_; }
  int node_count() const { return shape_.rows * cols_; }
  int width() const { return width_; }
  /// Where x of a node of the sheet (counted from its first) lies; y and z follow at a width.
  std::ptrdiff_t place(int node) const {
    return node / cols_ * shape_.stride + columns_[static_cast<size_t>(node % cols_)].place;
  }
  /// Where numbers by node lie.
  std::ptrdiff_t number_place(int node) const;
  /// work(node, place of x) for all nodes, counted from the sheet's first.
  template <class Work>
  void for_each_node(const Work& work) const {
    for (int row = 0, node = 0; row < shape_.rows; ++row) {
      for (const Column& column : columns_) work(node++, row * shape_.stride + column.place);
    }
  }
  /// work(place) for the places of x of this node: its own, and those in the registers beside the row.
  template <class Work>
  void for_each_place(int node, const Work& work) const {
    const Column& column = columns_[static_cast<size_t>(node % cols_)];
    const std::ptrdiff_t row = node / cols_ * shape_.stride;
    work(row + column.place);
    for (int k = 0; k < column.copies; ++k) work(row + column.copy[static_cast<size_t>(k)]);
  }

  /// Points of all nodes and of the registers beside rows, and numbers by node.
  template <class Number>
  RowArray<Number> make_points() const {
    return {shape_.rows, shape_.stride};
  }
  RowArray<Real> make_numbers() const { return {shape_.rows, shape_.stride / 3}; }
  /// Space for `count` rows of points, with the registers beside each.
  RowArray<Real> make_rows(int count) const { return {count, shape_.stride}; }

 private:
  /// Places within a row.
  struct Column {
    std::ptrdiff_t place;
    std::array<std::ptrdiff_t, 2 * MotionShape<Real>::kHalo> copy;
    int copies;
  };
  Column place_column(int col) const;
  const Real* deal(const std::vector<double>& by_column);
  const Real* keep(const std::vector<double>& by_row);
  const Real* deal_bending(const GridStencil::Row& kind);

  MotionShape<Real> shape_;
  int first_node_, cols_, width_;
  std::vector<Column> columns_;
  std::vector<RowArray<Real>> coefficients_;
  std::vector<const Real*> bending_;
};

extern template class MotionRows<float>;
extern template class MotionRows<double>;

}  // namespace deformable_sim
