#include "deformable_sim/core/integrator/mesh_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {
namespace {

std::vector<MeshSpring> mesh_springs(const std::vector<KnownSpring>& springs) {
  std::vector<MeshSpring> all;
  all.reserve(springs.size());
  for (const KnownSpring& s : springs) all.push_back({s.a, s.b, s.length, s.stiffness, s.damping});
  return all;
}

}  // namespace

template <class Real>
MeshMotion<Real>::MeshMotion(const SpringTerms& terms, const Eigen::VectorXd& mass, const std::vector<int>& held,
                             const LinkSplit& split, SimdLevel level)
    : kernels_(mesh_kernels(level, Real())),
      packets_(mass, mesh_springs(terms.springs), terms.links, split, kernels_.width),
      link_terms_(terms.link_terms),
      x_(packets_.template make_coordinates<Position>()),
      x_points_(packets_.template make_points<Position>()),
      v_(packets_.template make_coordinates<Real>()),
      gain_(packets_.make_numbers()),
      keeps_(static_cast<size_t>(packets_.shape().packets), 0) {
  if (packets_.shape().springs.damping != nullptr) v_points_ = packets_.template make_points<Real>();
  if (has_links()) {
    y_points_ = packets_.template make_points<Real>();
    rate_ = packets_.template make_coordinates<Real>();
    mark_fast();
    if (PositionUnit<Real>::kCounts) {
      start_ = packets_.template make_coordinates<Position>();
      bent_ = packets_.template make_coordinates<Real>();
    }
  }
  for (const KnownSpring& s : terms.springs) longest_ = std::max(longest_, s.length);
  for (size_t k = 0; k < packets_.nodes().size(); ++k)
    gain_.data()[k] = static_cast<Real>(1.0 / mass[packets_.nodes()[k]]);
  for (size_t i = 0; i < held.size(); ++i) {
    const int index = packets_.index(held[i]);
    if (index < 0) continue;
    held_.push_back({static_cast<Eigen::Index>(i), packets_.place(index)});
    keeps_[static_cast<size_t>(index / packets_.width())] = 1;
    gain_.data()[index] = Real(0);
  }
  if (!held_.empty()) force_ = packets_.template make_coordinates<Real>();
}

template <class Real>
void MeshMotion<Real>::mark_fast() {
  const MeshEntries<Real>& fast = packets_.shape().fast_links;
  leans_.assign(keeps_.size(), 0);
  const int last = fast.start[packets_.shape().packets] * packets_.width();
  for (int k = 0; k < last; ++k) leans_[static_cast<size_t>(fast.place[k] / 4 / packets_.width())] = 1;
}

template <class Real>
void MeshMotion<Real>::load(const State& s, double dt) {
  if (PositionUnit<Real>::kCounts) {
    const auto count = static_cast<Eigen::Index>(packets_.nodes().size());
    mine_.x.resize(3, count);
    mine_.v.resize(3, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      mine_.x.col(k) = s.x.col(packets_.nodes()[static_cast<size_t>(k)]);
      mine_.v.col(k) = s.v.col(packets_.nodes()[static_cast<size_t>(k)]);
    }
    unit_.choose(mine_.x, mine_.v, dt, longest_);
  }
  const int width = packets_.width();
  for (size_t k = 0; k < packets_.nodes().size(); ++k) {
    const int node = packets_.nodes()[k];
    const std::ptrdiff_t place = packets_.place(static_cast<int>(k));
    for (int d = 0; d < 3; ++d) {
      x_.data()[place + d * width] = unit_.counted(s.x(d, node), d);
      v_.data()[place + d * width] = static_cast<Real>(s.v(d, node));
    }
  }
  kernels_.begin(packets_.shape(), numbers());
  if (has_links()) rate_.clear();
  if (PositionUnit<Real>::kCounts && has_links()) find_bent(s);
}

/// start_ and bent_.
template <class Real>
void MeshMotion<Real>::find_bent(const State& s) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(packets_.shape().packets) * 3 * packets_.width();
  std::copy(x_.data(), x_.data() + count, start_.data());
  still_.x = s.x;
  still_.v.setZero(3, s.x.cols());
  bending_.setZero(3, s.x.cols());
  for (const Energy* term : link_terms_) term->add_force(still_, &bending_);
  for (size_t k = 0; k < packets_.nodes().size(); ++k) {
    const std::ptrdiff_t place = packets_.place(static_cast<int>(k));
    for (int d = 0; d < 3; ++d) {
      bent_.data()[place + d * packets_.width()] = static_cast<Real>(bending_(d, packets_.nodes()[k]));
    }
  }
}

