// The terms of rods: derivatives, momentum, rigid motion, twist that a chain of springs does not have.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/rod_frames.h"
#include "support/derivative_harness.h"
#include "support/rods.h"

namespace deformable_sim::test {
namespace {

constexpr int kPoints = 5;

Polyline crooked_line(bool closed, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  Polyline line;
  line.closed = closed;
  line.rest.resize(3, kPoints);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * M_PI * i / kPoints;
    line.rest.col(i) = closed ? Vec3(std::cos(angle), std::sin(angle), 0.0) : Vec3(i, 0.0, 0.0);
    line.rest.col(i) += 0.15 * Vec3(normal(generator), normal(generator), normal(generator));
  }
  return line;
}

RodRest some_rest(int joints) {
  RodRest rest;
  rest.curvature = Eigen::Matrix2Xd::Zero(2, joints);
  rest.twist = Eigen::VectorXd::LinSpaced(joints, -0.3, 0.4);
  for (int k = 0; k < joints; ++k) rest.curvature.col(k) = Eigen::Vector2d(0.3 - 0.1 * k, 0.2 * k);
  return rest;
}

/// `spread` moves points and angles at random after the frames were stored, `scale` stretches, `fold` puts the third
/// point back nearly onto the first.
State moved_state(RodSystem* rod, unsigned seed, double spread, double scale, bool fold) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  State& s = rod->state();
  s.x.leftCols(rod->points) *= scale;
  if (fold) s.x.col(2) = s.x.col(0) + Vec3(0.02, 0.08, -0.05);
  s.x.rightCols(rod->segments).row(0).setRandom();
  rod->carry_frames();
  for (int i = 0; i < s.x.cols(); ++i) {
    const bool angle = i >= rod->points;
    for (int k = 0; k < (angle ? 1 : 3); ++k) {
      s.x(k, i) += spread * normal(generator);
      s.v(k, i) = normal(generator);
    }
  }
  return s;
}

Nodes rod_forces(const RodSystem& rod, const State& s) {
  Nodes f = Nodes::Zero(3, s.x.cols());
  for (const Energy* term : rod.system->dynamics.energies) term->add_force(s, &f);
  return f;
}

TEST(RodTerms, HaveTheDerivativesTheyDeliver) {
  // f = -dE/dx and A = -(dx df/dx + dv df/dv) against central differences: near the stored frames and far from them.
  for (const bool closed : {false, true}) {
    for (unsigned seed = 0; seed < 3; ++seed) {
      for (const double spread : {0.0, 0.02, 0.3}) {
        for (const double scale : {0.6, 1.0, 1.7}) {
          for (const double damping : {0.0, 0.3}) {
            SCOPED_TRACE("seed " + std::to_string(seed) + ", spread " + std::to_string(spread) + ", scale " +
                         std::to_string(scale) + (closed ? ", closed" : ", open"));
            const Polyline line = crooked_line(closed, seed);
            RodSection section = soft_section();
            section.damping = damping;
            RodSystem rod(line, section, some_rest(closed ? kPoints : kPoints - 2));
            const State s = moved_state(&rod, seed + 10, spread, scale, false);
            for (const Energy* term : rod.system->dynamics.energies) {
              check_derivatives(const_cast<Energy*>(term), s, true);
            }
          }
        }
      }
    }
  }
}

TEST(RodTerms, HaveTheirDerivativesNearlyFoldedBackAndHeldStraight) {
  // The curvature grows without bound as a joint folds back; a perfectly straight rod has zero of everything.
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RodSystem folded(crooked_line(false, seed), soft_section(), some_rest(kPoints - 2));
    const State s = moved_state(&folded, seed, 0.0, 1.0, true);
    for (const Energy* term : folded.system->dynamics.energies) check_derivatives(const_cast<Energy*>(term), s, true);
  }
  RodSystem straight(line_along(Vec3(0.6, 0.0, 0.8), 1.0, kPoints), soft_section());
  straight.carry_frames();
  for (const Energy* term : straight.system->dynamics.energies)
    check_derivatives(const_cast<Energy*>(term), straight.state(), true);
}

TEST(RodTerms, StayFiniteWhereTheyAreUndefined) {
  // A segment without length has no direction, a joint folded back onto itself no plane: no forces, but no NaN.
  RodSystem rod(line_along(Vec3::UnitX(), 1.0, kPoints), soft_section());
  State s = rod.state();
  s.x.col(2) = s.x.col(1);
  EXPECT_TRUE(force_of(*rod.system->dynamics.energies[1], s).allFinite());
  s = rod.state();
  s.x.col(2) = s.x.col(0);
  EXPECT_TRUE(force_of(*rod.system->dynamics.energies[1], s).allFinite());
}

