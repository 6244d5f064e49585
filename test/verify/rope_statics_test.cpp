// Ropes of springs at rest: hanging rope, catenary of rigid links, catenary, elastic catenary.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/slope.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

SpringNetwork rope_springs(const Polyline& line, double axial) {
  LineStiffness stiffness;
  stiffness.axial = axial;
  stiffness.bend = 0.0;
  return line_network(line, stiffness);
}

TEST(HangingRope, StretchesUnderItsOwnWeightExactly) {
  // N springs k = EA N / L, masses M / N at their lower ends: M g L / (EA) (N + 1) / (2 N); with half a mass at each
  // end, as line_masses gives, M g L / (2 EA); a weight at the tip adds m g L / (EA).
  const double length = 1.2, axial = 80.0, mass = 0.3, tip = 0.5;
  for (const TableRow& row : read_rows("B3_hanging_rope_elongation.csv")) {
    const int n = static_cast<int>(row("N_springs"));
    const Polyline line = make_line(length, n);
    Nodes x = Nodes::Zero(3, n + 1);
    for (int i = 0; i <= n; ++i) x(2, i) = -length * i / n;
    const auto elongation = [&](const Eigen::VectorXd& masses) {
      System rope(x, masses);
      rope.add_springs(rope_springs(line, axial)).add_gravity().hold(0);
      EXPECT_TRUE(find_equilibrium(&rope).converged);
      return (-rope.state.x(2, n) - length) * axial / (kGravity * length);
    };
    const std::string name = "rope of " + std::to_string(n) + " springs, elongation EA / (M g L), ";
    const double at_ends = row("delta*EA/(M g L) masses at lower ends = (N+1)/2N");
    check("B3", name + "masses at lower ends", elongation(Eigen::VectorXd::Constant(n + 1, mass / n)) / mass, at_ends,
          1e-8);
    const double lumped = row("delta*EA/(M g L) lumped half-masses at ends (exact continuum)");
    Eigen::VectorXd masses = line_masses(line, mass / length);
    check("B3", name + "half masses at the ends", elongation(masses) / mass, lumped, 1e-8);
    masses[n] += tip;
    check("B3", name + "with a weight, minus that weight's", (elongation(masses) - tip) / mass, lumped, 1e-8);
  }
}

/// Shape of a rope of n springs and unit weight and length that hangs from two points `span` apart.
struct Hanging {
  double horizontal = 0.0, sag = 0.0, length = 0.0, end_tension = 0.0;
};

Hanging hang(int n, double span, double axial) {
  const Polyline line = make_line(1.0, n);
  // Starts on a catenary 1 % longer than the rope or its span: every link is taut, so that the energy is convex all the
  // way down.
  const double longer = 1.01 * std::max(1.0, span);
  double low = 0.01 * span, high = 100.0 * span;
  for (int k = 0; k < 60; ++k) {  // 2 a sinh(d / 2a) falls with a
    const double a = 0.5 * (low + high);
    (2.0 * a * std::sinh(0.5 * span / a) > longer ? low : high) = a;
  }
  Nodes x = Nodes::Zero(3, n + 1);
  for (int i = 0; i <= n; ++i) {
    const double s = longer * (static_cast<double>(i) / n - 0.5);
    x.col(i) = Vec3(low * std::asinh(s / low), 0, std::hypot(low, s) - std::hypot(low, 0.5 * longer));
  }
  System rope(x, line_masses(line, 1.0 / kGravity));
  rope.add_springs(rope_springs(line, axial)).add_gravity().hold(0).hold(n);
  StaticSettings settings;
  settings.tolerance = std::max(1e-10, 3e-15 * axial * n);  // N: rounding of lengths times stiffness
  settings.iterations = 1000;
  EXPECT_TRUE(find_equilibrium(&rope, settings).converged) << n << " springs, span " << span << ", EA " << axial;
  Hanging found;
  found.horizontal = std::abs(rope.dynamics.kinematics.reaction(0, 0));
  found.sag = -rope.state.x.row(2).minCoeff();
  for (int i = 0; i < n; ++i) found.length += (rope.state.x.col(i + 1) - rope.state.x.col(i)).norm();
  const double l = (rope.state.x.col(1) - rope.state.x.col(0)).norm();
  found.end_tension = axial * (l * n - 1.0);
  return found;
}

/// Limit of EA -> infinity from five stiffnesses: removes 1/EA to its fourth power.
template <class Quantity>
double rigid_limit(int n, double span, double axial, Quantity quantity) {
  std::array<double, 5> limit{};
  for (size_t k = 0; k < 5; ++k) limit[k] = quantity(hang(n, span, std::ldexp(axial, static_cast<int>(k))));
  for (int order = 1; order < 5; ++order) {
    for (size_t k = 4; k >= static_cast<size_t>(order); --k) {
      limit[k] += (limit[k] - limit[k - 1]) / (std::ldexp(1.0, order) - 1.0);
    }
  }
  return limit[4];
}

