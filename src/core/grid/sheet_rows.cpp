#include "deformable_sim/core/grid/sheet_rows.h"

#include <algorithm>

namespace deformable_sim {
namespace {

std::ptrdiff_t stride_of(int cols, int margin) {
  return margin + (cols + margin - 1) / margin * margin;
}

}  // namespace

template <class Real>
SheetRows<Real>::SheetRows(const GridSheet& sheet, int scratch_count) : first_node_(sheet.first_node) {
  shape_.rows = sheet.rows;
  shape_.cols = sheet.cols;
  shape_.stride = stride_of(sheet.cols, SheetShape<Real>::kMargin);
  shape_.damping_time = static_cast<Real>(sheet.damping_time);
  shape_.warp_length = static_cast<Real>(sheet.warp.length);
  shape_.weft_length = static_cast<Real>(sheet.weft.length);
  shape_.shear_length = static_cast<Real>(sheet.shear_length);
  shape_.warp_bend_length = static_cast<Real>(sheet.warp_bend.length);
  shape_.weft_bend_length = static_cast<Real>(sheet.weft_bend.length);
  shape_.warp_along = keep(sheet.warp.along);
  shape_.warp_across = keep(sheet.warp.across);
  shape_.weft_along = keep(sheet.weft.along);
  shape_.weft_across = keep(sheet.weft.across);
  shape_.shear = keep(std::vector<double>(static_cast<size_t>(sheet.cols - 1), sheet.shear));
  shape_.shear_rows = keep(std::vector<double>(static_cast<size_t>(sheet.rows - 1), 1.0));
  shape_.has_flexion = !sheet.warp_bend.empty() || !sheet.weft_bend.empty();
  shape_.warp_bend_along = keep(sheet.warp_bend.along);
  shape_.warp_bend_across = keep(sheet.warp_bend.across);
  shape_.weft_bend_along = keep(sheet.weft_bend.along);
  shape_.weft_bend_across = keep(sheet.weft_bend.across);

  shape_.bending_damping = static_cast<Real>(sheet.bending_damping);
  shape_.has_bending = !sheet.bending.empty();
  std::vector<const Real*> kinds;
  for (const GridStencil::Row& kind : sheet.bending.kind) {
    std::vector<double> all(kind.size() * static_cast<size_t>(shape_.stride), 0.0);
    for (size_t o = 0; o < kind.size(); ++o) {
      std::copy(kind[o].begin(), kind[o].end(), all.begin() + static_cast<std::ptrdiff_t>(o) * shape_.stride);
    }
    kinds.push_back(keep(all));
  }
  for (int kind : sheet.bending.kind_of_row) bending_.push_back(kinds[static_cast<size_t>(kind)]);
  shape_.bending = bending_.data();

  const std::ptrdiff_t passed = SheetScratch<Real>::kPassed * shape_.stride;
  passed_ = {scratch_count, passed};
  for (int k = 0; k < scratch_count; ++k) scratch_.push_back({passed_.data() + k * passed});
}

/// A copy with zeros on both sides.
template <class Real>
const Real* SheetRows<Real>::keep(const std::vector<double>& values) {
  constexpr size_t kMargin = SheetShape<Real>::kMargin;
  const size_t most =
      std::max(values.size(), static_cast<size_t>(std::max<std::ptrdiff_t>(shape_.stride, shape_.rows)));
  std::vector<Real> copy(most + 3 * kMargin, Real(0));
  for (size_t k = 0; k < values.size(); ++k) copy[kMargin + k] = static_cast<Real>(values[k]);
  coefficients_.push_back(std::move(copy));
  return coefficients_.back().data() + kMargin;
}

template <class Real>
void SheetRows<Real>::load(const Nodes& nodes, Xyz<Real> rows) const {
  const double* from = nodes.data() + 3 * static_cast<std::ptrdiff_t>(first_node_);
  for (int row = 0; row < shape_.rows; ++row) {
    const std::ptrdiff_t first = row * shape_.stride;
    for (int col = 0; col < shape_.cols; ++col, from += 3) {
      rows.x[first + col] = static_cast<Real>(from[0]);
      rows.y[first + col] = static_cast<Real>(from[1]);
      rows.z[first + col] = static_cast<Real>(from[2]);
    }
  }
}

template <class Real>
void SheetRows<Real>::store(Xyz<Real> rows, Nodes* nodes) const {
  double* to = nodes->data() + 3 * static_cast<std::ptrdiff_t>(first_node_);
  for (int row = 0; row < shape_.rows; ++row) {
    const std::ptrdiff_t first = row * shape_.stride;
    for (int col = 0; col < shape_.cols; ++col, to += 3) {
      to[0] = static_cast<double>(rows.x[first + col]);
      to[1] = static_cast<double>(rows.y[first + col]);
      to[2] = static_cast<double>(rows.z[first + col]);
    }
  }
}

template <class Real>
void SheetRows<Real>::add(Xyz<Real> rows, Nodes* nodes) const {
  double* to = nodes->data() + 3 * static_cast<std::ptrdiff_t>(first_node_);
  for (int row = 0; row < shape_.rows; ++row) {
    const std::ptrdiff_t first = row * shape_.stride;
    for (int col = 0; col < shape_.cols; ++col, to += 3) {
      to[0] += static_cast<double>(rows.x[first + col]);
      to[1] += static_cast<double>(rows.y[first + col]);
      to[2] += static_cast<double>(rows.z[first + col]);
    }
  }
}

template class SheetRows<float>;
template class SheetRows<double>;

}  // namespace deformable_sim