/// Sum of x cross f and of the moments about the tangents.
Vec3 moment_of(const RodSystem& rod, const State& s, const Nodes& f) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < rod.points; ++i) sum += Vec3(s.x.col(i)).cross(Vec3(f.col(i)));
  for (int j = 0; j < rod.segments; ++j)
    sum += rod.section.radius_of_gyration * f(0, rod.points + j) * s.tangents.col(j);
  return sum;
}

TEST(RodTerms, ExertNoForceAndNoMomentOnTheWhole) {
  // Internal forces: sum f = 0, sum x x f + sum M t = 0, elastic and viscous, to 1e-12 of their size.
  for (const bool closed : {false, true}) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      RodSection section = soft_section();
      section.damping = 0.3;
      RodSystem rod(crooked_line(closed, seed), section, some_rest(closed ? kPoints : kPoints - 2));
      State s = moved_state(&rod, seed + 20, 0.3, 1.2, false);
      for (const Energy* term : rod.system->dynamics.energies) term->end_step(&s);
      const Nodes f = rod_forces(rod, s);
      EXPECT_GT(f.norm(), 1.0);
      EXPECT_LT(f.leftCols(rod.points).rowwise().sum().norm(), 1e-12 * f.norm());
      EXPECT_LT(moment_of(rod, s, f).norm(), 1e-12 * f.norm() * s.x.norm());
    }
  }
}

TEST(RodTerms, DoNotSeeRigidMotion) {
  // Energy and forces turn with the rod: E(R x, R u) = E(x, u), f(R x) = R f(x).
  RodSystem rod(crooked_line(false, 3), soft_section(), some_rest(kPoints - 2));
  const State s = moved_state(&rod, 31, 0.2, 1.1, false);
  const Mat3 r = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  State turned = s;
  turned.x.leftCols(rod.points) = (r * s.x.leftCols(rod.points)).colwise() + Vec3(3, -1, 2);
  turned.directors = r * s.directors;
  turned.tangents = r * s.tangents;
  turned.v.leftCols(rod.points) = r * s.v.leftCols(rod.points);
  for (const Energy* term : rod.system->dynamics.energies)
    EXPECT_NEAR(term->value(turned), term->value(s), 1e-12 * term->value(s));
  const Nodes f = rod_forces(rod, s), g = rod_forces(rod, turned);
  EXPECT_LT((g.leftCols(rod.points) - r * f.leftCols(rod.points)).norm(), 1e-12 * f.norm());
  EXPECT_LT((g.rightCols(rod.segments) - f.rightCols(rod.segments)).norm(), 1e-12 * f.norm());
}

TEST(RodTerms, DampNoRigidMotion) {
  // v = omega x r, the angles turning at omega . t: the viscous part of the force is zero to round-off.
  RodSystem still(crooked_line(false, 1), soft_section(), some_rest(kPoints - 2));
  State s = moved_state(&still, 41, 0.0, 1.2, false);
  s.v.setZero();
  const Nodes elastic = rod_forces(still, s);
  RodSection section = soft_section();
  section.damping = 0.3;
  RodSystem damped(crooked_line(false, 1), section, some_rest(kPoints - 2));
  const Vec3 omega(0.3, -0.2, 0.5);
  for (int i = 0; i < still.points; ++i) s.v.col(i) = Vec3(1, 2, 3) + omega.cross(Vec3(s.x.col(i)));
  for (int j = 0; j < still.segments; ++j)
    s.v(0, still.points + j) = omega.dot(s.tangents.col(j)) * section.radius_of_gyration;
  EXPECT_LT((rod_forces(damped, s) - elastic).norm(), 1e-14 * elastic.norm());
  // Turning without spinning is a strain rate: the frames are left behind.
  s.v.rightCols(still.segments).setZero();
  EXPECT_GT((rod_forces(damped, s) - elastic).norm(), 1e-3);
}

TEST(RodTerms, BendARoundRodAlikeHoweverItIsTwisted) {
  // B_1 = B_2, straight: the bending energy does not depend on the angles.
  RodSection section = soft_section();
  section.bend_2 = section.bend_1;
  section.twist = 0.0;
  RodSystem rod(crooked_line(false, 2), section);
  rod.carry_frames();
  const Energy& bend = *rod.system->dynamics.energies[1];
  const double before = bend.value(rod.state());
  for (int j = 0; j < rod.segments; ++j) rod.set_angle(j, 1.3 * j * j);
  EXPECT_GT(before, 1e-3);
  EXPECT_NEAR(bend.value(rod.state()), before, 1e-13 * before);
}

