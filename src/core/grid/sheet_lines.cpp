#include "deformable_sim/core/grid/sheet_lines.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kBendingTolerance = 0.05;  // of a bending solve: block Gauss-Seidel is no better than that
enum Family { kWarp, kWeft, kFalling, kRising, kWarpBend, kWeftBend, kFamilies };

template <class Real>
int whole_registers(int count) {
  constexpr int kMost = SheetShape<Real>::kMargin;
  return (count + kMost - 1) / kMost * kMost;
}

/// In double precision: itself, or a copy in `to`.
Xyz<double> widened(const SheetShape<double>&, Xyz<double> from, const SheetShape<double>&, XyzArray<double>*) {
  return from;
}
Xyz<double> widened(const SheetShape<float>& s, Xyz<float> from, const SheetShape<double>& wide, XyzArray<double>* to) {
  const Xyz<double> out = to->data();
  for (int row = 0; row < s.rows; ++row) {
    const std::ptrdiff_t a = row * s.stride, b = row * wide.stride;
    std::copy_n(from.x + a, s.cols, out.x + b);
    std::copy_n(from.y + a, s.cols, out.y + b);
    std::copy_n(from.z + a, s.cols, out.z + b);
  }
  return out;
}

template <class Real>
void set_at(const Xyz<Real>& array, std::ptrdiff_t place, Real value) {
  array.x[place] = array.y[place] = array.z[place] = value;
}

}  // namespace

template <class Real>
SheetLines<Real>::SheetLines(const GridSheet& sheet, const std::vector<int>& held, LineSolve how)
    : rows_(sheet),
      exact_rows_(sheet),
      forces_(sheet_kernels(simd_level())),
      kernels_(line_kernels(simd_level(), Real())),
      how_(how),
      damped_(sheet.damping_time > 0.0),
      bends_(!sheet.bending.empty()),
      weights_(static_cast<size_t>(sheet.node_count()), -1.0),
      tensions_(kFamilies) {
  plain_.stride = rows_.shape().stride;
  turned_.stride = SheetShape<Real>::kMargin + whole_registers<Real>(sheet.rows);
  const auto lay_out = [](int rows, int width, Layout* layout) {
    const int padded = whole_registers<Real>(rows);
    for (auto* array : {&layout->x, &layout->base, &layout->pull}) *array = {padded, layout->stride};
    layout->weight = {padded, layout->stride};
    layout->keeps.assign(static_cast<size_t>(rows + width), 0);
  };
  lay_out(sheet.rows, 1, &plain_);
  lay_out(sheet.cols, 1, &turned_);
  if (bends_) {
    for (auto* array : {&y_, &bent_, &wr_, &step_, &next_}) *array = rows_.make_xyz();
    for (const GridStencil::Row& kind : sheet.bending.kind) {
      for (size_t col = 0; col < static_cast<size_t>(sheet.cols); ++col) {
        double sum = 0.0;
        for (const auto& coefficient : kind) sum += std::abs(coefficient[col]);
        stiffest_ = std::max(stiffest_, sum);
      }
    }
  }
  force_ = exact_rows_.make_xyz();
  if constexpr (!std::is_same_v<Real, double>) {
    wide_x_ = exact_rows_.make_xyz();
    if (damped_) wide_v_ = exact_rows_.make_xyz();
    if (bends_ && sheet.bending_damping > 0.0) wide_y_ = exact_rows_.make_xyz();
  }
  if (damped_) v_ = rows_.make_xyz();
  space_ = {1, LineMotion<Real>::kNumbers * kernels_.width * std::max(sheet.rows, sheet.cols)};
  for (size_t i = 0; i < held.size(); ++i) {
    const int node = held[i] - sheet.first_node;
    if (node < 0 || node >= sheet.node_count()) continue;
    const int row = node / sheet.cols, col = node % sheet.cols;
    plain_.keeps[static_cast<size_t>(row)] = turned_.keeps[static_cast<size_t>(col)] = 1;
    held_.push_back({static_cast<Eigen::Index>(i), node, rows_.place(node), col * turned_.stride + row, Vec3::Zero()});
  }
}

