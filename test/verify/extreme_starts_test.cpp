// F1-F5: a cube in motion from nodes at random, collapsed, inside out, stretched and pressed, with every law.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/rigid_copy.h"
#include "support/small_worlds.h"
#include "support/solids.h"
#include "support/statics.h"
#include "support/verification.h"
#include "support/watched_run.h"

namespace deformable_sim::test {
namespace {

// mu = 2e5 Pa; with nu = 5/12 lambda = 1e6 Pa, else 3e5 Pa. Uniform drag, which leaves the momentum of a body at rest
// at zero, brings what comes back to rest; the material has no damping of its own, for that grows with the fourth power
// of the stretch and holds a tenfold one for minutes.
constexpr double kSofter = 0.3, kStiffer = 5.0 / 12.0;

constexpr int kCells = 3;

std::unique_ptr<World> cube(SolidLaw law, double ratio) {
  const std::string n = std::to_string(kCells);
  return build_world(load_scene_text(
      "gravity: [0, 0, 0]\nair: {damping: 6}\nstep: {dt: 0.01, integrator: implicit_euler, linear_solver: direct}\n"
      "bodies:\n  - soft: {name: cube, box: {size: [1, 1, 1], cells: [" +
          n + ", " + n + ", " + n + "]}, element: tetrahedron, law: " + name_of(law) +
          ", material: {damping: 0, density: 1000, youngs_modulus: " + std::to_string(4e5 * (1.0 + ratio)) +
          ", poissons_ratio: " + std::to_string(ratio) + "}}\n",
      "test"));
}

void start_from(World* world, const Nodes& x) {
  command::SetBodyState start;
  start.body = "cube";
  start.x = x;
  start.v = Nodes::Zero(3, x.cols());
  ASSERT_TRUE(world->apply(start).status.ok());
}

const TetMesh& mesh_of(const World& world) {
  return *world.model().bodies[0].volume;
}

int inverted(const World& world) {
  const std::vector<Mat3> f = deformation_gradients(mesh_of(world), world.state().x);
  return static_cast<int>(std::count_if(f.begin(), f.end(), [](const Mat3& m) { return m.determinant() <= 0.0; }));
}

struct Start {
  std::string name;
  Nodes x;
};

/// F1-F5. `noise` is the largest distance of a node from the plane, line or point, about.
std::vector<Start> starts(const Nodes& rest, double noise) {
  const Nodes random = random_nodes(rest.cols(), 41);
  const auto scaled = [&rest](double x, double y, double z) { return Nodes(Vec3(x, y, z).asDiagonal() * rest); };
  const double thinner = std::sqrt(0.1);
  return {{"F1, at random", random_nodes(rest.cols(), 1)},
          {"F2, on a plane", scaled(1, 1, 0) + noise * random},
          {"F2, on a line", scaled(1, 0, 0) + noise * random},
          {"F2, on a point", noise * random},
          {"F3, inside out", scaled(1, 1, -1)},
          {"F4, ten times as long", scaled(10, 1, 1)},
          {"F4, ten times as long, of the same volume", scaled(10, thinner, thinner)},
          {"F5, a twentieth as long", scaled(0.05, 1, 1)}};
}

std::string row_of(const Start& start) {
  return start.name.substr(0, 2);
}
std::string case_of(SolidLaw law, const Start& start) {
  return name_of(law) + start.name.substr(2);
}

/// Runs to rest and checks what holds in all cases.
void run(World* world, SolidLaw law, const Start& start) {
  start_from(world, start.x);
  const Watched found = watch(world, 3.0);
  check_watched(row_of(start), case_of(law, start), found, 6.0);
}

double off_rest(const World& world) {
  return distance_from_rigid_copy(world.state().x, mesh_of(world).rest);
}

void check_return(SolidLaw law, const Start& start) {
  const auto world = cube(law, kSofter);
  run(world.get(), law, start);
  check(row_of(start), case_of(law, start) + ": largest distance from a rigid copy of the rest shape, m",
        off_rest(*world), 0.0, 1e-4, Tolerance::kAbsolute);
}

/// Is a state of the free cube, to the digits that are left of it, a minimum of the energy: no force, and of the
/// eigenvalues of the exact Hessian six zero, for rigid motion, and all others positive?
bool is_minimum(const World& world, SolidLaw law, double ratio) {
  const TetMesh& mesh = mesh_of(world);
  System body(world.state().x, world.model().mass);
  body.add(make_solid(mesh, solid_material(law, 4e5 * (1.0 + ratio), ratio), 0.0, 0));
  StaticSettings settings;
  settings.tolerance = 1e-3;  // N, of 4e5 N/m^2 x 1 m^2
  settings.largest_move = 0.02;
  if (!find_equilibrium(&body, settings).converged) return false;
  if ((body.state.x - world.state().x).cwiseAbs().maxCoeff() > 0.05) return false;  // it was still on its way
  body.pattern.set_zero();
  for (const Energy* term : body.dynamics.energies)
    term->add_jacobian(body.state, 1.0, 0.0, Jacobian::kExact, &body.pattern);
  const Eigen::VectorXd stiffness =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(body.pattern.to_sparse()), Eigen::EigenvaluesOnly)
          .eigenvalues();
  const double zero = 1e-8 * stiffness.cwiseAbs().maxCoeff();
  return stiffness[0] > -zero && (stiffness.array() < zero).count() == 6;
}

TEST(ExtremeStart, CorotationalAndStableNeoHookeanComeBack) {
  // To a rigid copy of the rest shape within 1e-4 m; F5: 99 % of the length back. At a point the force of the stable
  // neo-Hookean law is of second order in the distance from it: it starts from 1e-2 m there, and see below.
  for (const SolidLaw law : {SolidLaw::kCorotational, SolidLaw::kStableNeoHookean}) {
    for (Start& start : starts(make_box(Vec3(1, 1, 1), {kCells, kCells, kCells}).rest, 1e-8)) {
      if (row_of(start) == "F1") continue;
      if (law == SolidLaw::kStableNeoHookean && start.name == "F2, on a point") start.x *= 1e6;
      check_return(law, start);
    }
  }
}

TEST(ExtremeStart, LawsOfRubberComeBackFromAnyStretch) {
  // neo_hookean and mooney_rivlin are defined wherever no element is inside out: F4 and F5.
  for (const SolidLaw law : {SolidLaw::kNeoHookean, SolidLaw::kMooneyRivlin}) {
    for (const Start& start : starts(make_box(Vec3(1, 1, 1), {kCells, kCells, kCells}).rest, 1e-8)) {
      if (row_of(start) != "F4" && row_of(start) != "F5") continue;
      check_return(law, start);
    }
  }
}

TEST(ExtremeStart, LawsOfRubberAreRefusedInsideOut) {
  // F1-F3: their energy is infinite where J <= 0. No step is made, the state stays as it was to the last bit, the
  // warning names the reason and the laws that can, and a reset recovers.
  for (const SolidLaw law : {SolidLaw::kNeoHookean, SolidLaw::kMooneyRivlin}) {
    for (const Start& start : starts(make_box(Vec3(1, 1, 1), {kCells, kCells, kCells}).rest, 1e-8)) {
      if (row_of(start) == "F4" || row_of(start) == "F5") continue;
      SCOPED_TRACE(case_of(law, start));
      const auto world = cube(law, kSofter);
      start_from(world.get(), start.x);
      const State before = world->state();
      const StepOutcome outcome = world->step();
      EXPECT_FALSE(outcome.ok);
      EXPECT_FALSE(outcome.report.converged);
      EXPECT_TRUE(same_state(before, world->state()));
      bool named = false;
      for (const std::string& warning : world->snapshot().warnings)
        named = named || warning.find("its material law has no energy; stable_neo_hookean") != std::string::npos;
      EXPECT_TRUE(named);
      ASSERT_TRUE(world->apply(command::Reset{}).status.ok());
      EXPECT_TRUE(world->step().ok);
    }
  }
}

TEST(ExtremeStart, StVenantKirchhoffStaysInsideOut) {
  // F3: C = I in an element turned inside out, so it has no stress: nothing moves at all. From tangles, planes, lines,
  // points and pressed flat some elements end inside out, at rest; from a tenfold stretch it may come back, or not.
  for (const Start& start : starts(make_box(Vec3(1, 1, 1), {kCells, kCells, kCells}).rest, 1e-8)) {
    const SolidLaw law = SolidLaw::kStVenantKirchhoff;
    const auto world = cube(law, kSofter);
    run(world.get(), law, start);
    if (row_of(start) == "F3") {
      check("F3", case_of(law, start) + ": largest motion, m", (world->state().x - start.x).cwiseAbs().maxCoeff(), 0.0,
            1e-15, Tolerance::kAbsolute);
    }
    EXPECT_LT(world->state().v.cwiseAbs().maxCoeff(), 1e-3) << start.name;
    if (row_of(start) == "F4") continue;
    EXPECT_GT(inverted(*world), 0) << start.name;
    EXPECT_GT(off_rest(*world), 0.1) << start.name;
  }
}

/// Where Hooke's law takes a body that starts at rest from x: to its rest shape X moved and turned by a linearised
/// rotation, X + w x X. No force of the law turns X, sum X x f = 0, so that sum m X x (x - X) does not change:
/// w = (sum m (|X|^2 I - X X^T))^-1 sum m X x x.
Nodes hooke_end(const Nodes& rest, const Eigen::VectorXd& mass, const Nodes& x) {
  const Vec3 center = x * mass / mass.sum(), rest_center = rest * mass / mass.sum();
  Mat3 inertia = Mat3::Zero();
  Vec3 moment = Vec3::Zero();
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const Vec3 p = rest.col(i) - rest_center;
    inertia += mass[i] * (p.squaredNorm() * Mat3::Identity() - p * p.transpose());
    moment += mass[i] * p.cross(Vec3(x.col(i)));
  }
  const Vec3 turn = inertia.inverse() * moment;
  Nodes end(3, rest.cols());
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const Vec3 p = rest.col(i) - rest_center;
    end.col(i) = center + p + turn.cross(p);
  }
  return end;
}

