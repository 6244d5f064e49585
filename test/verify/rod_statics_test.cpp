// Rods at rest against the elastica: heavy cantilever, tip load, end moment, torsion.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/element/rod_frame.h"
#include "support/rods.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// A unit rod along x, clamped with the middle of its first segment at the origin, L = (segments - 1/2) l = 1 m.
std::unique_ptr<RodSystem> cantilever(int segments, double stretch) {
  auto rod = std::make_unique<RodSystem>(line_along(Vec3::UnitX(), 1.0 / (segments - 0.5), segments + 1, -0.5),
                                         unit_section(0.0, stretch));
  rod->clamp_start();
  return rod;
}

StaticSettings careful(double tolerance, double largest_move = 0.1) {
  StaticSettings settings;
  settings.tolerance = tolerance;
  settings.largest_move = largest_move;
  settings.iterations = 2000;
  return settings;
}

/// Drop of the tip over the largest horizontal reach of a heavy cantilever.
double drop_over_reach(double gamma, int segments) {
  auto rod = cantilever(segments, 1e4 * (1.0 + gamma));
  rod->add_gravity(Vec3(0, 0, -gamma));  // linear density 1 kg/m, B = 1, L = 1
  const Equilibrium rest = find_equilibrium(rod->system.get(), careful(1e-8 * gamma));
  EXPECT_TRUE(rest.converged) << "Gamma " << gamma << ", residual " << rest.residual;
  const auto x = rod->state().x.leftCols(rod->points);
  return -x(2, rod->points - 1) / x.row(0).maxCoeff();
}

TEST(RodCantilever, HangsOnTheHeavyElastica) {
  // theta'' = -Gamma (1 - s) cos theta, theta(0) = 0, theta'(1) = 0; H/W of the table, 2 % with 50 segments. Second
  // order in the segment length, so two meshes extrapolate: 1 %.
  for (const TableRow& row : read_rows("A1_cantilever_heavy_elastica.csv")) {
    const double gamma = row("Gamma"), expected = row("H_over_W");
    if (gamma < 0.0999 || gamma > 1000.0) continue;
    const double decade = std::log10(gamma);
    if (!verify_all() && std::abs(decade - std::round(decade)) > 1e-6) continue;
    const std::string what = "rod, H/W at Gamma = " + row.text("Gamma");
    const double coarse = drop_over_reach(gamma, 50), fine = drop_over_reach(gamma, 100);
    check("A1", what + ", 50 segments", coarse, expected, 0.02);
    // Segment lengths are 1 / (n - 1/2).
    const double ratio = std::pow(99.5 / 49.5, 2);
    check("A1", what + ", extrapolated", (ratio * fine - coarse) / (ratio - 1.0), expected, 0.01);
  }
}

/// Constant force on one node.
std::unique_ptr<Energy> point_load(int columns, int node, const Vec3& force) {
  Eigen::VectorXd share = Eigen::VectorXd::Zero(columns);
  share[node] = 1.0;
  return make_gravity(share, force);
}

TEST(RodCantilever, BendsUnderATipLoadLikeTheElastica) {
  // Bisshopp and Drucker 1945: theta'' = -alpha cos theta, alpha = P L^2 / B; deflections of the tip, 1 % of L.
  for (const TableRow& row : read_rows("A3_cantilever_tip_load_elastica.csv")) {
    const double alpha = row("PL2_over_B");
    if (!verify_all() && alpha != 0.5 && alpha != 1.0 && alpha != 2.0 && alpha != 4.0 && alpha != 10.0) continue;
    const int segments = 50;
    auto rod = cantilever(segments, 1e5);
    rod->system->add(point_load(rod->points + rod->segments, segments, Vec3(0, 0, -alpha)));
    EXPECT_TRUE(find_equilibrium(rod->system.get(), careful(1e-8)).converged) << alpha;
    const Vec3 tip = rod->state().x.col(segments);
    check("A5", "rod, tip deflection at PL^2/B = " + row.text("PL2_over_B"), -tip.z(), row("deltaV_over_L"), 0.01);
    check("A5", "rod, tip shortening at PL^2/B = " + row.text("PL2_over_B"), 1.0 - tip.x(), row("deltaH_over_L"), 0.01);
  }
}

/// A moment M (N m) about -y on the segment from node a to b: E = -M angle, the angle of the edge in the x-z plane
/// followed over whole turns.
class EndMoment : public Energy {
 public:
  EndMoment(int a, int b, double moment) : a_(a), b_(b), moment_(moment) {}
  void set(double moment) { moment_ = moment; }