TEST(RodTerms, HoldTheirRestShape) {
  // As drawn: no energy and no force, with any natural curvature and twist of an open rod.
  const Polyline line = crooked_line(false, 5);
  RodSystem rod(line, soft_section(), rest_as_drawn(line));
  for (const Energy* term : rod.system->dynamics.energies) EXPECT_LT(term->value(rod.state()), 1e-28);
  EXPECT_LT(rod_forces(rod, rod.state()).norm(), 1e-13);
  // The same with its section turned along the way, by psi_j in segment j: natural twist, and the curvatures seen from
  // frames turned by psi.
  RodRest turned = rest_as_drawn(line);
  turned.twist.resize(kPoints - 2);
  double psi = 0.0;
  for (int k = 0; k < kPoints - 2; ++k) {
    const double twist = 0.7 - 0.5 * k, length = 0.5 * (line.rest.col(k + 2) - line.rest.col(k + 1)).norm() +
                                                 0.5 * (line.rest.col(k + 1) - line.rest.col(k)).norm();
    turned.twist[k] = twist / length;
    turned.curvature.col(k) = (Eigen::Rotation2Dd(-psi - 0.5 * twist) * turned.curvature.col(k)).eval();
    psi += twist;
  }
  RodSystem turned_rod(line, soft_section(), turned);
  EXPECT_NEAR(turned_rod.angle(kPoints - 2), psi, 1e-14);
  EXPECT_LT(rod_forces(turned_rod, turned_rod.state()).norm(), 1e-13);
  // A circle of natural curvature 1/R: the angle between segments of chord l is l_arc / R.
  const double turn = 2.0 * M_PI / 12.0, chord = 2.0 * std::sin(0.5 * turn);
  Polyline arc;
  arc.rest.resize(3, 6);
  for (int i = 0; i < 6; ++i) arc.rest.col(i) = Vec3(std::cos(turn * i), 0.0, std::sin(turn * i));
  RodSystem curved_rod(arc, soft_section(), curved(-turn / chord, 4, Vec3::UnitY()));
  EXPECT_LT(rod_forces(curved_rod, curved_rod.state()).norm(), 1e-12);
}

TEST(RodTerms, RefuseImpossibleSections) {
  const Polyline line = line_along(Vec3::UnitX(), 0.1, 5);
  const auto make = [&](const RodSection& section, const RodRest& rest) { make_rod(line, section, rest, 0, 5, 0); };
  EXPECT_NO_THROW(make(soft_section(), {}));
  for (double RodSection::*field :
       {&RodSection::stretch, &RodSection::radius_of_gyration, &RodSection::linear_density, &RodSection::bend_1,
        &RodSection::bend_2, &RodSection::twist, &RodSection::damping}) {
    for (const double bad : {-1.0, std::nan("")}) {
      RodSection section = soft_section();
      section.*field = bad;
      EXPECT_THROW(make(section, {}), InputError);
    }
  }
  RodRest rest;
  rest.curvature = Eigen::Matrix2Xd::Zero(2, 2);
  EXPECT_THROW(make(soft_section(), rest), InputError);
  rest.curvature = Eigen::Matrix2Xd::Constant(2, 3, 40.0);  // 5.7 rad a joint
  EXPECT_THROW(make(soft_section(), rest), InputError);
}

TEST(RodSection, OfACircleHasTheTextbookValues) {
  // EA = E pi r^2, EI = E pi r^4/4, GJ = G pi r^4/2, G = E / (2 (1 + nu)).
  const RodSection s = circular_section(0.02, 2e9, 0.25, 1200.0);
  const double r = 0.01;
  EXPECT_DOUBLE_EQ(s.stretch, 2e9 * M_PI * r * r);
  EXPECT_NEAR(s.bend_1, 2e9 * M_PI * std::pow(r, 4) / 4.0, 1e-12 * s.bend_1);
  EXPECT_NEAR(s.twist, 2e9 / 2.5 * M_PI * std::pow(r, 4) / 2.0, 1e-12 * s.twist);
  EXPECT_NEAR(s.radius_of_gyration, r / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(s.linear_density, 1200.0 * M_PI * r * r, 1e-12);
}

}  // namespace
}  // namespace deformable_sim::test
