// A solid tetrahedron with straight edges at rest: elastic and viscous forces for any shape functions.
#pragma once

#include <array>

#include <Eigen/Core>

#include "deformable_sim/core/element/solid_stress.h"

namespace deformable_sim {

/// Four corners, one point of quadrature. Strain is constant inside: bending is locked unless there are many elements
/// through the thickness (see expected_bending_factor), and nearly incompressible materials are too stiff.
struct LinearShape {
  static constexpr int kPoints = 4;
  static constexpr int kQuadrature = 1;
  /// 3 x 4, column-major: gradients of the shape functions in reference coordinates (xi, eta, zeta of nodes b, c, d).
  static constexpr std::array<std::array<double, 12>, 1> kGradients = {{{-1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1}}};
};

/// Element of ElementEnergy: a tetrahedron with shape functions N_a, deformation gradient F = sum_a x_a (dN_a/dX)^T,
///
///   E   = sum over points of quadrature of w psi(F)
///   f_a = - sum of w (P + P_v) dN_a/dX,      P = dpsi/dF,  w = volume / number of points
///
/// Damping (time constant tau, s): a second Piola-Kirchhoff stress proportional to the rate of Green-Lagrange strain
/// by the moduli at rest,
///
///   P_v = F S_v,   S_v = tau (2 mu Edot + lambda tr(Edot) I),   Edot = sym(F^T Fdot)
///
/// which is zero for v = omega x x + t in any deformation, and dissipates w S_v : Edot >= 0 otherwise. At small strain
/// it is stiffness-proportional (Rayleigh) damping: a mode of frequency omega has the damping ratio tau omega / 2.
template <class Shape>
struct SolidTetrahedron {
  static constexpr int kPoints = Shape::kPoints;
  static constexpr bool kPairwise = false;
  static constexpr bool kUniform = false;
  using Points = Eigen::Matrix<double, 3, kPoints>;
  using Block = Eigen::Matrix<double, 3 * kPoints, 3 * kPoints>;

  struct Rest {
    Mat3 inverse;   // of [b - a, c - a, d - a], 1/m
    double volume;  // m^3
  };
  struct Parameters {
    SolidMaterial material;
    double damping = 0.0;  // tau, s
  };
  using Context = Parameters;
  static Context context(const Parameters& parameters, double /*time*/) { return parameters; }

  /// J, from x (m).
  static double energy(const Points& x, const Rest& rest, const Context& context) {
    double sum = 0.0;
    for (int q = 0; q < Shape::kQuadrature; ++q) sum += energy_density(context.material, gradient(x, rest, q));
    return rest.volume / Shape::kQuadrature * sum;
  }

  /// N on each point, from x (m) and v (m/s).
  static Points force(const Points& x, const Points& v, const Rest& rest, const Context& context) {
    Points f = Points::Zero();
    for (int q = 0; q < Shape::kQuadrature; ++q) {
      const Mat3 deformation = gradient(x, rest, q);
      Mat3 stress = first_piola(context.material, deformation);
      if (context.damping > 0.0) stress += deformation * viscous(deformation, gradient(v, rest, q), context);
      const Mat3 by_reference = (-rest.volume / Shape::kQuadrature) * stress * rest.inverse.transpose();
      f.noalias() += by_reference * reference(q);
    }
    return f;
  }

  /// dx df/dx + dv df/dv. Projected: the elastic part by its eigen-system; of the viscous part df/dv alone, which is
  /// symmetric and negative semi-definite as it is.
  static Block jacobian(const Points& x, const Points& v, const Rest& rest, const Context& context, double dx,
                        double dv, Jacobian kind) {
    Block k = Block::Zero();
    const double weight = rest.volume / Shape::kQuadrature;
    for (int q = 0; q < Shape::kQuadrature; ++q) {
      const Mat3 deformation = gradient(x, rest, q);
      if (dx != 0.0) subtract_elastic(deformation, rest, context, dx * weight, q, kind, &k);
      if (context.damping > 0.0) {
        const Points g = rest.inverse.transpose() * reference(q);
        const double scale = weight * context.damping;
        if (dv != 0.0) subtract_viscous(deformation, deformation, g, context, dv * scale, &k);
        if (dx != 0.0 && kind == Jacobian::kExact) {
          const Mat3 rate = gradient(v, rest, q);
          subtract_viscous(deformation, rate, g, context, dx * scale, &k);
          subtract_geometric(viscous(deformation, rate, context), g, dx * weight, &k);
        }
      }
    }
    return k;
  }

