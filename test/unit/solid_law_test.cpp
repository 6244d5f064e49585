// Stress-strain laws of solids: derivatives, invariances, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/element/solid_stress.h"
#include "deformable_sim/core/error.h"
#include "support/solids.h"

namespace deformable_sim::test {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// Stretches near rest, stretched, compressed, equal, nearly equal, nearly flat; inverted where the law allows it.
std::vector<Vec3> states_of(SolidLaw law) {
  std::vector<Vec3> states = {{1, 1, 1},        {1.02, 0.99, 1.005}, {1.7, 1.2, 0.8}, {0.6, 0.5, 0.4},
                              {1.3, 1.3, 0.7},  {1.2, 0.9, 0.9},     {2, 2, 2},       {1.1, 1.1 + 1e-9, 1.1 - 1e-9},
                              {1.5, 0.8, 0.15}, {1.2, 0.3, 0.2}};
  if (law == SolidLaw::kCorotational || law == SolidLaw::kStVenantKirchhoff || law == SolidLaw::kStableNeoHookean) {
    states.insert(states.end(), {{1.1, 0.9, -0.2}, {1.3, 1.2, -0.8}, {0.5, 0.5, -0.1}, {1.2, 0.6, 0.01}});
  }
  return states;
}

/// dP/dF as the eigen-system states it, columns of F stacked.
Matrix9 matrix_of(const StressDerivative& d) {
  Matrix9 result = Matrix9::Zero();
  const auto add = [&](const Mat3& p, const Mat3& q, double factor) {
    result += factor * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(p.data()) *
              Eigen::Map<const Eigen::Matrix<double, 9, 1>>(q.data()).transpose();
  };
  const auto pair = [&](int i, int j) -> Mat3 { return d.u.col(i) * d.v.col(j).transpose(); };
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    for (int n = 0; n < 3; ++n) add(pair(k, k), pair(n, n), d.scaling(k, n));
    const Mat3 twist = pair(i, j) - pair(j, i), flip = pair(i, j) + pair(j, i);
    add(twist, twist, 0.5 * d.twist[k]);
    add(flip, flip, 0.5 * d.flip[k]);
  }
  return result;
}

TEST(SolidLaws, HaveTheGradientAndHessianOfTheirEnergy) {
  // g_i = d psi / d s_i and H_ij = d g_i / d s_j by central differences.
  for (const SolidLaw law : kSolidLaws) {
    if (law == SolidLaw::kHooke) continue;
    const SolidMaterial material = solid_material(law, 2.6, 0.3);
    for (const Vec3& s : states_of(law)) {
      Vec3 gradient, low, high;
      Mat3 hessian;
      energy_density(material, s, &gradient, &hessian);
      const double h = 1e-5 * s.cwiseAbs().minCoeff();
      for (int k = 0; k < 3; ++k) {
        const Vec3 step = h * Vec3::Unit(k);
        const double slope =
            (energy_density(material, s + step, &high, nullptr) - energy_density(material, s - step, &low, nullptr)) /
            (2.0 * h);
        EXPECT_NEAR(gradient[k], slope, 1e-6 * (1.0 + gradient.norm())) << name_of(law) << " at " << s.transpose();
        EXPECT_LT((hessian.col(k) - (high - low) / (2.0 * h)).norm(), 1e-6 * (1.0 + hessian.norm()))
            << name_of(law) << " at " << s.transpose();
      }
    }
  }
}

TEST(SolidLaws, HaveTheStressOfTheirEnergy) {
  // P_ij = d psi / d F_ij at any rotation; rotated about, the energy stays and P = R P(F) Q.
  std::mt19937 generator(11);
  for (const SolidLaw law : kSolidLaws) {
    const SolidMaterial material = solid_material(law, 2.6, 0.3);
    for (const Vec3& s : states_of(law)) {
      const Mat3 f = with_stretches(s, &generator), stress = first_piola(material, f);
      const double h = 1e-6;
      for (int k = 0; k < 9; ++k) {
        Mat3 plus = f, minus = f;
        plus.data()[k] += h;
        minus.data()[k] -= h;
        const double slope = (energy_density(material, plus) - energy_density(material, minus)) / (2.0 * h);
        EXPECT_NEAR(stress.data()[k], slope, 1e-6 * (1.0 + stress.norm())) << name_of(law) << " at " << s.transpose();
      }
      if (law == SolidLaw::kHooke) continue;
      const Mat3 r = random_rotation(&generator), q = random_rotation(&generator);
      EXPECT_LT((first_piola(material, r * f * q) - r * stress * q).norm(), 1e-12 * (1.0 + stress.norm()))
          << name_of(law) << " at " << s.transpose();
    }
  }
}

