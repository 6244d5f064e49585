#include "deformable_sim/core/grid/motion_rows.h"

#include <algorithm>

namespace deformable_sim {

template <class Real>
MotionRows<Real>::MotionRows(const GridSheet& sheet, int width)
    : first_node_(sheet.first_node), cols_(sheet.cols), width_(width) {
  constexpr int kHalo = MotionShape<Real>::kHalo;
  shape_.rows = sheet.rows;
  shape_.registers = (cols_ + width - 1) / width;
  shape_.stride = static_cast<std::ptrdiff_t>(3 * width) * (shape_.registers + 2 * kHalo);
  for (int col = 0; col < cols_; ++col) columns_.push_back(place_column(col));
  shape_.damping_time = static_cast<Real>(sheet.damping_time);
  shape_.warp_length = static_cast<Real>(sheet.warp.length);
  shape_.weft_length = static_cast<Real>(sheet.weft.length);
  shape_.shear_length = static_cast<Real>(sheet.shear_length);
  shape_.warp_bend_length = static_cast<Real>(sheet.warp_bend.length);
  shape_.weft_bend_length = static_cast<Real>(sheet.weft_bend.length);
  shape_.warp_along = deal(sheet.warp.along);
  shape_.warp_across = keep(sheet.warp.across);
  shape_.weft_along = keep(sheet.weft.along);
  shape_.weft_across = deal(sheet.weft.across);
  shape_.shear = deal(std::vector<double>(static_cast<size_t>(sheet.cols - 1), sheet.shear));
  shape_.shear_rows = keep(std::vector<double>(static_cast<size_t>(sheet.rows - 1), 1.0));
  shape_.has_flexion = !sheet.warp_bend.empty() || !sheet.weft_bend.empty();
  shape_.warp_bend_along = deal(sheet.warp_bend.along);
  shape_.warp_bend_across = keep(sheet.warp_bend.across);
  shape_.weft_bend_along = keep(sheet.weft_bend.along);
  shape_.weft_bend_across = deal(sheet.weft_bend.across);

  shape_.bending_damping = static_cast<Real>(sheet.bending_damping);
  shape_.has_bending = !sheet.bending.empty();
  std::vector<const Real*> kinds;
  for (const GridStencil::Row& kind : sheet.bending.kind) kinds.push_back(deal_bending(kind));
  for (int kind : sheet.bending.kind_of_row) bending_.push_back(kinds[static_cast<size_t>(kind)]);
  shape_.bending = bending_.data();
}

/// Zero where there is no column, and in the registers beside those of the row but where they repeat one.
template <class Real>
const Real* MotionRows<Real>::deal(const std::vector<double>& by_column) {
  constexpr int kHalo = MotionShape<Real>::kHalo;
  const int registers = shape_.registers;
  coefficients_.emplace_back(1, shape_.stride);
  Real* to = coefficients_.back().data();
  for (int r = -kHalo; r < registers + kHalo; ++r) {
    for (int lane = 0; lane < width_; ++lane) {
      const int col = lane * registers + r;
      if (col < 0 || col >= static_cast<int>(by_column.size())) continue;
      to[r * width_ + lane] = static_cast<Real>(by_column[static_cast<size_t>(col)]);
    }
  }
  return to;
}

/// A copy with zeros on both sides.
template <class Real>
const Real* MotionRows<Real>::keep(const std::vector<double>& by_row) {
  coefficients_.emplace_back(1, std::max<std::ptrdiff_t>(shape_.rows, shape_.stride));
  Real* to = coefficients_.back().data();
  for (size_t k = 0; k < by_row.size(); ++k) to[k] = static_cast<Real>(by_row[k]);
  return to;
}

template <class Real>
const Real* MotionRows<Real>::deal_bending(const GridStencil::Row& kind) {
  coefficients_.emplace_back(1, kStencilSize * shape_.stride);
  Real* to = coefficients_.back().data();
  for (int col = 0; col < cols_; ++col) {
    const std::ptrdiff_t at = col % shape_.registers * kStencilSize * width_ + col / shape_.registers;
    for (size_t k = 0; k < kind.size(); ++k) {
      to[at + static_cast<std::ptrdiff_t>(k) * width_] = static_cast<Real>(kind[k][static_cast<size_t>(col)]);
    }
  }
  return to;
}

template <class Real>
std::ptrdiff_t MotionRows<Real>::number_place(int node) const {
  const int col = node % cols_;
  return node / cols_ * (shape_.stride / 3) + col % shape_.registers * width_ + col / shape_.registers;
}

template <class Real>
typename MotionRows<Real>::Column MotionRows<Real>::place_column(int col) const {
  static_assert(MotionShape<Real>::kHalo == 2, "all registers beside a row");
  const int registers = shape_.registers;
  Column column{3 * width_ * (col % registers) + col / registers, {}, 0};
  for (int r : {-2, -1, registers, registers + 1}) {
    const int ahead = col - r;  // of lane 0 of that register
    if (ahead < 0 || ahead % registers != 0 || ahead / registers >= width_) continue;
    column.copy[static_cast<size_t>(column.copies++)] = 3 * width_ * r + ahead / registers;
  }
  return column;
}

template class MotionRows<float>;
template class MotionRows<double>;

}  // namespace deformable_sim
