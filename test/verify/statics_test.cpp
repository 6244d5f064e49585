// Equilibria against closed forms: hanging chain, catenary.
#include <gtest/gtest.h>

#include <cmath>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

TEST(HangingChain, StretchesUnderItsOwnWeightExactly) {
  // N springs k = EA N / L, masses M / N: elongation M g L / (EA) (N + 1) / (2 N); with half a mass at each end, as
  // line_masses gives, exactly M g L / (2 EA).
  const double length = 1.2, axial = 80.0, mass = 0.3;
  for (const int n : {1, 5, 20}) {
    const Polyline line = make_line(length, n);
    LineStiffness stiffness;
    stiffness.axial = axial;
    stiffness.bend = 0.0;
    for (const bool lumped_in_halves : {false, true}) {
      const Eigen::VectorXd masses =
          lumped_in_halves ? line_masses(line, mass / length) : Eigen::VectorXd::Constant(n + 1, mass / n);
      Nodes x = Nodes::Zero(3, n + 1);
      for (int i = 0; i <= n; ++i) x(2, i) = -length * i / n;
      System chain(x, masses);
      chain.add_springs(line_network(line, stiffness)).add_gravity().hold(0);
      ASSERT_LT(relax(&chain), 1e-6);
      const double share = lumped_in_halves ? 0.5 : 0.5 * (n + 1) / n;
      EXPECT_NEAR(-chain.state.x(2, n) - length, mass * kGravity * length / axial * share, 1e-8) << n;
    }
  }
}

/// y of the catenary of length `length` over `span`, lowest at x = 0, zero at its ends.
class Catenary {
 public:
  Catenary(double span, double length) : half_(0.5 * span) {
    double low = 0.05 * span, high = 100.0 * span;  // 2 a sinh(d / 2a) falls with a
    for (int k = 0; k < 200; ++k) {
      a_ = 0.5 * (low + high);
      (2.0 * a_ * std::sinh(half_ / a_) > length ? low : high) = a_;
    }
  }
  double sag() const { return a_ * (std::cosh(half_ / a_) - 1.0); }
  /// The point at arc length s from the lowest one.
  Vec3 at(double s) const {
    const double x = a_ * std::asinh(s / a_);
    return Vec3(x, 0, a_ * (std::cosh(x / a_) - std::cosh(half_ / a_)));
  }

 private:
  double half_;
  double a_ = 0.0;
};

TEST(Catenary, HasTheTabulatedSag) {
  EXPECT_NEAR(Catenary(0.5, 1.0).sag(), 0.398194, 1e-6);
  EXPECT_NEAR(Catenary(0.8, 1.0).sag(), 0.265438, 1e-6);
  EXPECT_NEAR(Catenary(0.95, 1.0).sag(), 0.135898, 1e-6);
}

TEST(HangingChain, SettlesOnTheCatenary) {
  // Inextensible limit: EA is 2e4 times the weight, strain below 1e-4. RMS distance below 0.2 % of the length.
  const double length = 1.0;
  const int n = 50;
  for (const double span : {0.5, 0.8, 0.95}) {
    const Polyline line = make_line(length, n);
    LineStiffness stiffness;
    stiffness.axial = 1e4;
    stiffness.bend = 0.0;
    const Catenary expected(span, length);
    Nodes start(3, n + 1);
    for (int i = 0; i <= n; ++i) {
      const double s = length * (static_cast<double>(i) / n - 0.5);
      start.col(i) = Vec3(span * s / length, 0, -0.3 * std::cos(M_PI * s / length));
    }
    System chain(start, line_masses(line, 0.05));
    chain.add_springs(line_network(line, stiffness)).add_gravity().hold(0).hold(n);
    ASSERT_LT(relax(&chain, 1.0, 60, 1e-5), 1e-3);
    double sum = 0.0;
    for (int i = 0; i <= n; ++i) {
      sum += (chain.state.x.col(i) - expected.at(length * (static_cast<double>(i) / n - 0.5))).squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / (n + 1)), 2e-3 * length) << span;
    // Each holder carries half the weight and the horizontal pull w a.
    EXPECT_NEAR(chain.dynamics.kinematics.reaction(2, 0), 0.5 * 0.05 * kGravity, 1e-4) << span;
  }
}

}  // namespace
}  // namespace deformable_sim::test
