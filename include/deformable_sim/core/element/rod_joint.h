// Bending and twisting of a rod at the node between two of its segments: three points and two angles.
#pragma once

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/element/rod_bend.h"
#include "deformable_sim/core/element/rod_twist.h"

namespace deformable_sim {

/// Five strains e of a joint: the curvature k along the material directors m_1, m_2 of the segment before it (a) and of
/// the one behind it (b), and the twist m.
///
///   E = sum_i w_i/2 (e_i - rest_i)^2,   force = -sum_i w_i (e_i - rest_i + damping de_i/dt) grad e_i,
///
/// w = B_1/2l, B_2/2l, the same again, C/l; l is half the length of both segments. Averaging the energy, not the
/// directors, leaves a rod of equal B_1 = B_2 equally stiff however far it is twisted [Bergou 2008].
/// Positions are the columns x_0, x_1, x_2; the angles are the x coordinates of two further columns, divided by the
/// radius of gyration. Damping is zero in rigid motion, in which an angle turns at omega . t.
/// The reference directors are those stored with the last step's tangents, carried along: within a step E is a function
/// of positions and angles alone, and the Jacobian is its exact second derivative. What this leaves out: gyroscopic
/// forces of spinning segments (rho I omega, of the order of the radius over the length).
/// Not good at: more than about a radian of bend per joint, or nearly half a turn of twist with B_1 != B_2.
struct RodJoint {
  static constexpr int kPoints = 5;
  static constexpr bool kPairwise = false;
  static constexpr bool kUniform = false;
  static constexpr size_t kStrains = 5;
  using Points = Eigen::Matrix<double, 3, 5>;
  using Blocks = Eigen::Matrix<double, 15, 15>;

  struct Rest {
    std::array<double, kStrains> strain;  // rad
    std::array<double, kStrains> weight;  // N m
    double damping;                       // s
    double radius_of_gyration;            // m
    int segment_a, segment_b;             // of State's frames
  };
  struct Parameters {};
  struct Context {};
  static Context context(const Parameters&, double /*time*/) { return {}; }

  /// What the state remembers of the two segments.
  struct Memory {
    Vec3 tangent_a, director_a, tangent_b, director_b;
    double reference_twist;
  };
  template <class State>
  static Memory memory(const State& s, const Rest& rest) {
    return {s.tangents.col(rest.segment_a), s.directors.col(rest.segment_a), s.tangents.col(rest.segment_b),
            s.directors.col(rest.segment_b), s.reference_twists[rest.segment_a]};
  }

  /// Material frame of a segment as stored: the reference director and tangent x director, turned by the angle.
  struct Directors {
    Vec3 d_1, d_2;
    Directors(const Vec3& tangent, const Vec3& director, double angle) {
      const Vec3 normal = tangent.cross(director);
      const double c = std::cos(angle), s = std::sin(angle);
      d_1 = c * director + s * normal;
      d_2 = c * normal - s * director;
    }
  };

  /// Everything the strains at one state are made of.
  struct Shape {
    RodSegment a, b;
    double angle_a, angle_b;
    Directors of_a, of_b;
    RodCurvature curvature;
    CarriedComponent a_1, a_2, b_1, b_2;
    RodCurvaturePair by_a, by_b;
    RodTwist twist;

    Shape(const Points& x, const Rest& rest, const Memory& memory)
        : a(x.col(1) - x.col(0), memory.tangent_a),
          b(x.col(2) - x.col(1), memory.tangent_b),
          angle_a(x(0, 3) / rest.radius_of_gyration),
          angle_b(x(0, 4) / rest.radius_of_gyration),
          of_a(memory.tangent_a, memory.director_a, angle_a),
          of_b(memory.tangent_b, memory.director_b, angle_b),
          curvature(a.tangent, b.tangent),
          a_1(a.tangent, b.tangent, memory.tangent_a, of_a.d_1),
          a_2(a.tangent, b.tangent, memory.tangent_a, of_a.d_2),
          b_1(b.tangent, a.tangent, memory.tangent_b, of_b.d_1),
          b_2(b.tangent, a.tangent, memory.tangent_b, of_b.d_2),
          by_a(curvature, 1.0, a_1, a_2),
          by_b(curvature, -1.0, b_1, b_2),
          twist(a.tangent, memory.tangent_a, b.tangent, memory.tangent_b) {}
    Shape(const Shape&) = delete;  // its parts refer to each other
    Shape& operator=(const Shape&) = delete;