TEST(SolidLaws, HaveTheTangentOfTheirStress) {
  // dP/dF by central differences; the projected one is its positive semi-definite part.
  std::mt19937 generator(12);
  for (const SolidLaw law : kSolidLaws) {
    const SolidMaterial material = solid_material(law, 2.6, 0.3);
    for (const Vec3& s : states_of(law)) {
      const Mat3 f = with_stretches(s, &generator);
      const Matrix9 exact = matrix_of(stress_derivative(material, f, Jacobian::kExact));
      const double h = 1e-6;
      Matrix9 expected;
      for (int k = 0; k < 9; ++k) {
        Mat3 plus = f, minus = f;
        plus.data()[k] += h;
        minus.data()[k] -= h;
        const Mat3 slope = (first_piola(material, plus) - first_piola(material, minus)) / (2.0 * h);
        expected.col(k) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(slope.data());
      }
      EXPECT_LT((exact - expected).norm(), 1e-6 * expected.norm()) << name_of(law) << " at " << s.transpose();

      const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(exact);
      const Matrix9 positive =
          eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
      const Matrix9 projected = matrix_of(stress_derivative(material, f, Jacobian::kProjected));
      EXPECT_LT((projected - positive).norm(), 1e-12 * exact.norm()) << name_of(law) << " at " << s.transpose();
    }
  }
}

TEST(SolidLaws, ArePairedByTheirGradients) {
  // twist = (g_i + g_j) / (s_i + s_j), flip = (g_i - g_j) / (s_i - s_j).
  for (const SolidLaw law : kSolidLaws) {
    if (law == SolidLaw::kHooke) continue;
    const SolidMaterial material = solid_material(law, 2.6, 0.3);
    const Vec3 s(1.4, 1.1, 0.6);
    Vec3 g, twist, flip;
    energy_density(material, s, &g, nullptr);
    pair_moduli(material, s, &twist, &flip);
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      EXPECT_NEAR(twist[k], (g[i] + g[j]) / (s[i] + s[j]), 1e-13) << name_of(law);
      EXPECT_NEAR(flip[k], (g[i] - g[j]) / (s[i] - s[j]), 1e-13) << name_of(law);
    }
  }
}

TEST(SolidLaws, AreHookesAtSmallStrain) {
  // psi = 0, P = 0 and dP/dF = mu (I + transposition) + lambda I x I at rest, for every law and share of Mooney-Rivlin.
  const Matrix9 hooke =
      matrix_of(stress_derivative(solid_material(SolidLaw::kHooke, 2.6, 0.3), Mat3::Identity(), Jacobian::kExact));
  for (const SolidLaw law : kSolidLaws) {
    for (const double share : {0.0, 0.3, 1.0}) {
      SolidMaterial material = solid_material(law, 2.6, 0.3);
      material.share = share;
      EXPECT_NEAR(energy_density(material, Mat3::Identity()), 0.0, 1e-15) << name_of(law);
      EXPECT_LT(first_piola(material, Mat3::Identity()).norm(), 1e-15) << name_of(law);
      const Matrix9 tangent = matrix_of(stress_derivative(material, Mat3::Identity(), Jacobian::kExact));
      EXPECT_LT((tangent - hooke).norm(), 1e-14 * hooke.norm()) << name_of(law);
    }
  }
}

TEST(SolidLaws, AreInfiniteWhereTheyAreUndefined) {
  // ln J and J^(-2/3) have no value for J <= 0: such a state is never taken for an equilibrium.
  for (const SolidLaw law : {SolidLaw::kNeoHookean, SolidLaw::kMooneyRivlin}) {
    const SolidMaterial material = solid_material(law, 1.0, 0.3);
    for (const double thickness : {0.0, -0.5}) {
      const Mat3 f = Vec3(1.0, 1.0, thickness).asDiagonal();
      EXPECT_EQ(energy_density(material, f), std::numeric_limits<double>::infinity()) << name_of(law);
      EXPECT_FALSE(first_piola(material, f).allFinite()) << name_of(law);
    }
  }
}

TEST(SolidLaws, AreFoundByName) {
  for (const SolidLaw law : kSolidLaws) EXPECT_EQ(solid_law(name_of(law)), law);
  EXPECT_EQ(solid_law_names().size(), kSolidLaws.size());
  try {
    solid_law("rubber");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("rubber"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("stable_neo_hookean"), std::string::npos);
  }
}

