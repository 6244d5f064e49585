// The loop over elements, gathering, scattering and matrix slots, written once for every element type.
#pragma once

#include <array>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/energy.h"

namespace deformable_sim {

/// Whether E has a type Memory, see below.
template <class E, class = void>
struct HasMemory : std::false_type {};
template <class E>
struct HasMemory<E, std::void_t<typename E::Memory>> : std::true_type {};

/// Whether E knows how to take its tension from another state.
template <class E, class = void>
struct IsLaggable : std::false_type {};
template <class E>
struct IsLaggable<E, std::void_t<decltype(&E::lagged_stiffness)>> : std::true_type {};

/// Whether the energy of E may be below 0.
template <class E, class = void>
struct MayBeNegative : std::false_type {};
template <class E>
struct MayBeNegative<E, std::void_t<decltype(E::kMayBeNegative)>> : std::bool_constant<E::kMayBeNegative> {};

/// One element type E over many sets of nodes.
///
/// E is a pure function of a few points and provides
///   kPoints                       how many points
///   Rest, Parameters, Context     values per element, per term, and per evaluation: context(parameters, time)
/// and, when kPairwise (two points, dependence on differences d = x_b - x_a, w = v_b - v_a only, opposite forces),
///   energy(d, rest), force(d, w, rest) on point a, stiffness(d, w, rest, dx, dv, kind) = dx dF/dd + dv dF/dw, and,
///   where the tension may be another state's, lagged_stiffness(d, d there, rest, dx, dv);
/// otherwise
///   energy(x, rest) or energy(x, rest, context), force(x, v, rest, context), and either, when kUniform,
///     jacobian(x, v, rest, context, dx, dv) = dx df/dx + dv df/dv, exact, and
///     uniform_block(...), the one block that all pairs of points have in common in the projected Jacobian, or
///     jacobian(x, v, rest, context, dx, dv, kind), exact or projected.
/// An E that reads what the state remembers beside time, x and v has a type Memory, memory(state, rest), and takes one
/// as its last argument of energy and force and before dx of jacobian. Where the energy may be below 0 there is a
/// kMayBeNegative that is true.
template <class E>
class ElementEnergy : public Energy {
 public:
  static constexpr size_t kPoints = static_cast<size_t>(E::kPoints);
  using Points = Eigen::Matrix<double, 3, E::kPoints>;
  struct Element {
    std::array<int, kPoints> node;
    typename E::Rest rest;
  };

  ElementEnergy(std::string name, std::vector<Element> elements, typename E::Parameters parameters)
      : name_(std::move(name)), elements_(std::move(elements)), parameters_(std::move(parameters)) {}

  std::string name() const override { return name_; }
  int element_count() const override { return static_cast<int>(elements_.size()); }
  const std::vector<Element>& elements() const { return elements_; }

  bool may_be_negative() const override { return MayBeNegative<E>::value; }

  double value(const State& s) const override {
    [[maybe_unused]] const typename E::Context context = E::context(parameters_, s.time);
    double sum = 0.0;
    for (const Element& e : elements_) {
      if constexpr (E::kPairwise) {
        sum += E::energy(s.x.col(e.node[1]) - s.x.col(e.node[0]), e.rest);
      } else if constexpr (HasMemory<E>::value) {
        sum += E::energy(gather(s.x, e), e.rest, E::memory(s, e.rest));
      } else if constexpr (std::is_invocable_v<decltype(E::energy), Points, typename E::Rest>) {
        sum += E::energy(gather(s.x, e), e.rest);
      } else {
        sum += E::energy(gather(s.x, e), e.rest, context);
      }
    }
    return sum;
  }