    std::array<double, kStrains> strains(const Memory& m) const {
      const double reference =
          RodTwist::reference(a.tangent, transported(m.director_a, m.tangent_a, a.tangent), b.tangent,
                              transported(m.director_b, m.tangent_b, b.tangent), m.reference_twist);
      return {by_a.value(0), by_a.value(1), by_b.value(0), by_b.value(1), angle_b - angle_a + reference};
    }
    RodGradient gradient(size_t i) const {
      if (i < 2) return {by_a.by_tangent(i), by_a.by_other(i), by_a.by_angle(i), 0.0};
      if (i < 4) return {by_b.by_other(i - 2), by_b.by_tangent(i - 2), 0.0, by_b.by_angle(i - 2)};
      return twist.gradient();
    }
    /// Of the strains, where the points move with v.
    std::array<double, kStrains> rates(const Points& v, const Rest& rest) const {
      const Vec3 turn_a = a.by_edge(v.col(1) - v.col(0)), turn_b = b.by_edge(v.col(2) - v.col(1));
      const double spin_a = v(0, 3) / rest.radius_of_gyration, spin_b = v(0, 4) / rest.radius_of_gyration;
      std::array<double, kStrains> rate;
      for (size_t i = 0; i < kStrains; ++i) {
        const RodGradient g = gradient(i);
        rate[i] = g.a.dot(turn_a) + g.b.dot(turn_b) + g.angle_a * spin_a + g.angle_b * spin_b;
      }
      return rate;
    }
    RodMatrix second(size_t i) const {
      if (i == 4) return twist.second_by_edges(a, b);
      RodHessian h = RodHessian::zero();
      if (i < 2) {
        h.aa = by_a.by_tangent_twice(i);
        h.bb = by_a.by_other_twice(i);
        h.ba = by_a.by_other_and_tangent(i);
        h.a_angle_a = by_a.by_tangent_and_angle(i);
        h.b_angle_a = by_a.by_other_and_angle(i);
        h.angle_a2 = by_a.by_angle_twice(i);
      } else {
        h.bb = by_b.by_tangent_twice(i - 2);
        h.aa = by_b.by_other_twice(i - 2);
        h.ba = by_b.by_other_and_tangent(i - 2).transpose();
        h.b_angle_b = by_b.by_tangent_and_angle(i - 2);
        h.a_angle_b = by_b.by_other_and_angle(i - 2);
        h.angle_b2 = by_b.by_angle_twice(i - 2);
      }
      return by_edges(gradient(i), h, a, b);
    }
  };

  static double energy(const Points& x, const Rest& rest, const Memory& memory) {
    const Shape shape(x, rest, memory);
    const auto strain = shape.strains(memory);
    double sum = 0.0;
    for (size_t i = 0; i < kStrains; ++i) {
      const double difference = strain[i] - rest.strain[i];
      sum += 0.5 * rest.weight[i] * difference * difference;
    }
    return sum;
  }

  static Points force(const Points& x, const Points& v, const Rest& rest, const Context&, const Memory& memory) {
    const Shape shape(x, rest, memory);
    const auto strain = shape.strains(memory);
    std::array<double, kStrains> rate{};
    if (rest.damping > 0.0) rate = shape.rates(v, rest);
    RodGradient sum{Vec3::Zero(), Vec3::Zero(), 0.0, 0.0};
    for (size_t i = 0; i < kStrains; ++i) {
      const RodGradient g = shape.gradient(i);
      const double moment = rest.weight[i] * (strain[i] - rest.strain[i] + rest.damping * rate[i]);
      sum.a += moment * g.a;
      sum.b += moment * g.b;
      sum.angle_a += moment * g.angle_a;
      sum.angle_b += moment * g.angle_b;
    }
    return force_on_points(-by_edges(sum, shape.a, shape.b), rest);
  }