TEST(SolidMaterials, FollowFromYoungsModulusAndPoissonsRatio) {
  // mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)): confined modulus E (1 - nu) / ((1 + nu) (1 - 2 nu)).
  const SolidMaterial m = solid_material(SolidLaw::kHooke, 3.0, 0.25);
  EXPECT_NEAR(m.mu, 1.2, 1e-15);
  EXPECT_NEAR(m.lambda + 2.0 * m.mu, 3.0 * 0.75 / (1.25 * 0.5), 1e-15);
  for (const double youngs_modulus : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(solid_material(SolidLaw::kHooke, youngs_modulus, 0.3), InputError);
  }
  for (const double poissons_ratio : {0.5, -1.0, 0.6, std::nan("")}) {
    EXPECT_THROW(solid_material(SolidLaw::kHooke, 1.0, poissons_ratio), InputError);
  }
  // mu/2 (3 s^2 - 3) - 3 mu ln s + 9/2 lambda ln^2 s: lambda < 0 has the last win where s goes to 0.
  EXPECT_THROW(solid_material(SolidLaw::kNeoHookean, 1.0, -0.01), InputError);
  for (const SolidLaw law :
       {SolidLaw::kCorotational, SolidLaw::kStVenantKirchhoff, SolidLaw::kStableNeoHookean, SolidLaw::kMooneyRivlin}) {
    const SolidMaterial auxetic = solid_material(law, 1.0, -0.5);
    Vec3 gradient;
    for (const double s : {0.5, 0.1, 1e-2, 1e-4, 1e-8})
      EXPECT_GE(energy_density(auxetic, Vec3(s, s, s), &gradient, nullptr), 0.0) << static_cast<int>(law) << " " << s;
  }
}

TEST(PolarRotation, IsTheNearestRotationAlsoWhenInverted) {
  // F = R S, S symmetric; of S the largest two eigenvalues are positive, the smallest has the sign of det F.
  std::mt19937 generator(13);
  for (const Vec3& s : {Vec3(1, 1, 1), Vec3(3, 1, 0.5), Vec3(1, 1e-3, 1e-4), Vec3(1, 0.5, 0), Vec3(1.2, 0.9, -0.3),
                        Vec3(2, 0.4, 0.1), Vec3(0.1, 0.09, 0.08)}) {
    const Mat3 f = with_stretches(s, &generator), r = polar_rotation(f), stretch = r.transpose() * f;
    EXPECT_LT((r.transpose() * r - Mat3::Identity()).norm(), 1e-14) << s.transpose();
    EXPECT_NEAR(r.determinant(), 1.0, 1e-14) << s.transpose();
    EXPECT_LT((stretch - stretch.transpose()).norm(), 1e-13 * s.norm()) << s.transpose();
    const Vec3 eigenvalues = Eigen::SelfAdjointEigenSolver<Mat3>(stretch).eigenvalues();
    EXPECT_NEAR(eigenvalues.sum(), s.sum(), 1e-13 * s.norm()) << s.transpose();
    const SignedSvd svd = signed_svd(f);
    EXPECT_LT((svd.u * svd.s.asDiagonal() * svd.v.transpose() - f).norm(), 1e-14 * s.norm()) << s.transpose();
    EXPECT_NEAR(svd.u.determinant(), 1.0, 1e-14);
    EXPECT_NEAR(svd.v.determinant(), 1.0, 1e-14);
  }
}

TEST(StrainMeasures, AreThoseOfTheTextbook) {
  // F = R U: C = U^2, B = R U^2 R^T, E = (C - I) / 2; simple shear g: C12 = g, C22 = 1 + g^2, B11 = 1 + g^2.
  Mat3 f = Mat3::Identity();
  f(0, 1) = 0.5;
  const Mat3 c = cauchy_green_right(f), b = cauchy_green_left(f), e = green_lagrange(f);
  EXPECT_NEAR(c(0, 1), 0.5, 1e-15);
  EXPECT_NEAR(c(1, 1), 1.25, 1e-15);
  EXPECT_NEAR(b(0, 0), 1.25, 1e-15);
  EXPECT_NEAR(b(1, 1), 1.0, 1e-15);
  EXPECT_NEAR(e(1, 1), 0.125, 1e-15);
  std::mt19937 generator(14);
  EXPECT_LT(green_lagrange(random_rotation(&generator)).norm(), 1e-15);
  // von Mises: |s| in uniaxial tension s, sqrt(3) t in shear t, 0 under pressure.
  EXPECT_NEAR(von_mises(Vec3(2.0, 0.0, 0.0).asDiagonal()), 2.0, 1e-15);
  EXPECT_NEAR(von_mises((Mat3() << 0, 1, 0, 1, 0, 0, 0, 0, 0).finished()), std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(von_mises(Vec3(5.0, 5.0, 5.0).asDiagonal()), 0.0, 1e-15);
}

}  // namespace
}  // namespace deformable_sim::test
