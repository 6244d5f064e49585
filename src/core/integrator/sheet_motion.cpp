#include "deformable_sim/core/integrator/sheet_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {
namespace {

/// Nothing is added up over rows, so that there may be as few bands as threads.
Bands bands_of(const GridSheet& sheet, const Workers* workers) {
  const int threads = workers != nullptr ? workers->threads() : 1;
  return {sheet.rows, std::min(Bands::of(sheet.rows, sheet.cols).count(), threads)};
}

}  // namespace

template <class Real>
SheetMotion<Real>::SheetMotion(const GridSheet& sheet, const Eigen::VectorXd& mass, const std::vector<int>& held,
                               SimdLevel level, const Workers* workers)
    : kernels_(motion_kernels(level, Real())),
      rows_(sheet, kernels_.width),
      bands_(bands_of(sheet, workers), workers),
      x_(rows_.template make_points<Position>()),
      v_(rows_.template make_points<Real>()),
      gain_(rows_.make_numbers()),
      passed_(rows_.make_rows(bands_.scratch_count())),
      row_{rows_.make_rows(bands_.scratch_count()), rows_.make_rows(bands_.scratch_count()),
           rows_.make_rows(bands_.scratch_count())},
      longest_(std::max(
          {sheet.warp.length, sheet.weft.length, sheet.shear_length, sheet.warp_bend.length, sheet.weft_bend.length})),
      keeps_(static_cast<size_t>(sheet.rows), 0) {
  if (!sheet.bending.empty()) {
    y_ = rows_.template make_points<Real>();
    if (kCounts) {
      start_ = rows_.template make_points<Position>();
      bent_ = rows_.template make_points<Real>();
    }
  }
  for (int k = 0; k < rows_.node_count(); ++k) {
    gain_.data()[rows_.number_place(k)] = static_cast<Real>(1.0 / mass[sheet.first_node + k]);
  }
  for (size_t i = 0; i < held.size(); ++i) {
    if (!contains(held[i])) continue;
    const int node = held[i] - sheet.first_node;
    held_.push_back({static_cast<Eigen::Index>(i), rows_.place(node)});
    keeps_[static_cast<size_t>(node / sheet.cols)] = 1;
    gain_.data()[rows_.number_place(node)] = Real(0);
  }
  if (!held_.empty() || bands_.apart()) force_ = rows_.template make_points<Real>();
}

template <class Real>
void SheetMotion<Real>::put(std::ptrdiff_t place, std::ptrdiff_t own, const Vec3& x, const Vec3& v) {
  const double lag = static_cast<double>(rows_.shape().bending_damping);
  for (int d = 0; d < 3; ++d, place += rows_.width(), own += rows_.width()) {
    x_.data()[place] = unit_.counted(x[d], d);
    v_.data()[place] = static_cast<Real>(v[d]);
    if (y_.empty()) continue;
    const Position from = kCounts ? start_.data()[own] : Position(0);
    y_.data()[place] = static_cast<Real>(x_.data()[place] - from) + static_cast<Real>(lag * v[d] * unit_.per_unit());
  }
}

template <class Real>
void SheetMotion<Real>::load(const Nodes& x, const Nodes& v, double dt) {
  unit_.choose(x.middleCols(rows_.first_node(), rows_.node_count()),
               v.middleCols(rows_.first_node(), rows_.node_count()), dt, longest_);
  const double *from = x.data() + 3 * rows_.first_node(), *rate = v.data() + 3 * rows_.first_node();
  Position* to = x_.data();
  Real* to_v = v_.data();
  const int width = rows_.width();
  rows_.for_each_node([&](int, std::ptrdiff_t place) {
    for (int d = 0; d < 3; ++d) {
      to[place + d * width] = unit_.counted(*from++, d);
      to_v[place + d * width] = static_cast<Real>(*rate++);
    }
  });
  kernels_.begin(rows_.shape(), numbers());
}