TEST(ExtremeStart, HookeSwellsByTheTurnItTakes) {
  // It comes back from anywhere, for its energy is quadratic, but to no rigid copy: to the place that the moment of the
  // start foretells, larger than at rest by the square of the turn.
  for (const Start& start : starts(make_box(Vec3(1, 1, 1), {kCells, kCells, kCells}).rest, 1e-8)) {
    const SolidLaw law = SolidLaw::kHooke;
    const auto world = cube(law, kSofter);
    run(world.get(), law, start);
    const Nodes end = hooke_end(mesh_of(*world).rest, world->model().mass, start.x);
    check(row_of(start), case_of(law, start) + ": distance from rest + w x rest, w by the moment of the start, m",
          (world->state().x - end).colwise().norm().maxCoeff(), 0.0, 1e-6, Tolerance::kAbsolute);
    if (row_of(start) == "F1") EXPECT_GT(off_rest(*world), 1e-2);
  }
}

TEST(ExtremeStart, StableNeoHookeanStaysAtAPoint) {
  // F2: at F = 0 the stress is zero and so is its derivative. Of nodes within d = 1e-8 m of each other the force is of
  // second order in d: sqrt(rho / (lambda d / L)) ~ 500 s until it has grown, 0.5 (3 s)^2 of 1e-13 m/s^2 in 3 s.
  const auto world = cube(SolidLaw::kStableNeoHookean, kSofter);
  const Nodes start = 1e-8 * random_nodes(mesh_of(*world).rest.cols(), 41);
  start_from(world.get(), start);
  const Watched found = watch(world.get(), 3.0);
  EXPECT_EQ(found.unsolved, 0);
  check("F2", "stable_neo_hookean, within 1e-8 m of a point: largest motion in 3 s, m",
        (world->state().x - start).cwiseAbs().maxCoeff(), 0.0, 1e-11, Tolerance::kAbsolute);
}

