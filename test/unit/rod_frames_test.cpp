// Frames of rods carried through space: closed rods, whole turns, holonomy.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/element/rod_bend.h"
#include "deformable_sim/core/rod_frames.h"
#include "support/rods.h"

namespace deformable_sim::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Writhe of a closed polygon, sum of signed solid angles over pairs of segments [Klenin 2000, method 1a].
double writhe(const Nodes& x) {
  const auto n = static_cast<int>(x.cols());
  const auto arcsine = [](const Vec3& a, const Vec3& b) { return std::asin(std::max(-1.0, std::min(1.0, a.dot(b)))); };
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vec3 p1 = x.col(i), p2 = x.col(i + 1), p3 = x.col(j), p4 = x.col((j + 1) % n);
      const Vec3 r13 = p3 - p1, r14 = p4 - p1, r23 = p3 - p2, r24 = p4 - p2;
      Vec3 n1 = r13.cross(r14), n2 = r14.cross(r24), n3 = r24.cross(r23), n4 = r23.cross(r13);
      if (n1.norm() * n2.norm() * n3.norm() * n4.norm() < 1e-30) continue;
      n1.normalize(), n2.normalize(), n3.normalize(), n4.normalize();
      const double angle = arcsine(n1, n2) + arcsine(n2, n3) + arcsine(n3, n4) + arcsine(n4, n1);
      const double side = (p4 - p3).cross(p2 - p1).dot(r13);
      sum += (side > 0.0 ? angle : -angle) / (2.0 * kPi);
    }
  }
  return sum;
}

TEST(ParallelTransport, KeepsLengthsAnglesAndTheAxisOfTheTurn) {
  const Vec3 from = Vec3(1, 2, -0.5).normalized(), to = Vec3(-0.3, 1, 1).normalized();
  const Vec3 d = from.unitOrthogonal(), axis = from.cross(to).normalized();
  const Vec3 carried = transported(d, from, to);
  EXPECT_NEAR(carried.norm(), 1.0, 1e-15);
  EXPECT_NEAR(carried.dot(to), 0.0, 1e-15);
  EXPECT_NEAR(carried.dot(axis), d.dot(axis), 1e-15);
  EXPECT_EQ(transported(d, from, from), d);
}

TEST(ParallelTransport, TurnsADirectorByTheAreaItsTangentGoesRound) {
  // Once round an octant of the sphere: pi / 2.
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const Vec3 back = transported(transported(transported(y, x, y), y, z), z, x);
  EXPECT_NEAR(angle_about(x, y, back), kPi / 2.0, 1e-15);
}

/// A ring bent out of its plane, ever further: `amount` 0 is the circle.
Nodes bent_ring(int nodes, double amount) {
  Nodes x(3, nodes);
  for (int i = 0; i < nodes; ++i) {
    const double a = 2.0 * kPi * i / nodes;
    x.col(i) = Vec3((1.0 + 0.3 * amount * std::cos(2.0 * a)) * std::cos(a), std::sin(a) * (1.0 - 0.8 * amount),
                    amount * std::sin(2.0 * a + 0.4) + 0.3 * amount * std::sin(3.0 * a));
  }
  return x;
}

TEST(ClosedRod, TradesTwistForWrithe) {
  // Calugareanu, White, Fuller: link = twist + writhe stays while a closed rod is deformed without cutting it; the
  // angles are untouched, so the reference twists take up all of the change: sum r + 2 pi writhe = 0.
  const int nodes = 24;
  Polyline line;
  line.closed = true;
  line.rest = bent_ring(nodes, 0.0);
  RodSystem rod(line, soft_section(), rest_as_drawn(line));
  for (int k = 1; k <= 60; ++k) {
    rod.state().x.leftCols(nodes) = bent_ring(nodes, k / 60.0);
    rod.carry_frames();
  }
  const double w = writhe(bent_ring(nodes, 1.0));
  EXPECT_GT(std::abs(w), 0.1);
  EXPECT_NEAR(rod.state().reference_twists.sum(), -2.0 * kPi * w, 1e-10);
}