  void add_force(const State& s, Nodes* f) const override {
    [[maybe_unused]] const typename E::Context context = E::context(parameters_, s.time);
    for (const Element& e : elements_) {
      if constexpr (E::kPairwise) {
        const int a = e.node[0], b = e.node[1];
        const Vec3 force = E::force(s.x.col(b) - s.x.col(a), s.v.col(b) - s.v.col(a), e.rest);
        f->col(a) += force;
        f->col(b) -= force;
      } else {
        const auto force = [&] {
          if constexpr (HasMemory<E>::value) {
            return E::force(gather(s.x, e), gather(s.v, e), e.rest, context, E::memory(s, e.rest));
          } else {
            return E::force(gather(s.x, e), gather(s.v, e), e.rest, context);
          }
        }();
        for (size_t k = 0; k < kPoints; ++k) f->col(e.node[k]) += force.col(static_cast<Eigen::Index>(k));
      }
    }
  }

  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override {
    for (const Element& e : elements_) {
      for (size_t i = 0; i < kPoints; ++i) {
        for (size_t j = 0; j < i; ++j) pairs->push_back({e.node[i], e.node[j]});
      }
    }
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.resize(elements_.size());
    for (size_t k = 0; k < elements_.size(); ++k) {
      const auto& node = elements_[k].node;
      for (size_t i = 0; i < kPoints; ++i) {
        for (size_t j = 0; j < kPoints; ++j) slots_[k][kPoints * i + j] = matrix.slot(node[i], node[j]);
      }
    }
  }

  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override {
    if constexpr (IsLaggable<E>::value) {
      if (kind == Jacobian::kLagged) {
        add_lagged_jacobian(s, dx, dv, a);
        return;
      }
    }
    [[maybe_unused]] const typename E::Context context = E::context(parameters_, s.time);
    for (size_t n = 0; n < elements_.size(); ++n) {
      const Element& e = elements_[n];
      const auto& slot = slots_[n];
      if constexpr (E::kPairwise) {
        const Vec3 d = s.x.col(e.node[1]) - s.x.col(e.node[0]), w = s.v.col(e.node[1]) - s.v.col(e.node[0]);
        add_pair(E::stiffness(d, w, e.rest, dx, dv, kind), slot, a);
      } else {
        const auto x = gather(s.x, e), v = gather(s.v, e);
        if constexpr (E::kUniform) {
          if (kind != Jacobian::kExact) {
            const Mat3 block = E::uniform_block(x, v, e.rest, context, dx, dv);
            for (int k : slot) a->block(k) -= block;
            continue;
          }
          subtract(E::jacobian(x, v, e.rest, context, dx, dv), slot, a);
        } else if constexpr (HasMemory<E>::value) {
          subtract(E::jacobian(x, v, e.rest, context, E::memory(s, e.rest), dx, dv, kind), slot, a);
        } else {
          subtract(E::jacobian(x, v, e.rest, context, dx, dv, kind), slot, a);
        }
      }
    }
  }

 protected:
  using Slots = std::array<int, kPoints * kPoints>;
  /// Of each element's blocks, by rows; once bound.
  const std::vector<Slots>& slots() const { return slots_; }

 private:
  void add_lagged_jacobian(const State& s, double dx, double dv, BlockMatrix* a) const {
    for (size_t n = 0; n < elements_.size(); ++n) {
      const Element& e = elements_[n];
      const Vec3 d = s.x.col(e.node[1]) - s.x.col(e.node[0]);
      const Vec3 before = s.x_before.col(e.node[1]) - s.x_before.col(e.node[0]);
      add_pair(E::lagged_stiffness(d, before, e.rest, dx, dv), slots_[n], a);
    }
  }

  static void add_pair(const Mat3& h, const std::array<int, kPoints * kPoints>& slot, BlockMatrix* a) {
    a->block(slot[0]) += h;
    a->block(slot[1]) -= h;
    a->block(slot[2]) -= h;
    a->block(slot[3]) += h;
  }

  template <class Blocks>
  static void subtract(const Blocks& blocks, const std::array<int, kPoints * kPoints>& slot, BlockMatrix* a) {
    for (size_t i = 0; i < kPoints; ++i) {
      for (size_t j = 0; j < kPoints; ++j) {
        a->block(slot[kPoints * i + j]) -=
            blocks.template block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j));
      }
    }
  }

  static Points gather(const Nodes& nodes, const Element& e) {
    Points points;
    for (size_t k = 0; k < kPoints; ++k) points.col(static_cast<Eigen::Index>(k)) = nodes.col(e.node[k]);
    return points;
  }

  std::string name_;
  std::vector<Element> elements_;
  typename E::Parameters parameters_;
  std::vector<Slots> slots_;  // parallel to elements_, once bound
};

}  // namespace deformable_sim
