// A constant-strain triangle: three points in space, of a sheet that is flat at rest.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/element/principal_stretches.h"
#include "deformable_sim/core/material/sheet_law.h"

namespace deformable_sim {

/// What a triangle remembers of its rest shape.
struct MembraneRest {
  Matrix32 gradient;  // B, 1/m: F = X B, X the three points, one a column
  double area;        // A, m^2
  Matrix32 axes;      // rest directions of warp and weft in space (linear Hooke only measures against them)
};

struct MembraneParameters {
  SolidMaterial solid;  // isotropic laws, N/m
  Mat3 stiffness;       // plane stress, N/m
  double damping;       // s
};

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Deformation gradient F = X B (3 x 2), columns along warp and weft; energy A W(F), force on the points
///
///   f = -A P B^T,   P = dW/dF + F S_v,   S_v = damping C sym(F^T dF/dt),
///
/// W from the law. The viscous part sees the rate of the Green strain only: none in rigid motion.
/// Law provides density(F, rest, parameters), stress(...) = dW/dF and tangent(..., kind) = d2W/dF2 by columns of F.
template <class Law>
struct Membrane {
  static constexpr int kPoints = 3;
  static constexpr bool kPairwise = false;
  static constexpr bool kUniform = false;
  using Points = Mat3;  // one column a corner
  using Blocks = Eigen::Matrix<double, 9, 9>;
  using Rest = MembraneRest;
  using Parameters = MembraneParameters;
  struct Context {
    const Parameters& parameters;
  };
  static Context context(const Parameters& p, double /*time*/) { return {p}; }

  static double energy(const Points& x, const Rest& rest, const Context& context) {
    return rest.area * Law::density(x * rest.gradient, rest, context.parameters);
  }

  static Points force(const Points& x, const Points& v, const Rest& rest, const Context& context) {
    const Matrix32 f = x * rest.gradient;
    Matrix32 stress = Law::stress(f, rest, context.parameters);
    if (context.parameters.damping > 0.0) {
      stress += f * viscous_stress(f, v * rest.gradient, context.parameters);
    }
    return -rest.area * stress * rest.gradient.transpose();
  }

  /// dx df/dx + dv df/dv. Projected: the law's own projection, and the viscous part's derivative by v only.
  static Blocks jacobian(const Points& x, const Points& v, const Rest& rest, const Context& context, double dx,
                         double dv, Jacobian kind) {
    const MembraneParameters& p = context.parameters;
    const Matrix32 f = x * rest.gradient;
    Matrix6 tangent = dx * Law::tangent(f, rest, p, kind);
    if (p.damping > 0.0) {
      const Eigen::Matrix<double, 3, 6> by_rate = green_rate(f);  // dE = G dF
      tangent += (dv * p.damping) * by_rate.transpose() * p.stiffness * by_rate;
      if (kind == Jacobian::kExact) {
        const Matrix32 rate = v * rest.gradient;
        tangent += (dx * p.damping) * by_rate.transpose() * p.stiffness * green_rate(rate);
        tangent += dx * spread(viscous_stress(f, rate, p));
      }
    }
    return to_points(tangent, rest);
  }

  /// S by (s11, s22, s12) acting on dF: d(F S) = dF S.
  static Matrix6 spread(const Eigen::Matrix2d& s) {
    Matrix6 m;
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) m.block<3, 3>(3 * a, 3 * b) = s(a, b) * Mat3::Identity();
    }
    return m;
  }

  /// Rows: d(F^T F)/2 as (e11, e22, 2 e12) by the columns of F.
  static Eigen::Matrix<double, 3, 6> green_rate(const Matrix32& f) {
    Eigen::Matrix<double, 3, 6> g = Eigen::Matrix<double, 3, 6>::Zero();
    g.block<1, 3>(0, 0) = f.col(0).transpose();
    g.block<1, 3>(1, 3) = f.col(1).transpose();
    g.block<1, 3>(2, 0) = f.col(1).transpose();
    g.block<1, 3>(2, 3) = f.col(0).transpose();
    return g;
  }

 private:
  static Eigen::Matrix2d viscous_stress(const Matrix32& f, const Matrix32& rate, const MembraneParameters& p) {
    const Vec3 strain_rate(f.col(0).dot(rate.col(0)), f.col(1).dot(rate.col(1)),
                           f.col(0).dot(rate.col(1)) + f.col(1).dot(rate.col(0)));
    const Vec3 s = p.damping * p.stiffness * strain_rate;
    return (Eigen::Matrix2d() << s[0], s[2], s[2], s[1]).finished();
  }

  static Blocks to_points(const Matrix6& tangent, const Rest& rest) {
    Eigen::Matrix<double, 6, 9> half;  // tangent dF/dx
    for (int j = 0; j < 3; ++j) {
      half.block<6, 3>(0, 3 * j) =
          rest.gradient(j, 0) * tangent.leftCols<3>() + rest.gradient(j, 1) * tangent.rightCols<3>();
    }
    Blocks blocks;
    for (int i = 0; i < 3; ++i) {
      blocks.middleRows<3>(3 * i) =
          -rest.area * (rest.gradient(i, 0) * half.topRows<3>() + rest.gradient(i, 1) * half.bottomRows<3>());
    }
    return blocks;
  }
};