TEST(ClosedRod, SpreadsTheTwistOfItsClosureEvenly) {
  // Drawn out of plane, the frame carried round does not close: each joint gets an equal share of the rest.
  const int nodes = 24;
  Polyline line;
  line.closed = true;
  line.rest = bent_ring(nodes, 0.7);
  RodSection section = soft_section();
  section.bend_2 = section.bend_1;
  RodSystem rod(line, section, rest_as_drawn(line));
  double total = 0.0, first = 0.0;
  for (int k = 0; k < nodes; ++k) {
    const double twist = rod.angle((k + 1) % nodes) - rod.angle(k) + rod.state().reference_twists[k];
    if (k == 0) first = twist;
    EXPECT_NEAR(twist, first, 1e-12);
    total += twist;
  }
  EXPECT_GT(std::abs(total), 0.05);
  EXPECT_NEAR(std::remainder(total + 2.0 * kPi * writhe(line.rest), 2.0 * kPi), 0.0, 1e-10);
  // The curvature is that of the drawing, seen from frames that are turned by half the twist either way:
  // E = C m^2 / 2l + B k^2 / 2l (2 sin(m / 4))^2.
  double expected = 0.0;
  const auto edge = [&](int j) { return Vec3(line.rest.col((j + 1) % nodes) - line.rest.col(j % nodes)); };
  for (int k = 0; k < nodes; ++k) {
    const Vec3 a = edge(k), b = edge(k + 1);
    const double bend = RodCurvature::of_turn(std::atan2(a.cross(b).norm(), a.dot(b))) * 2.0 * std::sin(0.25 * first);
    expected += (section.twist * first * first + section.bend_1 * bend * bend) / (a.norm() + b.norm());
  }
  EXPECT_NEAR(rod.system->dynamics.energies[1]->value(rod.state()), expected, 1e-10 * expected);
}

TEST(RodFrames, CountWholeTurnsOfTheReference) {
  // Two segments half a radian apart, swung round the axis of the first: each turn leaves 2 pi (1 - cos 0.5) between
  // their directors. A plain angle would jump at half a turn; the twist of the joint must not.
  RodSystem rod(line_along(Vec3::UnitZ(), 1.0, 3), soft_section());
  const auto swing = [&](double a) {
    rod.state().x.col(2) =
        rod.state().x.col(1) + Vec3(std::sin(0.5) * std::cos(a), std::sin(0.5) * std::sin(a), std::cos(0.5));
    rod.carry_frames();
  };
  swing(0.0);
  const double start = rod.state().reference_twists[0];
  double last = start;
  const int steps = 200, turns = 12;
  for (int k = 1; k <= turns * steps; ++k) {
    swing(2.0 * kPi * k / steps);
    EXPECT_LT(std::abs(rod.state().reference_twists[0] - last), 0.1);
    last = rod.state().reference_twists[0];
  }
  // The polygon on the sphere has a little less area than the cap: second order in the step.
  EXPECT_NEAR(std::abs(last - start), turns * 2.0 * kPi * (1.0 - std::cos(0.5)), 2e-3 * turns);
  EXPECT_GT(std::abs(last - start), 3.0 * kPi / 2.0);
}

TEST(RodFrames, DoNotDriftInManySteps) {
  // Unit directors normal to their tangents after a hundred thousand small turns.
  RodSystem rod(line_along(Vec3::UnitX(), 1.0, 2), soft_section());
  State s = rod.state();
  for (int k = 0; k < 100000; ++k) {
    s.x.col(1) += 0.02 * Vec3(std::sin(1.7 * k), std::cos(2.3 * k), std::sin(0.9 * k + 1.0));
    carry_frames(0, 1, 0, false, &s);
  }
  EXPECT_NEAR(s.directors.col(0).norm(), 1.0, 1e-15);
  EXPECT_NEAR(s.directors.col(0).dot(s.tangents.col(0)), 0.0, 1e-15);
}

}  // namespace
}  // namespace deformable_sim::test