template <class Real>
void SheetLines<Real>::begin(const Nodes& y, const Nodes& base, const Eigen::VectorXd& weight, double tau) {
  tau_ = tau;
  fresh_ = true;
  rows_.load(y, plain_.x.data());
  if (damped_ || rows_.shape().bending_damping > Real(0)) rows_.load(base, plain_.base.data());
  if (damped_) {
    const Xyz<Real> from = plain_.base.data(), to = turned_.base.data();
    const SheetShape<Real>& s = rows_.shape();
    kernels_.transpose(from.x, plain_.stride, s.rows, s.cols, to.x, turned_.stride);
    kernels_.transpose(from.y, plain_.stride, s.rows, s.cols, to.y, turned_.stride);
    kernels_.transpose(from.z, plain_.stride, s.rows, s.cols, to.z, turned_.stride);
  }
  set_weights(weight);
  if (held_.empty()) return;
  for (const Held& held : held_) {
    set_at(plain_.pull.data(), held.place, Real(0));
    set_at(turned_.pull.data(), held.turned, Real(0));
  }
}

/// Mostly those of the last step.
template <class Real>
void SheetLines<Real>::set_weights(const Eigen::VectorXd& weight) {
  const double* from = weight.data() + rows_.first_node();
  if (std::equal(weights_.begin(), weights_.end(), from)) return;
  std::copy(from, from + weights_.size(), weights_.begin());
  largest_weight_ = *std::max_element(weights_.begin(), weights_.end());
  const int cols = rows_.shape().cols;
  for (int node = 0; node < rows_.node_count(); ++node) {
    const auto value = static_cast<Real>(from[node]);
    plain_.weight.data()[rows_.place(node)] = value;
    turned_.weight.data()[node % cols * turned_.stride + node / cols] = value;
  }
}

template <class Real>
void SheetLines<Real>::turn(Layout* from, int rows, int cols, Layout* to) {
  const Xyz<Real> a = from->x.data(), b = to->x.data();
  kernels_.transpose(a.x, from->stride, rows, cols, b.x, to->stride);
  kernels_.transpose(a.y, from->stride, rows, cols, b.y, to->stride);
  kernels_.transpose(a.z, from->stride, rows, cols, b.z, to->stride);
}

template <class Real>
void SheetLines<Real>::sweep(Last last) {
  const SheetShape<Real>& s = rows_.shape();
  if (s.shear_length > Real(0)) solve_diagonals(last);
  turn(&plain_, s.rows, s.cols, &turned_);
  if (s.has_flexion) {
    solve({kWarpBend, 2, s.cols, s.rows, s.warp_bend_along, s.warp_bend_across, s.warp_bend_length}, &turned_, last);
  }
  solve({kWarp, 1, s.cols, s.rows, s.warp_along, s.warp_across, s.warp_length}, &turned_, last);
  turn(&turned_, s.cols, s.rows, &plain_);
  if (s.has_flexion) {
    solve({kWeftBend, 2, s.rows, s.cols, s.weft_bend_along, s.weft_bend_across, s.weft_bend_length}, &plain_, last);
  }
  solve({kWeft, 1, s.rows, s.cols, s.weft_along, s.weft_across, s.weft_length}, &plain_, last);
  if (bends_) bend();
  fresh_ = false;
}

/// (1 / weight + K') z = f at what is left without bending, K' = (1 + bending_damping / tau) K.
template <class Real>
void SheetLines<Real>::bend() {
  const SheetShape<Real>& s = rows_.shape();
  const Xyz<Real> x = plain_.x.data(), wr = wr_.data();
  if (!fresh_) kernels_.add(s, bent_.data(), Real(-1), x);
  const double lag = static_cast<double>(s.bending_damping) / tau_;
  Xyz<Real> y = x;
  if (lag > 0.0) {
    y = y_.data();
    kernels_.extrapolate(s, x, plain_.base.data(), static_cast<Real>(lag), y);
  }
  const double most = (1.0 + lag) * stiffest_ * largest_weight_;
  const double theta = 1.0 + 0.5 * most, delta = 0.5 * most;
  BendingStep<Real> step{
      bent_.data(), wr,     step_.data(), next_.data(), plain_.weight.data(), static_cast<Real>(1.0 + lag),
      Real(0),      Real(0)};
  kernels_.bending_begin(s, y, static_cast<Real>(1.0 / theta), step);
  double rho = delta / theta;
  const int count = bending_steps(most);
  for (int k = 1; k < count; ++k) {
    const double next = 1.0 / (2.0 * theta / delta - rho);
    step.keep = static_cast<Real>(next * rho);
    step.gain = static_cast<Real>(2.0 * next / delta);
    rho = next;
    kernels_.bending_step(s, step);
    std::swap(step.z, step.next);
  }
  if (count % 2 == 0) std::swap(bent_, next_);
  for (Held& held : held_)
    held.bending = bending_at(held.node, y, 1.0) + bending_at(held.node, bent_.data(), 1.0 + lag);
  kernels_.add(s, bent_.data(), Real(1), x);
}