TEST(HangingLinks, AreTheCatenaryOfRigidLinks) {
  // tan theta_i = (i - (N + 1) / 2) m g / H: exact for N rigid links; springs in the limit of 1 / EA, extrapolated.
  for (const TableRow& row : read_rows("B1b_catenary_discrete_links.csv")) {
    const int n = static_cast<int>(row("N_links"));
    if (n > 16 && !verify_all()) continue;
    const double span = row("span_over_L");
    const std::string name = std::to_string(n) + " links, span " + row.text("span_over_L");
    const double axial = 300.0;
    check("B1b", name + ", H / (w L)", rigid_limit(n, span, axial, [](const Hanging& h) { return h.horizontal; }),
          row("H_over_wL"), 1e-8);
    check("B1b", name + ", sag / L", rigid_limit(n, span, axial, [](const Hanging& h) { return h.sag; }),
          row("sag_over_L"), 1e-8);
    check("B1b", name + ", tension of the end links / (w L)",
          rigid_limit(n, span, axial, [](const Hanging& h) { return h.end_tension; }), row("T_end_link_over_wL"), 1e-8);
  }
}

/// Limit of n -> infinity and order of convergence from n, 2n, 4n.
struct Limit {
  double value = 0.0, order = 0.0;
};

Limit limit_of(double coarse, double middle, double fine) {
  return {fine + (fine - middle) / 3.0, std::log2((middle - coarse) / (fine - middle))};
}

TEST(HangingRope, SettlesOnTheCatenary) {
  // 2 a sinh(d / 2a) = L, sag = a (cosh(d / 2a) - 1), H = a w: second order in the number of springs, limit within 0.5
  // % (in fact the strain of EA = 1e4 weights).
  for (const TableRow& row : read_rows("B1_catenary.csv")) {
    const double span = row("span_over_L");
    if (!verify_all() && std::abs(span - 0.5) > 1e-9 && std::abs(span - 0.8) > 1e-9 && std::abs(span - 0.95) > 1e-9)
      continue;
    if (span > 0.985) continue;  // nearly straight: the strain of the springs decides
    const std::string name = "catenary, span " + row.text("span_over_L");
    const int n = span < 0.35 ? 100 : 10;  // the bend at the bottom of narrow ones has a radius of L / 100
    const Hanging a = hang(n, span, 1e4), b = hang(2 * n, span, 1e4), c = hang(4 * n, span, 1e4);
    const Limit sag = limit_of(a.sag, b.sag, c.sag), pull = limit_of(a.horizontal, b.horizontal, c.horizontal);
    check("B1", name + ", sag / L", sag.value, row("sag_over_L"), 0.005);
    check("B1", name + ", H / (w L)", pull.value, row("H_over_wL"), 0.005);
    check("B1", name + ", order of the sag", sag.order, 2.0, 0.2, Tolerance::kAbsolute);
  }
}

TEST(HangingRope, SettlesOnTheElasticCatenary) {
  // [Irvine 1981]: x(s) = H s / EA + H/w (asinh(V/H) - asinh((V - w s)/H)), second order, limit within 0.2 %.
  for (const TableRow& row : read_rows("B2_elastic_catenary_irvine.csv")) {
    const double ratio = row("wL0_over_EA"), span = row("span_over_L0");
    if (ratio < 1e-3) continue;  // rigid: the rows above
    if (!verify_all() && ratio < 0.05) continue;
    const std::string name =
        "elastic catenary, span " + row.text("span_over_L0") + ", w L / EA " + row.text("wL0_over_EA");
    const Hanging a = hang(10, span, 1.0 / ratio), b = hang(20, span, 1.0 / ratio), c = hang(40, span, 1.0 / ratio);
    check("B2", name + ", H / (w L)", limit_of(a.horizontal, b.horizontal, c.horizontal).value, row("H_over_wL0"),
          0.002);
    check("B2", name + ", sag / L", limit_of(a.sag, b.sag, c.sag).value, row("sag_over_L0"), 0.002);
    check("B2", name + ", length / L", limit_of(a.length, b.length, c.length).value, row("stretched_length_over_L0"),
          0.002);
    check("B2", name + ", order of the sag", limit_of(a.sag, b.sag, c.sag).order, 2.0, 0.2, Tolerance::kAbsolute);
  }
}

}  // namespace
}  // namespace deformable_sim::test