  /// dx df/dx + dv df/dv. Exact:
  ///   -sum w [(dx + damping dv) g g^T + dx damping g (H v)^T + dx (e - rest + damping g.v) H],   g, H of each strain;
  /// projected: -sum w (dx + damping dv) g g^T (Gauss-Newton).
  static Blocks jacobian(const Points& x, const Points& v, const Rest& rest, const Context&, const Memory& memory,
                         double dx, double dv, Jacobian kind) {
    const Shape shape(x, rest, memory);
    RodVector rate;
    rate << v.col(1) - v.col(0), v.col(2) - v.col(1), v(0, 3) / rest.radius_of_gyration,
        v(0, 4) / rest.radius_of_gyration;
    const bool exact = kind == Jacobian::kExact;
    const auto strain = exact ? shape.strains(memory) : std::array<double, kStrains>{};
    RodMatrix sum = RodMatrix::Zero();
    for (size_t i = 0; i < kStrains; ++i) {
      const RodVector g = by_edges(shape.gradient(i), shape.a, shape.b);
      sum.noalias() -= (rest.weight[i] * (dx + rest.damping * dv)) * g * g.transpose();
      if (!exact) continue;
      const RodMatrix h = shape.second(i);
      sum -= (rest.weight[i] * dx * (strain[i] - rest.strain[i] + rest.damping * g.dot(rate))) * h;
      sum.noalias() -= (rest.weight[i] * dx * rest.damping) * g * (h * rate).transpose();
    }
    return jacobian_on_points(sum, rest);
  }

 private:
  /// Shares of the edges a = x_1 - x_0 and b = x_2 - x_1 in a point.
  static constexpr double kShare[3][2] = {{-1.0, 0.0}, {1.0, -1.0}, {0.0, 1.0}};

  static Points force_on_points(const RodVector& f, const Rest& rest) {
    Points out = Points::Zero();
    out.col(0) = -f.segment<3>(0);
    out.col(1) = f.segment<3>(0) - f.segment<3>(3);
    out.col(2) = f.segment<3>(3);
    out(0, 3) = f[6] / rest.radius_of_gyration;
    out(0, 4) = f[7] / rest.radius_of_gyration;
    return out;
  }

  static Blocks jacobian_on_points(const RodMatrix& m, const Rest& rest) {
    Blocks out = Blocks::Zero();
    const Mat3 aa = m.block<3, 3>(0, 0), ab = m.block<3, 3>(0, 3), ba = m.block<3, 3>(3, 0), bb = m.block<3, 3>(3, 3);
    out.block<3, 3>(0, 0) = aa;
    out.block<3, 3>(0, 3) = ab - aa;
    out.block<3, 3>(0, 6) = -ab;
    out.block<3, 3>(3, 0) = ba - aa;
    out.block<3, 3>(3, 3) = aa - ab - ba + bb;
    out.block<3, 3>(3, 6) = ab - bb;
    out.block<3, 3>(6, 0) = -ba;
    out.block<3, 3>(6, 3) = ba - bb;
    out.block<3, 3>(6, 6) = bb;
    const double per_angle = 1.0 / rest.radius_of_gyration;
    for (int k = 0; k < 2; ++k) {
      for (int i = 0; i < 3; ++i) {
        for (int p = 0; p < 2; ++p) {
          out.block<3, 1>(3 * i, 9 + 3 * k) += (kShare[i][p] * per_angle) * m.block<3, 1>(3 * p, 6 + k);
          out.block<1, 3>(9 + 3 * k, 3 * i) += (kShare[i][p] * per_angle) * m.block<1, 3>(6 + k, 3 * p);
        }
      }
      for (int l = 0; l < 2; ++l) out(9 + 3 * k, 9 + 3 * l) = per_angle * per_angle * m(6 + k, 6 + l);
    }
    return out;
  }
};

}  // namespace deformable_sim