  std::string name() const override { return "end moment"; }
  int element_count() const override { return 1; }
  double value(const State& s) const override { return -moment_ * angle(s); }
  void add_force(const State& s, Nodes* f) const override {
    const Vec3 d = s.x.col(b_) - s.x.col(a_);
    const Vec3 pull = moment_ / (d.x() * d.x() + d.z() * d.z()) * Vec3(-d.z(), 0.0, d.x());
    f->col(a_) -= pull;
    f->col(b_) += pull;
  }
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override { pairs->push_back({a_, b_}); }
  void bind(const BlockMatrix& m) override { slot_ = {m.slot(a_, a_), m.slot(a_, b_), m.slot(b_, a_), m.slot(b_, b_)}; }
  void add_jacobian(const State& s, double dx, double, Jacobian kind, BlockMatrix* a) const override {
    if (kind != Jacobian::kExact) return;
    const Vec3 d = s.x.col(b_) - s.x.col(a_);
    const double x = d.x(), z = d.z(), factor = -dx * moment_ / std::pow(x * x + z * z, 2);
    Mat3 h = Mat3::Zero();
    h(0, 0) = factor * 2.0 * x * z;
    h(2, 2) = -h(0, 0);
    h(0, 2) = h(2, 0) = factor * (z * z - x * x);
    a->block(slot_[0]) += h;
    a->block(slot_[1]) -= h;
    a->block(slot_[2]) -= h;
    a->block(slot_[3]) += h;
  }
  void end_step(State* s) const override { last_ = angle(*s); }

 private:
  double angle(const State& s) const {
    const Vec3 d = s.x.col(b_) - s.x.col(a_);
    return unwrapped(std::atan2(d.z(), d.x()), last_);
  }
  int a_, b_;
  double moment_;
  mutable double last_ = 0.0;
  std::array<int, 4> slot_{};
};

TEST(RodCantilever, ClosesToACircleUnderAnEndMoment) {
  // kappa = M / B: M = 2 pi B / L makes a full circle. Tip at the root to 1e-3 L; shape within 1e-3 L rms, stretch
  // below 1e-3, angles of the joints within 0.12 degrees rms of the arc.
  const int segments = 40;
  RodSystem rod(line_along(Vec3::UnitX(), 1.0 / segments, segments + 1), unit_section(0.0, 1e5));
  rod.clamp_start();
  auto term = std::make_unique<EndMoment>(segments - 1, segments, 0.0);
  EndMoment* moment = term.get();
  rod.system->add(std::move(term));
  // The two halves of end segments do not bend: joints cover L - l.
  const double length = 1.0 - 1.0 / segments, turn = 2.0 * M_PI / segments;
  for (int k = 1; k <= 20; ++k) {
    moment->set(k / 20.0 * (segments - 1) * turn / length);
    ASSERT_TRUE(find_equilibrium(rod.system.get(), careful(1e-9, 0.05)).converged) << "load " << k;
  }
  const auto x = rod.state().x.leftCols(rod.points);
  check("A5", "rod, gap of the circle over L (40 segments)", (x.col(segments) - x.col(0)).norm(), 0.0, 1e-3,
        Tolerance::kAbsolute);
  const double radius = 0.5 / segments / std::sin(0.5 * turn);
  const Vec3 center(0.5 / segments, 0.0, radius * std::cos(0.5 * turn));
  double shape = 0.0, stretch = 0.0, angles = 0.0;
  for (int k = 0; k <= segments; ++k) shape += std::pow((x.col(k) - center).norm() - radius, 2) / (segments + 1);
  for (int k = 0; k < segments; ++k)
    stretch = std::max(stretch, std::abs((x.col(k + 1) - x.col(k)).norm() * segments - 1.0));
  for (int k = 1; k < segments; ++k) {
    const Vec3 a = (x.col(k) - x.col(k - 1)).normalized(), b = (x.col(k + 1) - x.col(k)).normalized();
    angles += std::pow(std::atan2(a.cross(b).norm(), a.dot(b)) - turn, 2) / (segments - 1);
  }
  check("A5", "rod, rms distance from the circle over L", std::sqrt(shape), 0.0, 1e-3, Tolerance::kAbsolute);
  check("A5", "rod, largest stretch in the circle", stretch, 0.0, 1e-3, Tolerance::kAbsolute);
  check("A5", "rod, rms error of joint angles, degrees", std::sqrt(angles) * 180.0 / M_PI, 0.0, 0.12,
        Tolerance::kAbsolute);
}

TEST(RodTorsion, TwistsInProportionToTheMoment) {
  // phi = M L / C between the middles of the end segments, by whole turns if need be; exact for the discrete rod.
  const int segments = 12;
  for (const double turns : {0.1, 3.0}) {
    RodSystem rod(line_along(Vec3::UnitX(), 0.1, segments + 1), unit_section(0.25));
    // Twisted that far a free rod would buckle; this one is pulled taut.
    rod.state().x.leftCols(rod.points) *= 1.02;
    rod.system->hold(0).hold(1).hold(segments - 1).hold(segments).hold(rod.points).hold(rod.points + segments - 1);
    auto& k = rod.system->dynamics.kinematics;
    const double phi = 2.0 * M_PI * turns;
    k.target(0, 5) = phi * rod.section.radius_of_gyration;
    ASSERT_TRUE(find_equilibrium(rod.system.get(), careful(1e-10, 0.0)).converged);
    const double moment = k.reaction(0, 5) * rod.section.radius_of_gyration;
    const double length = 0.1 * (segments - 1);
    check("B12", "rod, moment at " + std::to_string(turns) + " turns, N m", moment, rod.section.twist * phi / length,
          1e-8);
    check("B12", "rod, moment at the other end at " + std::to_string(turns) + " turns, N m",
          k.reaction(0, 4) * rod.section.radius_of_gyration, -moment, 1e-8);
  }
}

}  // namespace
}  // namespace deformable_sim::test