/// -factor K z of a node of the sheet.
template <class Real>
Vec3 SheetLines<Real>::bending_at(int node, const Xyz<Real>& z, double factor) const {
  const SheetShape<Real>& s = rows_.shape();
  const int row = node / s.cols, col = node % s.cols;
  Vec3 sum = Vec3::Zero();
  for (size_t k = 0; k < kStencilSize; ++k) {
    const std::ptrdiff_t at = (row + kStencil[k][0]) * s.stride + col + kStencil[k][1];
    const Real c = s.bending[row][static_cast<std::ptrdiff_t>(k) * s.stride + col];
    sum += static_cast<double>(c) *
           Vec3(static_cast<double>(z.x[at]), static_cast<double>(z.y[at]), static_cast<double>(z.z[at]));
  }
  return -factor * sum;
}

/// Of a Chebyshev iteration on the spectrum [1, 1 + most]: 2 ((r - 1) / (r + 1))^n, r = (1 + most)^(1/2).
template <class Real>
int SheetLines<Real>::bending_steps(double most) const {
  const double root = std::sqrt(1.0 + most), rate = (root - 1.0) / (root + 1.0);
  if (2.0 * rate <= kBendingTolerance) return 1;
  return static_cast<int>(std::ceil(std::log(0.5 * kBendingTolerance) / std::log(rate)));
}

template <class Real>
LineMotion<Real> SheetLines<Real>::motion(Layout* layout) {
  LineMotion<Real> motion{layout->x.data(), layout->weight.data(), {}, Real(0), layout->pull.data(), space_.data()};
  if (damped_) {
    motion.base = layout->base.data();
    motion.damping = static_cast<Real>(static_cast<double>(rows_.shape().damping_time) / tau_);
  }
  return motion;
}

template <class Real>
Real* SheetLines<Real>::tension(int family, Last last) {
  if (fresh_ && last == Last::kYes) return nullptr;
  RowArray<Real>& array = tensions_[static_cast<size_t>(family)];
  if (array.empty()) {
    const bool turned = family == kWarp || family == kWarpBend;
    array = RowArray<Real>(whole_registers<Real>(turned ? rows_.shape().cols : rows_.shape().rows),
                           turned ? turned_.stride : plain_.stride);
  }
  return array.data();
}

template <class Real>
void SheetLines<Real>::solve(const Straight& springs, Layout* layout, Last last) {
  GridLines<Real> lines{};
  lines.step = springs.apart * layout->stride;
  lines.along_step = springs.apart;
  lines.length = springs.length;
  lines.tension = tension(springs.family, last);
  const LineMotion<Real> moved = motion(layout);
  for (int begin = 0; begin < springs.apart; ++begin) {
    const int count = (springs.nodes - 1 - begin) / springs.apart;
    lines.along = springs.along + begin;
    lines.keeps = layout->keeps.data() + begin;
    for (int line = 0; line < springs.lines && count > 0; line += kernels_.width) {
      lines.across = springs.across + line;
      solve(lines, moved, begin * layout->stride + line, 0, count);
    }
  }
}

