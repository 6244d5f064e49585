// Where rods lose their stability: the load at which the Hessian of an equilibrium stops being positive definite.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/rods.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// Load between `low` (stable) and `high` (not), to a relative 1e-4.
double critical(double low, double high, const std::function<bool(double)>& stable) {
  EXPECT_TRUE(stable(low));
  EXPECT_FALSE(stable(high));
  while (high - low > 1e-4 * high) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

StaticSettings careful(double tolerance, double largest_move = 0.1) {
  StaticSettings settings;
  settings.tolerance = tolerance;
  settings.largest_move = largest_move;
  settings.iterations = 2000;
  return settings;
}

/// Is the equilibrium reached from the start stable? Symmetric starts stay symmetric.
bool is_stable(RodSystem* rod, const StaticSettings& settings) {
  const Equilibrium e = find_equilibrium(rod->system.get(), settings);
  EXPECT_TRUE(e.converged) << e.residual;
  return e.stable;
}

/// Unit rod along `direction`, clamped with the middle of its first segment at the origin, L = 1.
std::unique_ptr<RodSystem> cantilever(const Vec3& direction, int segments, const RodSection& section,
                                      const RodRest& rest) {
  auto rod =
      std::make_unique<RodSystem>(line_along(direction, 1.0 / (segments - 0.5), segments + 1, -0.5), section, rest);
  rod->clamp_start();
  return rod;
}

TEST(RodBuckling, NaturalCurvatureOfAHangingRodTurnsItOutOfPlane) {
  // Inextensible rod of natural curvature k0, clamped pointing down; critical k0 L of the table at Gamma = rho g A
  // L^3/B and c = C/B = 1/(1 + nu) (second variation of the planar equilibrium); 3 %. Light rods are stable again when
  // they curl up further, so the bracket is no wider than that.
  for (const TableRow& row : read_rows("A5_bend_twist_planar_to_3D.csv")) {
    const std::string& expected = row.text("critical_natural_curvature k0*L");
    if (expected.rfind("none", 0) == 0 || expected.empty()) continue;
    const double nu = row("nu_circular_section"), gamma = row("Gamma");
    const bool fast = nu == 0.5 && (gamma == 30.0 || gamma == 100.0);
    if (!verify_all() && !fast) continue;
    const int segments = 60;
    const auto stable = [&](double k0) {
      auto rod =
          cantilever(-Vec3::UnitZ(), segments, unit_section(nu, 1e3 * gamma), curved(k0, segments - 1, Vec3::UnitY()));
      rod->add_gravity(Vec3(0, 0, -gamma));
      return is_stable(rod.get(), careful(1e-7 * gamma));
    };
    const double k0 = row("critical_natural_curvature k0*L");
    check("A3", "rod, critical k0 L at Gamma = " + row.text("Gamma") + ", nu = " + row.text("nu_circular_section"),
          critical(0.97 * k0, 1.03 * k0, stable), k0, 0.03);
  }
}

TEST(RodBuckling, ALightRodCurlsUpInItsPlane) {
  // Gamma = rho g A L^3 / B <= 10: no natural curvature turns the rod out of its plane, whatever C/B = 1/(1 + nu).
  const int segments = 60;
  for (const double nu : {0.0, 0.5}) {
    for (const double k0 : {2.0, 4.0, 6.0, 8.0}) {
      const double gamma = 10.0;
      auto rod =
          cantilever(-Vec3::UnitZ(), segments, unit_section(nu, 1e3 * gamma), curved(k0, segments - 1, Vec3::UnitY()));
      rod->add_gravity(Vec3(0, 0, -gamma));
      check("A3", "rod, planar at Gamma = 10, nu = " + std::to_string(nu) + ", k0 L = " + std::to_string(k0),
            is_stable(rod.get(), careful(1e-7 * gamma)), 1.0, 0.0, Tolerance::kAbsolute);
    }
  }
}

TEST(RodBuckling, ARibbonOnEdgeFallsOverSideways) {
  // q L^3 / sqrt(B_weak C) = 6 j_(-1/6,1) = 12.8538 under its own weight, P L^2 / sqrt(B_weak C) = 2 j_(-1/4,1)
  // = 4.0126 under a tip load, for B_strong >> B_weak; 3 %.
  const int segments = 40;
  RodSection section = unit_section(0.0, 1e6);
  section.bend_2 = 1e4;  // about the horizontal director: the load bends it in its plane hardly at all
  for (const double c : {0.6, 2.0}) {
    if (!verify_all() && c != 2.0) continue;
    section.twist = c;
    const double scale = std::sqrt(section.bend_1 * c);
    for (const bool self_weight : {true, false}) {
      const double expected = self_weight ? 12.85376332 : 4.012599344;
      const auto stable = [&](double load) {
        RodRest rest;
        rest.director = Vec3::UnitZ();
        auto rod = cantilever(Vec3::UnitX(), segments, section, rest);
        if (self_weight) {
          rod->add_gravity(Vec3(0, 0, -load * scale));
        } else {
          Eigen::VectorXd tip = Eigen::VectorXd::Zero(rod->system->mass.size());
          tip[segments] = 1.0;
          rod->system->add(make_gravity(tip, Vec3(0, 0, -load * scale)));
        }
        return is_stable(rod.get(), careful(1e-7));
      };
      check("A4",
            std::string("rod, lateral buckling under ") + (self_weight ? "its weight" : "a tip load") +
                ", C/B = " + std::to_string(c),
            critical(0.8 * expected, 1.2 * expected, stable), expected, 0.03);
    }
  }
}

TEST(RodBuckling, AColumnStandsBelowGreenhillsHeight) {
  // rho g A L^3 / B = 9/4 j_(-1/3,1)^2 = 7.8373.
  const auto stands = [](double gamma) {
    auto rod = cantilever(Vec3::UnitZ(), 50, unit_section(0.0, 1e6), {});
    rod->add_gravity(Vec3(0, 0, -gamma));
    return is_stable(rod.get(), careful(1e-8));
  };
  EXPECT_TRUE(stands(7.4));
  EXPECT_FALSE(stands(8.3));
  check("A5", "rod, Greenhill's self-buckling", critical(7.0, 9.0, stands), 7.837347439, 0.01);
}

struct ColumnEnds {
  const char* name;
  double expected;  // P L^2 / B
  bool clamped_bottom, clamped_top, free_top;
};

TEST(RodBuckling, ColumnsBuckleUnderEulersLoads) {
  // P L^2 / B = pi^2/4, pi^2, 20.1907 (tan x = x), 4 pi^2.
  const ColumnEnds all[] = {{"clamped-free", 2.4674011, true, false, true},
                            {"pinned-pinned", 9.8696044, false, false, false},
                            {"clamped-pinned", 20.1907286, true, false, false},
                            {"clamped-clamped", 39.4784176, true, true, false}};
  const int segments = 50;
  for (const ColumnEnds& ends : all) {
    const auto stable = [&](double load) {
      // A clamp sits in the middle of its segment.
      const double spacing = 1.0 / (segments - (ends.clamped_bottom ? 0.5 : 0.0) - (ends.clamped_top ? 0.5 : 0.0));
      RodSystem rod(line_along(Vec3::UnitZ(), spacing, segments + 1), unit_section(0.0, 1e6));
      StaticSettings settings = careful(1e-7);  // EA is 1e6 N: round-off of the tension is 1e-8
      if (ends.clamped_bottom) {
        rod.clamp_start();
      } else {
        rod.system->hold(0).hold(rod.points);
      }
      if (!ends.free_top) settings.rollers = {{segments, 0}, {segments, 1}};
      if (ends.clamped_top) {
        settings.rollers.push_back({segments - 1, 0});
        settings.rollers.push_back({segments - 1, 1});
      }
      Eigen::VectorXd top = Eigen::VectorXd::Zero(rod.system->mass.size());
      top[segments] = 1.0;
      rod.system->add(make_gravity(top, Vec3(0, 0, -load)));
      return is_stable(&rod, settings);
    };
    check("A5", std::string("rod, Euler load ") + ends.name, critical(0.8 * ends.expected, 1.2 * ends.expected, stable),
          ends.expected, 0.01);
  }
}

TEST(RodBuckling, ATwistedShaftBucklesAtGreenhillsMoment) {
  // Both ends clamped, one free to approach: M L / B = 2 x, tan x = x: 8.98682. Needs the coupling of twist and bending
  // (holonomy) that a chain of springs has not.
  const int segments = 50;
  const double length = 1.0, spacing = length / (segments - 1);
  const auto stable = [&](double moment) {
    const RodSection section = unit_section(0.25, 1e6);
    RodSystem rod(line_along(Vec3::UnitX(), spacing, segments + 1), section);
    rod.clamp_start();
    const double phi = moment * length / section.twist;
    for (int j = 0; j < segments; ++j) rod.set_angle(j, phi * j / (segments - 1));
    StaticSettings settings = careful(1e-8);
    settings.rollers = {
        {segments - 1, 1}, {segments - 1, 2}, {segments, 1}, {segments, 2}, {rod.points + segments - 1, 0}};
    return is_stable(&rod, settings);
  };
  check("B12", "rod, buckling moment of a clamped shaft, M L/B", critical(8.0, 10.0, stable), 8.98681892, 0.01);
}

TEST(RodBuckling, ATwistedRingLeavesItsPlaneAtMichellsTwist) {
  // A straight round rod, turned by Phi and closed to a ring, is flat up to Phi = 2 pi sqrt(3) B / C [Michell 1889].
  const int nodes = 48;
  const RodSection section = unit_section(0.25, 1e5);
  const auto stable = [&](double phi) {
    const Polyline line = make_ring(2.0 * M_PI, nodes);
    RodRest rest;
    rest.twist = Eigen::VectorXd::Constant(nodes, -phi / (2.0 * M_PI));
    RodSystem rod(line, section, rest);
    // Six rigid motions and the spin of the rod about its centre line are held.
    StaticSettings settings = careful(1e-7);
    settings.rollers = {{0, 0}, {0, 1}, {0, 2}, {nodes / 2, 1}, {nodes / 2, 2}, {nodes / 4, 2}, {nodes, 0}};
    return is_stable(&rod, settings);
  };
  const double expected = 2.0 * M_PI * std::sqrt(3.0) / section.twist;
  check("B12", "rod, twist at which a ring buckles, rad", critical(0.8 * expected, 1.2 * expected, stable), expected,
        0.01);
}

}  // namespace
}  // namespace deformable_sim::test
