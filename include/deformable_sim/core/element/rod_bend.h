// Curvature at a joint of a rod, seen by the material directors of one of its two segments.
#pragma once

#include <array>

#include "deformable_sim/core/element/rod_strain.h"

namespace deformable_sim {

/// Discrete curvature of two unit tangents that make the angle phi, along t_a x t_b:
///
///   k = g(c) t_a x t_b,   c = 1 + t_a . t_b,   g = 2/3 (1 / c + sqrt(2 / c)),   |k| = (2 tan(phi/2) + 4 sin(phi/2)) /
///   3
///
/// |k| = phi + phi^5 / 320: fourth order, where the usual 2 tan(phi/2) [Bergou 2008] is second; like that one it has no
/// bound as the rod folds back (phi -> pi).
struct RodCurvature {
  double g, dg, ddg;  // g(c) and its derivatives with respect to c

  RodCurvature(const Vec3& a, const Vec3& b) {
    const double i = 1.0 / one_plus_cosine(a, b), root = std::sqrt(2.0 * i);
    g = 2.0 / 3.0 * (i + root);
    dg = -2.0 / 3.0 * i * (i + 0.5 * root);
    ddg = 2.0 / 3.0 * i * i * (2.0 * i + 0.75 * root);
  }

  /// |k| of a turn by phi, rad.
  static double of_turn(double phi) { return (2.0 * std::tan(0.5 * phi) + 4.0 * std::sin(0.5 * phi)) / 3.0; }
};

/// p = s . P(t0, t) d: the other tangent's component along a director d that is carried from the tangent t0 to t.
///
///   p = s.d - (s.t + s.t0) (t.d) / n,   n = 1 + t.t0
struct CarriedComponent {
  Vec3 t, s, t0, d;
  double n, sum, along;  // n, s.(t + t0), t.d
  double value;
  Vec3 by_s, by_t;

  CarriedComponent(const Vec3& tangent, const Vec3& other, const Vec3& tangent_before, const Vec3& director)
      : t(tangent), s(other), t0(tangent_before), d(director) {
    n = one_plus_cosine(t, t0);
    sum = s.dot(t) + s.dot(t0);
    along = t.dot(d);
    by_s = d - (along / n) * (t + t0);
    by_t = -(along * s + sum * d - (sum * along / n) * t0) / n;
    value = s.dot(by_s);
  }

  Mat3 by_s_t() const { return -((t + t0) / n) * (d - (along / n) * t0).transpose() - (along / n) * Mat3::Identity(); }
  Mat3 by_t_t() const {
    const Vec3 mixed = along * s + sum * d;
    return (t0 * mixed.transpose() + mixed * t0.transpose()) / (n * n) - (s * d.transpose() + d * s.transpose()) / n -
           (2.0 * sum * along / (n * n * n)) * t0 * t0.transpose();
  }
};

/// The components of k along the two material directors of the segment with tangent t, the other tangent being s:
///
///   k . m_1 = -sign g s.m_2,   k . m_2 = sign g s.m_1,   sign = +1 when k = g t x s, -1 when k = g s x t,
///
/// since k is normal to both tangents. The directors are carried from (t0, d_1, d_2), already turned by the segment's
/// angle, and turning on exchanges them: d m_1 / d angle = m_2, d m_2 / d angle = -m_1.
class RodCurvaturePair {
 public:
  RodCurvaturePair(const RodCurvature& k, double sign, const CarriedComponent& along_1, const CarriedComponent& along_2)
      : k_(k), factor_{-sign, sign}, component_{&along_2, &along_1} {}

  /// i = 0: along m_1, 1: along m_2.
  double value(size_t i) const { return factor_[i] * k_.g * component_[i]->value; }
  Vec3 by_tangent(size_t i) const {
    const CarriedComponent& p = *component_[i];
    return factor_[i] * (k_.dg * p.value * p.s + k_.g * p.by_t);
  }
  Vec3 by_other(size_t i) const {
    const CarriedComponent& p = *component_[i];
    return factor_[i] * (k_.dg * p.value * p.t + k_.g * p.by_s);
  }
  double by_angle(size_t i) const { return i == 0 ? value(1) : -value(0); }

  Mat3 by_tangent_twice(size_t i) const {
    const CarriedComponent& p = *component_[i];
    return factor_[i] * (k_.ddg * p.value * p.s * p.s.transpose() +
                         k_.dg * (p.s * p.by_t.transpose() + p.by_t * p.s.transpose()) + k_.g * p.by_t_t());
  }
  Mat3 by_other_twice(size_t i) const {
    const CarriedComponent& p = *component_[i];
    return factor_[i] *
           (k_.ddg * p.value * p.t * p.t.transpose() + k_.dg * (p.t * p.by_s.transpose() + p.by_s * p.t.transpose()));
  }
  Mat3 by_other_and_tangent(size_t i) const {
    const CarriedComponent& p = *component_[i];
    return factor_[i] * (k_.ddg * p.value * p.t * p.s.transpose() + k_.dg * p.value * Mat3::Identity() +
                         k_.dg * (p.t * p.by_t.transpose() + p.by_s * p.s.transpose()) + k_.g * p.by_s_t());
  }
  Vec3 by_tangent_and_angle(size_t i) const { return i == 0 ? by_tangent(1) : Vec3(-by_tangent(0)); }
  Vec3 by_other_and_angle(size_t i) const { return i == 0 ? by_other(1) : Vec3(-by_other(0)); }
  double by_angle_twice(size_t i) const { return -value(i); }

 private:
  const RodCurvature& k_;
  std::array<double, 2> factor_;
  std::array<const CarriedComponent*, 2> component_;
};

}  // namespace deformable_sim
