#include "deformable_sim/core/integrator/sheet_motion.h"

namespace deformable_sim {

template <class Real>
SheetMotion<Real>::SheetMotion(const GridSheet& sheet, const Eigen::VectorXd& mass, const std::vector<int>& held)
    : rows_(sheet),
      kernels_(sheet_kernels(simd_level(), Real())),
      x_(rows_.make_xyz()),
      v_(rows_.make_xyz()),
      force_(rows_.make_xyz()),
      gain_(rows_.make_array()),
      free_(rows_.make_array()),
      keeps_(static_cast<size_t>(sheet.rows), 0) {
  if (sheet.bending_damping > 0.0 && !sheet.bending.empty()) y_ = rows_.make_xyz();
  for (int k = 0; k < rows_.node_count(); ++k) {
    gain_.data()[rows_.place(k)] = static_cast<Real>(1.0 / mass[sheet.first_node + k]);
    free_.data()[rows_.place(k)] = Real(1);
  }
  for (size_t i = 0; i < held.size(); ++i) {
    if (!contains(held[i])) continue;
    const int node = held[i] - sheet.first_node;
    const std::ptrdiff_t place = rows_.place(node);
    held_.push_back({static_cast<Eigen::Index>(i), place});
    keeps_[static_cast<size_t>(node / sheet.cols)] = 1;
    gain_.data()[place] = free_.data()[place] = Real(0);
  }
}

template <class Real>
void SheetMotion<Real>::load(const Nodes& x, const Nodes& v) {
  rows_.load(x, x_.data());
  rows_.load(v, v_.data());
  if (y_.empty()) return;
  const Xyz<Real> from = x_.data(), rate = v_.data(), to = y_.data();
  const Real damping = rows_.shape().bending_damping;
  for (int k = 0; k < rows_.node_count(); ++k) {
    const std::ptrdiff_t at = rows_.place(k);
    to.x[at] = from.x[at] + damping * rate.x[at];
    to.y[at] = from.y[at] + damping * rate.y[at];
    to.z[at] = from.z[at] + damping * rate.z[at];
  }
}

template <class Real>
void SheetMotion<Real>::store(Nodes* x, Nodes* v) {
  rows_.store(x_.data(), x);
  rows_.store(v_.data(), v);
}

template <class Real>
void SheetMotion<Real>::get(int node, Vec3* x, Vec3* v) {
  const std::ptrdiff_t at = rows_.place(node - rows_.first_node());
  const Xyz<Real> from = x_.data(), rate = v_.data();
  *x = Vec3(static_cast<double>(from.x[at]), static_cast<double>(from.y[at]), static_cast<double>(from.z[at]));
  *v = Vec3(static_cast<double>(rate.x[at]), static_cast<double>(rate.y[at]), static_cast<double>(rate.z[at]));
}

template <class Real>
void SheetMotion<Real>::set(int node, const Vec3& x, const Vec3& v) {
  const std::ptrdiff_t at = rows_.place(node - rows_.first_node());
  const auto put = [at](const Xyz<Real>& to, const Vec3& value) {
    to.x[at] = static_cast<Real>(value[0]);
    to.y[at] = static_cast<Real>(value[1]);
    to.z[at] = static_cast<Real>(value[2]);
  };
  put(x_.data(), x);
  put(v_.data(), v);
  if (!y_.empty()) put(y_.data(), x + static_cast<double>(rows_.shape().bending_damping) * v);
}

template <class Real>
void SheetMotion<Real>::leap(double kick, double drift, const MassForce& everywhere, const Nodes* more) {
  const double half = 0.5 * everywhere.rate * kick;
  SheetLeap<Real> leap{};
  leap.x = x_.data();
  leap.v = v_.data();
  leap.y = y_.empty() ? leap.x : y_.data();
  leap.gain = gain_.data();
  leap.free = free_.data();
  leap.keep = static_cast<Real>((1.0 - half) / (1.0 + half));
  leap.kick = static_cast<Real>(kick / (1.0 + half));
  leap.drift = static_cast<Real>(drift);
  for (int k = 0; k < 3; ++k) leap.gravity[k] = static_cast<Real>(everywhere.acceleration[k]);
  if (more != nullptr) {
    if (more_.empty()) more_ = rows_.make_xyz();
    leap.more = more_.data();
    rows_.load(*more, leap.more);
  }
  leap.force = force_.data();
  leap.keeps = keeps_.data();
  kernels_.leap(rows_.shape(), leap, rows_.scratch());
}

template <class Real>
void SheetMotion<Real>::add_held_forces(double weight, Nodes* forces) {
  const Xyz<Real> from = force_.data();
  for (const Held& held : held_) {
    const std::ptrdiff_t at = held.place;
    forces->col(held.column) += weight * Vec3(static_cast<double>(from.x[at]), static_cast<double>(from.y[at]),
                                              static_cast<double>(from.z[at]));
  }
}

template class SheetMotion<float>;
template class SheetMotion<double>;

}  // namespace deformable_sim