/// St Venant-Kirchhoff, orthotropic: W = e^T C e / 2 with the Green strain e = (e11, e22, 2 e12) of (F^T F - I) / 2.
/// Not good at: strong compression (softens below a stretch of 0.577 and gives no force at 0).
/// Projected: the stress's negative principal parts are dropped from the geometric stiffness.
struct GreenLaw {
  static Vec3 strain(const Matrix32& f) {
    return {0.5 * (f.col(0).squaredNorm() - 1.0), 0.5 * (f.col(1).squaredNorm() - 1.0), f.col(0).dot(f.col(1))};
  }
  static Eigen::Matrix2d second_stress(const Matrix32& f, const MembraneParameters& p) {
    const Vec3 s = p.stiffness * strain(f);
    return (Eigen::Matrix2d() << s[0], s[2], s[2], s[1]).finished();
  }
  static double density(const Matrix32& f, const MembraneRest&, const MembraneParameters& p) {
    const Vec3 e = strain(f);
    return 0.5 * e.dot(p.stiffness * e);
  }
  static Matrix32 stress(const Matrix32& f, const MembraneRest&, const MembraneParameters& p) {
    return f * second_stress(f, p);
  }
  static Matrix6 tangent(const Matrix32& f, const MembraneRest&, const MembraneParameters& p, Jacobian kind) {
    Eigen::Matrix2d s = second_stress(f, p);
    if (kind != Jacobian::kExact) s = positive_part(s);
    const Eigen::Matrix<double, 3, 6> g = Membrane<GreenLaw>::green_rate(f);
    return g.transpose() * p.stiffness * g + Membrane<GreenLaw>::spread(s);
  }
};

/// Linear Hooke: W = e^T C e / 2 with the small strain e of F against the rest directions. For small rotations only: a
/// sheet turned in its plane by an angle t rests 1 / cos t larger, and one turned out of its plane does not know it.
struct LinearLaw {
  static Eigen::Matrix<double, 3, 6> by_gradient(const MembraneRest& rest) {
    return Membrane<LinearLaw>::green_rate(rest.axes);
  }
  static Vec3 strain(const Matrix32& f, const MembraneRest& rest) {
    return by_gradient(rest) * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(f.data()) - Vec3(1.0, 1.0, 0.0);
  }
  static double density(const Matrix32& f, const MembraneRest& rest, const MembraneParameters& p) {
    const Vec3 e = strain(f, rest);
    return 0.5 * e.dot(p.stiffness * e);
  }
  static Matrix32 stress(const Matrix32& f, const MembraneRest& rest, const MembraneParameters& p) {
    const Vec3 s = p.stiffness * strain(f, rest);
    return rest.axes * (Eigen::Matrix2d() << s[0], s[2], s[2], s[1]).finished();
  }
  static Matrix6 tangent(const Matrix32&, const MembraneRest& rest, const MembraneParameters& p, Jacobian) {
    return by_gradient(rest).transpose() * p.stiffness * by_gradient(rest);
  }
};

/// Isotropic laws in plane stress, W(s1, s2) of the singular values of F = sum s_i u_i v_i^T; n = u1 x u2. The
/// tangent's eigen-directions are known:
///
///   u1 v1^T, u2 v2^T                    the 2 x 2 Hessian of W
///   (u1 v2^T - u2 v1^T) / sqrt(2)       (W_1 + W_2) / (s1 + s2)
///   (u1 v2^T + u2 v1^T) / sqrt(2)       (W_1 - W_2) / (s1 - s2)
///   n v_i^T                             W_i / s_i
///
/// and the projection drops what is negative.
struct PrincipalLaw {
  static double density(const Matrix32& f, const MembraneRest&, const MembraneParameters& p) {
    Eigen::Vector2d by_stretch;
    return plane_stress_energy(p.solid, principal_stretches(f).stretch, &by_stretch, nullptr);
  }
  static Matrix32 stress(const Matrix32& f, const MembraneRest&, const MembraneParameters& p) {
    const PrincipalStretches at = principal_stretches(f);
    Eigen::Vector2d by_stretch;
    plane_stress_energy(p.solid, at.stretch, &by_stretch, nullptr);
    return at.u * by_stretch.asDiagonal() * at.v.transpose();
  }
  static Matrix6 tangent(const Matrix32& f, const MembraneRest&, const MembraneParameters& p, Jacobian kind) {
    const PrincipalStretches at = principal_stretches(f);
    const Eigen::Vector2d& s = at.stretch;
    Eigen::Vector2d w;
    Eigen::Matrix2d h;
    plane_stress_energy(p.solid, s, &w, &h);
    const bool project = kind != Jacobian::kExact;
    const auto kept = [project](double value) { return project ? std::max(value, 0.0) : value; };
    if (project) h = positive_part(h);

    const double sum = std::max(s.sum(), kTiny), gap = s[0] - s[1];
    // Close principal stretches: the quotient's limit, off by the square of the gap.
    const double flip = gap > 1e-5 * sum ? (w[0] - w[1]) / gap : 0.5 * (h(0, 0) + h(1, 1)) - h(0, 1);
    Eigen::Matrix<double, 6, 2> along, aside, out;
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        along.block<3, 1>(3 * b, a) = at.v(b, a) * at.u.col(a);
        out.block<3, 1>(3 * b, a) = at.v(b, a) * at.normal;
        aside.block<3, 1>(3 * b, a) = at.v(b, 1 - a) * at.u.col(a);
      }
    }
    Matrix6 tangent = along * h * along.transpose();
    const Eigen::Matrix<double, 6, 1> turned = aside.col(0) - aside.col(1), sheared = aside.col(0) + aside.col(1);
    tangent += (0.5 * kept(w.sum() / sum)) * turned * turned.transpose();
    tangent += (0.5 * kept(flip)) * sheared * sheared.transpose();
    for (int a = 0; a < 2; ++a) {
      tangent += kept(w[a] / std::max(s[a], kTiny)) * out.col(a) * out.col(a).transpose();
    }
    return tangent;
  }

 private:
  static constexpr double kTiny = 1e-12;
};

}  // namespace deformable_sim