  /// sum_a y_a (dN_a/dX)^T at one point of quadrature: F of positions, its rate of velocities.
  static Mat3 gradient(const Points& y, const Rest& rest, int q) {
    // The gradients add up to zero: differences to the first node make the result independent of where the body is.
    const Eigen::Matrix<double, 3, kPoints - 1> d = y.template rightCols<kPoints - 1>().colwise() - y.col(0);
    const Mat3 by_reference = d * reference(q).template rightCols<kPoints - 1>().transpose();
    return by_reference * rest.inverse;
  }

 private:
  static Eigen::Map<const Points> reference(int q) {
    return Eigen::Map<const Points>(Shape::kGradients[static_cast<size_t>(q)].data());
  }

  /// S_v.
  static Mat3 viscous(const Mat3& deformation, const Mat3& rate, const Context& c) {
    const Mat3 product = deformation.transpose() * rate;
    Mat3 stress = (c.damping * c.material.mu) * (product + product.transpose());
    stress.diagonal().array() += c.damping * c.material.lambda * product.trace();
    return stress;
  }

  /// K_ab = weight u M_ab u^T with, for h_a = v^T dN_a/dX,
  ///   M_ab(i, i) = sum_j D_ij h_a[j] h_b[j],                              D_ii = scaling(i, i), else (flip + twist) /
  ///   2 M_ab(i, j) = scaling(i, j) h_a[i] h_b[j] + (flip - twist) / 2 h_a[j] h_b[i].
  static void subtract_elastic(const Mat3& deformation, const Rest& rest, const Context& context, double weight, int q,
                               Jacobian kind, Block* k) {
    const StressDerivative d = stress_derivative(context.material, deformation, kind);
    const Mat3 to_principal = rest.inverse * d.v;
    const Points h = to_principal.transpose() * reference(q);
    Mat3 direct = weight * d.scaling, along = direct, across = Mat3::Zero();
    for (int n = 0; n < 3; ++n) {
      const int i = (n + 1) % 3, j = (n + 2) % 3;
      direct(i, j) = direct(j, i) = 0.5 * weight * (d.flip[n] + d.twist[n]);
      across(i, j) = across(j, i) = 0.5 * weight * (d.flip[n] - d.twist[n]);
    }
    along.diagonal().setZero();
    for (int a = 0; a < kPoints; ++a) {
      for (int b = 0; b <= a; ++b) {
        const Mat3 outer = h.col(a) * h.col(b).transpose();
        Mat3 m = along.cwiseProduct(outer) + across.cwiseProduct(outer.transpose());
        m.diagonal() += direct * outer.diagonal();
        const Mat3 block = d.u * m * d.u.transpose();
        k->template block<3, 3>(3 * a, 3 * b) -= block;
        if (a != b) k->template block<3, 3>(3 * b, 3 * a) -= block.transpose();
      }
    }
  }

  /// Derivative of F (mu (F^T Y + Y^T F) + lambda tr(F^T Y) I) with respect to one of its factors Y, which is F or the
  /// rate Z: K_ab = mu (F Z^T (g_a.g_b) + (F g_b) (Z g_a)^T) + lambda (F g_a) (Z g_b)^T, Z the factor that stays.
  static void subtract_viscous(const Mat3& deformation, const Mat3& stays, const Points& g, const Context& c,
                               double weight, Block* k) {
    const Mat3 product = deformation * stays.transpose();
    const Points moved = deformation * g, kept = stays * g;
    for (int a = 0; a < kPoints; ++a) {
      for (int b = 0; b < kPoints; ++b) {
        Mat3 block = c.material.mu * (g.col(a).dot(g.col(b)) * product + moved.col(b) * kept.col(a).transpose());
        block += c.material.lambda * moved.col(a) * kept.col(b).transpose();
        k->template block<3, 3>(3 * a, 3 * b) -= weight * block;
      }
    }
  }

  /// Derivative of F S with respect to F at constant S: (g_a.S g_b) I.
  static void subtract_geometric(const Mat3& stress, const Points& g, double weight, Block* k) {
    const Points loaded = stress * g;
    for (int a = 0; a < kPoints; ++a) {
      for (int b = 0; b < kPoints; ++b) {
        k->template block<3, 3>(3 * a, 3 * b).diagonal().array() -= weight * g.col(a).dot(loaded.col(b));
      }
    }
  }
};

using LinearTetrahedron = SolidTetrahedron<LinearShape>;

}  // namespace deformable_sim