template <class Real>
void SheetLines<Real>::solve(const GridLines<Real>& lines, const LineMotion<Real>& moved, std::ptrdiff_t at, int first,
                             int last) const {
  if (how_ == LineSolve::kWhole) return kernels_.solve(lines, moved, at, first, last, fresh_);
  for (int odd : {0, 1}) {
    for (int k = first + (first + odd) % 2; k < last; k += 2) kernels_.solve(lines, moved, at, k, k + 1, fresh_);
  }
}

/// Falling lines are numbered by col - row, rising ones by col + row; a register has those whose number is first to
/// first + width - 1, in the rows in which one of them has a spring.
template <class Real>
void SheetLines<Real>::solve_diagonals(Last last) {
  const SheetShape<Real>& s = rows_.shape();
  const int width = kernels_.width;
  const LineMotion<Real> moved = motion(&plain_);
  GridLines<Real> lines{};
  lines.along = s.shear_rows;
  lines.along_step = 1;
  lines.length = s.shear_length;
  lines.keeps = plain_.keeps.data();
  lines.tension = tension(kFalling, last);
  lines.step = s.stride + 1;
  lines.across_step = 1;
  for (int first = -(s.rows - 2); first <= s.cols - 2; first += width) {
    lines.across = s.shear + first;
    solve(lines, moved, first, std::max(0, 1 - first - width), std::min(s.rows - 1, s.cols - 1 - first));
  }
  lines.tension = tension(kRising, last);
  lines.step = s.stride - 1;
  lines.across_step = -1;
  for (int first = 1; first <= s.rows + s.cols - 3; first += width) {
    lines.across = s.shear + first - 1;
    solve(lines, moved, first, std::max(0, first - s.cols + 1), std::min(s.rows - 1, first + width - 1));
  }
}

template <class Real>
Vec3 SheetLines<Real>::position(int node) {
  const std::ptrdiff_t at = rows_.place(node - rows_.first_node());
  const Xyz<Real> x = plain_.x.data();
  return {static_cast<double>(x.x[at]), static_cast<double>(x.y[at]), static_cast<double>(x.z[at])};
}

template <class Real>
void SheetLines<Real>::move_to(int node, const Vec3& position) {
  const std::ptrdiff_t at = rows_.place(node - rows_.first_node());
  const Xyz<Real> x = plain_.x.data();
  x.x[at] = static_cast<Real>(position[0]);
  x.y[at] = static_cast<Real>(position[1]);
  x.z[at] = static_cast<Real>(position[2]);
}

template <class Real>
void SheetLines<Real>::add_held_forces(Nodes* forces) {
  const Xyz<Real> here = plain_.pull.data(), there = turned_.pull.data();
  for (const Held& held : held_) {
    const std::ptrdiff_t a = held.place, b = held.turned;
    forces->col(held.column) += held.bending + Vec3(static_cast<double>(here.x[a]) + static_cast<double>(there.x[b]),
                                                    static_cast<double>(here.y[a]) + static_cast<double>(there.y[b]),
                                                    static_cast<double>(here.z[a]) + static_cast<double>(there.z[b]));
  }
}

template <class Real>
void SheetLines<Real>::add_forces(Nodes* forces) {
  const SheetShape<Real>& s = rows_.shape();
  const Xyz<Real> x = plain_.x.data(), base = plain_.base.data();
  Xyz<Real> y = x, v = x;
  if (bends_ && s.bending_damping > Real(0)) {
    y = y_.data();
    kernels_.extrapolate(s, x, base, static_cast<Real>(static_cast<double>(s.bending_damping) / tau_), y);
  }
  if (damped_) {
    v = v_.data();
    kernels_.rate(s, x, base, static_cast<Real>(1.0 / tau_), v);
  }
  const Xyz<double> wide_x = widened(s, x, exact_rows_.shape(), &wide_x_);
  const Xyz<double> wide_v = v.x == x.x ? wide_x : widened(s, v, exact_rows_.shape(), &wide_v_);
  const Xyz<double> wide_y = y.x == x.x ? wide_x : widened(s, y, exact_rows_.shape(), &wide_y_);
  forces_.forces(exact_rows_.shape(), wide_x, wide_v, wide_y, force_.data(), exact_rows_.scratch());
  exact_rows_.add(force_.data(), forces);
}

template class SheetLines<float>;
template class SheetLines<double>;

}  // namespace deformable_sim
