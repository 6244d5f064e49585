// Born moduli of spring networks, and the elastic constants they amount to.
#include "deformable_sim/core/material/spring_moduli.h"

#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

namespace deformable_sim {
namespace {

constexpr double kAgreement = 0.01;  // relative (nu: absolute), below which nothing is reported

/// sum k l^2 m m^T, m the strain of a spring of unit length in its own direction per component of strain.
template <class Matrix, class Row>
Matrix sum_over_springs(const Nodes& rest, const SpringNetwork& network, Row row) {
  Matrix sum = Matrix::Zero();
  for (const auto* links : {&network.stretch, &network.shear, &network.bend}) {
    for (const SpringLink& link : *links) {
      const Vec3 d = rest.col(link.b) - rest.col(link.a);
      const auto m = row(Vec3(d.normalized()));
      sum += link.stiffness * d.squaredNorm() * m * m.transpose();
    }
  }
  return sum;
}

constexpr double kMechanism = 1e-12;  // of the largest modulus: a strain stiffer than that is resisted

/// C^-1, with strains that meet no stiffness (a lattice of edges alone shears freely) given a tiny one.
template <class Matrix>
Matrix compliance_of(const Matrix& moduli) {
  const Eigen::SelfAdjointEigenSolver<Matrix> modes(moduli);
  const double least = kMechanism * modes.eigenvalues().maxCoeff();
  return modes.eigenvectors() * modes.eigenvalues().cwiseMax(least).cwiseInverse().asDiagonal() *
         modes.eigenvectors().transpose();
}

/// 1 / (C^-1)_ii; 0 where strain i meets no stiffness.
template <class Matrix>
double stiffness_of(const Matrix& moduli, const Matrix& compliance, int i) {
  const double found = 1.0 / compliance(i, i);
  return found > 1e3 * kMechanism * moduli.diagonal().maxCoeff() ? found : 0.0;
}

template <class Matrix>
SpringModuli constants(const Matrix& moduli, int axes, int shear) {
  const Matrix compliance = compliance_of(moduli);
  SpringModuli found;
  for (int i = 0; i < axes; ++i) found.youngs_modulus[i] = stiffness_of(moduli, compliance, i);
  if (found.youngs_modulus[0] > 0.0) found.poissons_ratio = -compliance(1, 0) / compliance(0, 0);
  found.shear_modulus = stiffness_of(moduli, compliance, shear);
  return found;
}

}  // namespace

Mat3 sheet_moduli(const Nodes& rest, const SpringNetwork& network, double area) {
  return sum_over_springs<Mat3>(rest, network,
                                [](const Vec3& n) { return Vec3(n.x() * n.x(), n.y() * n.y(), n.x() * n.y()); }) /
         area;
}

Mat6 solid_moduli(const Nodes& rest, const SpringNetwork& network, double volume) {
  return sum_over_springs<Mat6>(rest, network,
                                [](const Vec3& n) {
                                  Eigen::Matrix<double, 6, 1> m;
                                  m << n.x() * n.x(), n.y() * n.y(), n.z() * n.z(), n.y() * n.z(), n.x() * n.z(),
                                      n.x() * n.y();
                                  return m;
                                }) /
         volume;
}

SpringModuli constants_of(const Mat3& moduli) {
  return constants(moduli, 2, 2);
}

SpringModuli constants_of(const Mat6& moduli) {
  return constants(moduli, 3, 5);
}

std::string spring_gap(double modulus, double poissons_ratio, const SpringModuli& found) {
  const double shear = modulus / (2.0 * (1.0 + poissons_ratio));
  const bool agree = std::abs(found.youngs_modulus[0] - modulus) <= kAgreement * modulus &&
                     std::abs(found.poissons_ratio - poissons_ratio) <= kAgreement &&
                     std::abs(found.shear_modulus - shear) <= kAgreement * shear;
  if (agree) return {};
  char text[240];
  std::snprintf(text, sizeof text,
                "central springs cannot be this material: modulus %.4g, Poisson's ratio %.3g and shear modulus %.4g "
                "asked for, the network has %.4g, %.3g and %.4g",
                modulus, poissons_ratio, shear, found.youngs_modulus[0], found.poissons_ratio, found.shear_modulus);
  return text;
}

}  // namespace deformable_sim