/// Random tangles of one law: the share that comes back. Every other one has to end in an equilibrium of the law
/// itself.
double share_back(SolidLaw law, double ratio, const std::string& what) {
  constexpr unsigned kTangles = 10;
  int back = 0;
  for (unsigned seed = 0; seed < kTangles; ++seed) {
    const auto world = cube(law, ratio);
    start_from(world.get(), random_nodes(mesh_of(*world).rest.cols(), seed));
    const Watched found = watch(world.get(), 3.0);
    check_watched("F1", what + ", tangle " + std::to_string(seed), found, 2.0);
    if (off_rest(*world) < 1e-4) {
      ++back;
    } else {
      EXPECT_TRUE(is_minimum(*world, law, ratio)) << what << ", tangle " << seed;
    }
  }
  return static_cast<double>(back) / kTangles;
}

TEST(ExtremeStart, TanglesComeBackOrEndInAnEquilibriumOfTheLaw) {
  // F1. A tangle that does not come back has reached a minimum of its energy: not the steps but the law holds it, some
  // elements wound around an edge of the cube once too often, none or few inside out. The stiffer the volume, the more:
  // with lambda = 5 mu no tangle comes back by stable_neo_hookean, which lets no element through flat.
  for (const double ratio : {kSofter, kStiffer}) {
    if (ratio == kStiffer && !verify_all()) continue;
    for (const SolidLaw law : {SolidLaw::kCorotational, SolidLaw::kStableNeoHookean}) {
      const std::string what = name_of(law) + (ratio == kSofter ? ", nu = 0.3" : ", nu = 5 / 12");
      const double share = share_back(law, ratio, what);
      if (ratio == kStiffer && law == SolidLaw::kStableNeoHookean) {
        check("F1", what + ": share of tangles that come back", share, 0.0, 0.2, Tolerance::kAbsolute);
      } else {
        check("F1", what + ": share of tangles that come back", share, 1.0, ratio == kSofter ? 0.3 : 0.5);
      }
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