template <class Real>
void MeshMotion<Real>::store(Nodes* x, Nodes* v) {
  const int width = packets_.width();
  double fastest = 0.0;
  for (size_t k = 0; k < packets_.nodes().size(); ++k) {
    const int node = packets_.nodes()[k];
    const std::ptrdiff_t place = packets_.place(static_cast<int>(k));
    for (int d = 0; d < 3; ++d) {
      (*x)(d, node) = unit_.position(x_.data()[place + d * width], d);
      const auto speed = static_cast<double>(v_.data()[place + d * width]);
      (*v)(d, node) = speed;
      fastest = std::max(fastest, std::abs(speed));
    }
  }
  if (unit_.may_have_left(fastest)) (*x)(0, packets_.nodes().front()) = std::numeric_limits<double>::quiet_NaN();
}

template <class Real>
void MeshMotion<Real>::get(int node, Vec3* x, Vec3* v) {
  const std::ptrdiff_t place = packets_.place(packets_.index(node));
  for (int d = 0; d < 3; ++d) {
    (*x)[d] = unit_.position(x_.data()[place + d * packets_.width()], d);
    (*v)[d] = static_cast<double>(v_.data()[place + d * packets_.width()]);
  }
}

template <class Real>
void MeshMotion<Real>::set(int node, const Vec3& x, const Vec3& v) {
  const int index = packets_.index(node);
  const std::ptrdiff_t place = packets_.place(index);
  for (int d = 0; d < 3; ++d) {
    const Position there = unit_.counted(x[d], d);
    x_.data()[place + d * packets_.width()] = x_points_.data()[4 * index + d] = there;
    v_.data()[place + d * packets_.width()] = static_cast<Real>(v[d]);
    if (!v_points_.empty()) v_points_.data()[4 * index + d] = static_cast<Real>(v[d]);
  }
}

template <class Real>
MeshLeap<Real> MeshMotion<Real>::numbers() {
  MeshLeap<Real> leap{};
  leap.x = x_.data();
  leap.x_points = x_points_.data();
  leap.unit = static_cast<Real>(unit_.unit());
  leap.per_unit = static_cast<Real>(unit_.per_unit());
  leap.v = v_.data();
  leap.v_points = v_points_.empty() ? nullptr : v_points_.data();
  leap.start = start_.empty() ? nullptr : start_.data();
  leap.y_points = y_points_.empty() ? nullptr : y_points_.data();
  leap.bent = bent_.empty() ? nullptr : bent_.data();
  leap.gain = gain_.data();
  leap.force = force_.empty() ? nullptr : force_.data();
  leap.keeps = keeps_.data();
  return leap;
}

template <class Real>
void MeshMotion<Real>::leap(double kick, double slow_kick, double drift, const MassForce& everywhere, const Nodes* more,
                            Nodes* impulses) {
  const double half = 0.5 * everywhere.rate * kick;
  MeshLeap<Real> leap = numbers();
  leap.lost = static_cast<Real>(2.0 * half / (1.0 + half));
  leap.kick = static_cast<Real>(kick / (1.0 + half));
  for (int d = 0; d < 3; ++d) leap.gravity[d] = static_cast<Real>(everywhere.acceleration[d]);
  if (more != nullptr) {
    if (more_.empty()) more_ = packets_.template make_coordinates<Real>();
    leap.more = more_.data();
    for (size_t k = 0; k < packets_.nodes().size(); ++k) {
      const std::ptrdiff_t place = packets_.place(static_cast<int>(k));
      for (int d = 0; d < 3; ++d) {
        more_.data()[place + d * packets_.width()] = static_cast<Real>((*more)(d, packets_.nodes()[k]));
      }
    }
  }
  const MeshShape<Real>& shape = packets_.shape();
  if (has_links()) {
    const bool slow = slow_kick != 0.0;
    leap.leans = slow ? nullptr : leans_.data();
    leap.rate = slow ? rate_.data() : nullptr;
    leap.ahead = static_cast<Real>(0.5 * slow_kick);
    kernels_.lean(shape, leap);
  }
  kernels_.pull(shape, leap);
  add_held_forces(kick, impulses);
  if (has_links()) {
    if (slow_kick != 0.0) bend(shape.slow_links, slow_kick, half, leap, impulses);
    leap.rate = nullptr;
    bend(shape.fast_links, kick, half, leap, impulses);
  }
  if (drift != 0.0) {
    leap.drift = static_cast<Real>(drift);
    kernels_.drift(shape, leap);
  }
}

template <class Real>
void MeshMotion<Real>::bend(const MeshEntries<Real>& links, double kick, double half, MeshLeap<Real> leap,
                            Nodes* impulses) {
  leap.kick = static_cast<Real>(kick / (1.0 + half));
  kernels_.bend(packets_.shape(), links, leap);
  add_held_forces(kick, impulses);
}

template <class Real>
void MeshMotion<Real>::add_held_forces(double weight, Nodes* impulses) const {
  for (const Held& held : held_) {
    for (int d = 0; d < 3; ++d) {
      (*impulses)(d, held.column) += weight * static_cast<double>(force_.data()[held.place + d * packets_.width()]);
    }
  }
}

template class MeshMotion<float>;
template class MeshMotion<double>;

}  // namespace deformable_sim