template <class Real>
void SheetMotion<Real>::store(Nodes* x, Nodes* v) {
  double *to = x->data() + 3 * rows_.first_node(), *to_v = v->data() + 3 * rows_.first_node();
  const Real* rate = v_.data();
  const int width = rows_.width();
  double fastest = 0.0;
  rows_.for_each_node([&](int, std::ptrdiff_t place) {
    for (int d = 0; d < 3; ++d) {
      *to++ = unit_.position(x_.data()[place + d * width], d);
      const auto speed = static_cast<double>(rate[place + d * width]);
      *to_v++ = speed;
      fastest = std::max(fastest, std::abs(speed));
    }
  });
  if (unit_.may_have_left(fastest)) to[-1] = std::numeric_limits<double>::quiet_NaN();
}

template <class Real>
void SheetMotion<Real>::get(int node, Vec3* x, Vec3* v) {
  const std::ptrdiff_t place = rows_.place(node - rows_.first_node());
  for (int d = 0; d < 3; ++d) {
    (*x)[d] = unit_.position(x_.data()[place + d * rows_.width()], d);
    (*v)[d] = static_cast<double>(v_.data()[place + d * rows_.width()]);
  }
}

template <class Real>
void SheetMotion<Real>::set(int node, const Vec3& x, const Vec3& v) {
  const std::ptrdiff_t own = rows_.place(node - rows_.first_node());
  rows_.for_each_place(node - rows_.first_node(), [&](std::ptrdiff_t place) { put(place, own, x, v); });
}

template <class Real>
MotionLeap<Real> SheetMotion<Real>::numbers() {
  MotionLeap<Real> leap{};
  leap.x = x_.data();
  leap.unit = static_cast<Real>(unit_.unit());
  leap.v = v_.data();
  leap.start = start_.empty() ? nullptr : start_.data();
  leap.y = y_.empty() ? nullptr : y_.data();
  leap.bent = bent_.empty() ? nullptr : bent_.data();
  leap.gain = gain_.data();
  leap.force = force_.empty() ? nullptr : force_.data();
  leap.keeps = keeps_.data();
  for (size_t k = 0; k < row_.size(); ++k) leap.rows[k] = row_[k].data();
  leap.passed = passed_.data();
  return leap;
}

template <class Real>
void SheetMotion<Real>::leap(double kick, double drift, const MassForce& everywhere, const Nodes* more) {
  const double half = 0.5 * everywhere.rate * kick;
  MotionLeap<Real> leap = numbers();
  leap.lost = static_cast<Real>(2.0 * half / (1.0 + half));
  leap.kick = static_cast<Real>(kick / (1.0 + half));
  leap.drift = static_cast<Real>(drift);
  for (int k = 0; k < 3; ++k) leap.gravity[k] = static_cast<Real>(everywhere.acceleration[k]);
  if (more != nullptr) {
    if (more_.empty()) more_ = rows_.template make_points<Real>();
    leap.more = more_.data();
    const double* from = more->data() + 3 * rows_.first_node();
    rows_.for_each_node([&](int, std::ptrdiff_t place) {
      for (int d = 0; d < 3; ++d) more_.data()[place + d * rows_.width()] = static_cast<Real>(*from++);
    });
  }
  if (!bands_.apart()) return kernels_.leap(rows_.shape(), leap);
  bands_.run([&](const RowBand& rows, int scratch) {
    MotionLeap<Real> own = leap;
    for (Real*& row : own.rows) row += scratch * rows_.shape().stride;
    own.passed += scratch * rows_.shape().stride;
    kernels_.leap_band(rows_.shape(), own, rows);
  });
  bands_.run([&](const RowBand& rows, int) { kernels_.move_edges(rows_.shape(), leap, rows); });
}

template <class Real>
void SheetMotion<Real>::add_held_forces(double weight, Nodes* forces) {
  for (const Held& held : held_) {
    for (int d = 0; d < 3; ++d) {
      (*forces)(d, held.column) += weight * static_cast<double>(force_.data()[held.place + d * rows_.width()]);
    }
  }
}

template class SheetMotion<float>;
template class SheetMotion<double>;

}  // namespace deformable_sim
