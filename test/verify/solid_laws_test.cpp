// Stress-strain laws of solids against tables: one element pulled, pressed, sheared and turned.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/element/solid_stress.h"
#include "support/solids.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kTableTolerance = 1e-8;  // the tables have ten digits

SolidMaterial material_of(SolidLaw law) {
  SolidMaterial material = solid_material(law, 2.6, 0.3);  // mu = 1
  material.share = 0.5;
  return material;
}

/// The tetrahedron of the origin and the ends of the unit vectors: P_ij = 6 times what holds node i at axis j.
TetMesh unit_tet() {
  TetMesh mesh;
  mesh.rest.resize(3, 4);
  mesh.rest << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  mesh.tets = {{0, 1, 2, 3}};
  return mesh;
}

class OneElement {
 public:
  explicit OneElement(SolidLaw law) : system(unit_tet().rest, solid_masses(unit_tet(), 1.0)) {
    system.add(make_solid(unit_tet(), material_of(law), 0.0, 0));
  }
  void stretch(const Vec3& s) { system.state.x = s.asDiagonal() * unit_tet().rest; }
  double piola(int row, int column) const { return -6.0 * system.forces()(row, column + 1); }
  /// Lets the two given stretches go where nothing pulls.
  Equilibrium free(const std::vector<int>& axes) {
    StaticSettings settings;
    settings.tolerance = 1e-14;
    for (int node = 0; node < 4; ++node) {
      for (int axis = 0; axis < 3; ++axis) {
        const bool is_free = node == axis + 1 && std::find(axes.begin(), axes.end(), axis) != axes.end();
        if (!is_free) settings.rollers.push_back({node, axis});
      }
    }
    return find_equilibrium(&system, settings);
  }
  Vec3 stretches() const { return Vec3(system.state.x(0, 1), system.state.x(1, 2), system.state.x(2, 3)); }

  System system;
};

double deviation(double measured, double expected) {
  return std::abs(measured - expected) / (1.0 + std::abs(expected));
}

TEST(SolidLaws, HaveTheTabulatedStressUnderTensionAndCompression) {
  // P11 and P22 = 0 at the tabulated lateral stretch, 0.3 <= lambda <= 3, one and two directions pulled, nu = 0.3.
  for (const bool both : {false, true}) {
    const std::string test = both ? "equibiaxial" : "uniaxial";
    for (const SolidLaw law : kSolidLaws) {
      double worst = 0.0, worst_free = 0.0;
      OneElement element(law);
      for (const TableRow& row : read_rows("D1_" + test + "_nu03.csv")) {
        const double stretch = row("lambda"), lateral = row(table_name(law) + " lateral stretch");
        if (lateral <= 0.0) continue;  // the element has shrunk to a line: no equilibrium with free sides
        element.stretch(both ? Vec3(stretch, stretch, lateral) : Vec3(stretch, lateral, lateral));
        worst = std::max(worst, deviation(element.piola(0, 0), row(table_name(law) + " P11/mu")));
        worst_free = std::max(worst_free, std::abs(element.piola(2, 2)) / (1.0 + std::abs(element.piola(0, 0))));
      }
      check("D1", test + ", " + name_of(law) + ": largest deviation of P11/mu", worst, 0.0, kTableTolerance,
            Tolerance::kAbsolute);
      check("D1", test + ", " + name_of(law) + ": largest P/mu on a free side", worst_free, 0.0, kTableTolerance,
            Tolerance::kAbsolute);
    }
  }
}

TEST(SolidLaws, FindTheTabulatedLateralStretch) {
  // The same tables as equilibria of one element with free sides, where the laws are stable: 0.6 <= lambda <= 1.5.
  for (const bool both : {false, true}) {
    const std::string test = both ? "equibiaxial" : "uniaxial";
    for (const SolidLaw law : kSolidLaws) {
      double worst = 0.0;
      for (const TableRow& row : read_rows("D1_" + test + "_nu03.csv")) {
        const double stretch = row("lambda");
        if (stretch < 0.6 || stretch > 1.5) continue;
        OneElement element(law);
        element.stretch(both ? Vec3(stretch, stretch, 1.0) : Vec3(stretch, 1.0, 1.0));
        const Equilibrium end = element.free(both ? std::vector<int>{2} : std::vector<int>{1, 2});
        EXPECT_TRUE(end.converged && end.stable) << name_of(law) << " at " << stretch;
        worst = std::max(worst, std::abs(element.stretches()[2] - row(table_name(law) + " lateral stretch")));
        worst = std::max(worst, deviation(element.piola(0, 0), row(table_name(law) + " P11/mu")));
      }
      check("D1", test + ", " + name_of(law) + ": relaxed, largest deviation", worst, 0.0, kTableTolerance,
            Tolerance::kAbsolute);
    }
  }
}

TEST(SolidLaws, HaveTheTabulatedStressWhenConfinedAndUnderPressure) {
  // P11 of diag(lambda, 1, 1) and of lambda I.
  for (const bool pressed : {false, true}) {
    const std::string test = pressed ? "hydrostatic" : "confined";
    for (const SolidLaw law : kSolidLaws) {
      double worst = 0.0;
      OneElement element(law);
      for (const TableRow& row : read_rows("D1_" + test + "_nu03.csv")) {
        const double stretch = row("lambda");
        element.stretch(pressed ? Vec3(stretch, stretch, stretch) : Vec3(stretch, 1.0, 1.0));
        worst = std::max(worst, deviation(element.piola(0, 0), row(table_name(law) + " P11/mu")));
      }
      check("D1", test + ", " + name_of(law) + ": largest deviation of P11/mu", worst, 0.0, kTableTolerance,
            Tolerance::kAbsolute);
    }
  }
}

TEST(SolidLaws, HaveTheTabulatedStressInSimpleShear) {
  // x1 = X1 + gamma X2: P12 by the element's forces, Cauchy stress P F^T / J.
  for (const SolidLaw law : kSolidLaws) {
    double worst = 0.0;
    OneElement element(law);
    for (const TableRow& row : read_rows("D2_simple_shear_nu03.csv")) {
      Mat3 f = Mat3::Identity();
      f(0, 1) = row("gamma");
      element.system.state.x = f * unit_tet().rest;
      worst = std::max(worst, deviation(element.piola(0, 1), row(table_name(law) + " P12/mu")));
      if (law == SolidLaw::kHooke) continue;  // its one stress is P; the table divides by deformed areas
      const Mat3 sigma = cauchy_stress(material_of(law), f);
      worst = std::max(worst, deviation(sigma(0, 1), row(table_name(law) + " sigma12/mu")));
      worst = std::max(worst, deviation(sigma(0, 0), row(table_name(law) + " sigma11/mu")));
      worst = std::max(worst, deviation(sigma(1, 1), row(table_name(law) + " sigma22/mu")));
      // The universal relation of all isotropic laws.
      EXPECT_NEAR(sigma(0, 0) - sigma(1, 1), f(0, 1) * sigma(0, 1), 1e-13 * (1.0 + sigma.norm())) << name_of(law);
    }
    check("D2", "simple shear, " + name_of(law) + ": largest deviation", worst, 0.0, kTableTolerance,
          Tolerance::kAbsolute);
  }
}

TEST(SolidLaws, AreIncompressibleLawsOnceThePressureIsTakenOut) {
  // s_i g_i - s_j g_j does not see the pressure: at J = 1, NH P = mu (l - 1/l^2), MR 2 (C10 + C01/l) (l - 1/l^2), and
  // so on.
  struct Column {
    std::string name;
    SolidLaw law;
    double share;
    int mode;  // 0 uniaxial, 1 equibiaxial, 2 pure shear
  };
  const std::vector<Column> columns = {{"NH uniaxial P/mu", SolidLaw::kNeoHookean, 0.0, 0},
                                       {"MR(C01/C10=1/3) uniaxial", SolidLaw::kMooneyRivlin, 0.75, 0},
                                       {"MR(C01=C10) uniaxial", SolidLaw::kMooneyRivlin, 0.5, 0},
                                       {"NH equibiaxial P/mu", SolidLaw::kNeoHookean, 0.0, 1},
                                       {"MR(1/3) equibiaxial", SolidLaw::kMooneyRivlin, 0.75, 1},
                                       {"NH pure shear P11/mu", SolidLaw::kNeoHookean, 0.0, 2}};
  for (const Column& column : columns) {
    double worst = 0.0;
    for (const TableRow& row : read_rows("D5_incompressible_nominal_stress.csv")) {
      const double l = row("lambda");
      SolidMaterial material = material_of(column.law);
      material.share = column.share;
      const Vec3 s = column.mode == 0   ? Vec3(l, 1.0 / std::sqrt(l), 1.0 / std::sqrt(l))
                     : column.mode == 1 ? Vec3(l, l, 1.0 / (l * l))
                                        : Vec3(l, 1.0, 1.0 / l);
      Vec3 g;
      energy_density(material, s, &g, nullptr);
      worst = std::max(worst, deviation((s[0] * g[0] - s[2] * g[2]) / s[0], row(column.name)));
    }
    check("D5", column.name + ": largest deviation", worst, 0.0, kTableTolerance, Tolerance::kAbsolute);
  }
}

TEST(SolidLaws, HaveTheTabulatedEnergyWhenCollapsedAndInverted) {
  // psi and P33 of diag(1, 1, 0), diag(1, 0, 0), 0, diag(1, 1, -1), diag(1, 1, -1/2). The table's stable neo-Hookean
  // energy keeps its value at rest, l/2 (1 - a)^2 - m/2 ln 4; ours is zero there.
  const std::vector<Vec3> states = {{1, 1, 0}, {1, 0, 0}, {0, 0, 0}, {1, 1, -1}, {1, 1, -0.5}};
  const double m = 4.0 / 3.0, l = 1.5 + 5.0 / 6.0, at_rest = 0.5 * l * std::pow(0.75 * m / l, 2) - m * std::log(2.0);
  for (const SolidLaw law : kSolidLaws) {
    size_t next = 0;
    double worst = 0.0;
    for (const TableRow& row : read_rows("D6_degenerate_states.csv")) {
      if (row.text("model") != table_name(law)) continue;
      const Mat3 f = states[next++].asDiagonal();
      const double energy = energy_density(material_of(law), f);
      const double stress = first_piola(material_of(law), f)(2, 2);
      if (row.text("Psi/mu (nu=.3)") == "nan") {
        EXPECT_EQ(energy, std::numeric_limits<double>::infinity()) << name_of(law);
        continue;
      }
      const double offset = law == SolidLaw::kStableNeoHookean ? at_rest : 0.0;
      worst = std::max(worst, deviation(energy + offset, row("Psi/mu (nu=.3)")));
      worst =
          std::max(worst, deviation(stress, row("P33/mu (positive = pushes further inside-out? sign of dPsi/dF33)")));
    }
    EXPECT_EQ(next, states.size()) << name_of(law);
    check("D6", name_of(law) + ": largest deviation of psi/mu, P33/mu", worst, 0.0, kTableTolerance,
          Tolerance::kAbsolute);
  }
}

TEST(StVenantKirchhoff, SoftensUnderCompressionAndRestsInsideOut) {
  // Confined: P = (lambda + 2 mu) s (s^2 - 1) / 2 is least, -(lambda + 2 mu) / (3 sqrt 3), at s = 1 / sqrt 3.
  const SolidMaterial material = material_of(SolidLaw::kStVenantKirchhoff);
  const double limit = 1.0 / std::sqrt(3.0), modulus = material.lambda + 2.0 * material.mu;
  const auto confined = [&](double s) { return first_piola(material, Vec3(s, 1.0, 1.0).asDiagonal())(0, 0); };
  check("D2", "St Venant-Kirchhoff, confined: least P/(lambda + 2 mu)", confined(limit) / modulus,
        -1.0 / (3.0 * std::sqrt(3.0)), 1e-12);
  EXPECT_GT(confined(limit - 1e-3), confined(limit));
  EXPECT_GT(confined(limit + 1e-3), confined(limit));
  check("D2", "St Venant-Kirchhoff: largest |P|/mu at diag(1, 1, -1)",
        first_piola(material, Vec3(1.0, 1.0, -1.0).asDiagonal()).cwiseAbs().maxCoeff(), 0.0, 1e-15,
        Tolerance::kAbsolute);
}

/// Lateral stretch at which free sides of a bar stretched by s carry no stress: the root above which P22 is positive.
double free_lateral(const SolidMaterial& material, double s) {
  double low = 0.5, high = 1.6;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (first_piola(material, Vec3(s, middle, middle).asDiagonal())(1, 1) > 0.0 ? high : low) = middle;
  }
  return low;
}

TEST(StableNeoHookeanAndMooneyRivlin, GiveWayUnderStrongCompression) {
  // Uniaxial, nu = 0.3: W_t(s, t) = 0 gives the free sides, dP/ds = W_ss - W_st^2 / W_tt = 0 the greatest pressure.
  // Both solved from the energies in 40 digits. Mooney-Rivlin gives way because its volume energy is finite at J = 0.
  struct Limit {
    SolidLaw law;
    double stretch, lateral, stress;  // of mu
  };
  for (const Limit& limit : {Limit{SolidLaw::kStableNeoHookean, 0.377468623749762, 1.01389635120891, -2.14993496680512},
                             Limit{SolidLaw::kMooneyRivlin, 0.469807928484091, 0.95878062028161, -3.39465126255636}}) {
    const SolidMaterial material = material_of(limit.law);
    const auto stress = [&](double s) {
      const double t = free_lateral(material, s);
      return first_piola(material, Vec3(s, t, t).asDiagonal())(0, 0);
    };
    const std::string what = name_of(limit.law) + ", uniaxial: ";
    check("D2", what + "lateral stretch at the limit point", free_lateral(material, limit.stretch), limit.lateral,
          1e-12);
    check("D2", what + "greatest pressure, P11/mu", stress(limit.stretch), limit.stress, 1e-12);
    // A minimum: level to second order, higher on both sides.
    const double step = 1e-5;
    const double before = stress(limit.stretch - step), after = stress(limit.stretch + step);
    check("D2", what + "slope of P11/mu at the limit point", (after - before) / (2.0 * step), 0.0, 1e-5,
          Tolerance::kAbsolute);
    EXPECT_GT(before, stress(limit.stretch)) << what;
    EXPECT_GT(after, stress(limit.stretch)) << what;
  }
}

TEST(RigidRotation, IsStrainToHookesLinearLawAlone) {
  // e = (cos t - 1) diag(1, 1, 0): P11 = 2 (mu + lambda) (cos t - 1), psi = 2 (mu + lambda) (cos t - 1)^2; others:
  // none.
  for (const SolidLaw law : kSolidLaws) {
    const SolidMaterial material = material_of(law);
    double worst = 0.0;
    for (const TableRow& row : read_rows("D3_rigid_rotation_linear_hooke.csv")) {
      const Mat3 r = Eigen::AngleAxisd(row("theta_deg") * M_PI / 180.0, Vec3::UnitZ()).toRotationMatrix();
      const Mat3 p = first_piola(material, r);
      if (law == SolidLaw::kHooke) {
        worst = std::max(worst, deviation(p(0, 0), row("spurious stress s11/mu (nu=.3)")));
        worst = std::max(worst, deviation(energy_density(material, r), row("spurious energy density/mu")));
      } else {
        worst = std::max(worst, p.cwiseAbs().maxCoeff());
      }
    }
    check("D3", name_of(law) + ": rotation, largest deviation of P/mu", worst, 0.0,
          law == SolidLaw::kHooke ? kTableTolerance : 1e-14, Tolerance::kAbsolute);
  }
}

TEST(RigidRotation, MakesALinearBodySwellByOneOverTheCosine) {
  // Stress-free under Hooke's linear law: F = I + W, W antisymmetric, which is a rotation by t with stretches 1 / cos t
  // in its plane. Three nodes held so that the body is turned by t and no more; all other laws keep the rotated shape.
  const TetMesh mesh = make_irregular_box(Vec3(0.4, 0.2, 0.2), {4, 2, 2}, 7);
  // A corner of the box and the ends of two of its edges, along x and along y.
  const int origin = 0, end = 4, side = 10;
  for (const double degrees : {10.0, 30.0, 45.0, 60.0}) {
    const double angle = degrees * M_PI / 180.0;
    const Mat3 r = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    for (const SolidLaw law : kSolidLaws) {
      const double scale = law == SolidLaw::kHooke ? 1.0 / std::cos(angle) : 1.0;
      const Vec3 in_plane(scale, scale, 1.0);
      Nodes x = r * (mesh.rest.colwise() - mesh.rest.col(origin));
      x(1, end) = scale * x(1, end);  // the one coordinate that fixes the angle
      System body(x, solid_masses(mesh, 1.0));
      body.add(make_solid(mesh, material_of(law), 0.0, 0)).hold(origin);
      StaticSettings settings;
      settings.tolerance = 1e-14;
      settings.rollers = {{end, 1}, {end, 2}, {side, 2}};
      const Equilibrium equilibrium = find_equilibrium(&body, settings);
      EXPECT_TRUE(equilibrium.converged) << name_of(law) << " " << equilibrium.residual;
      const Nodes expected = r * in_plane.asDiagonal() * (mesh.rest.colwise() - mesh.rest.col(origin));
      check("D3",
            name_of(law) + ", turned by " + std::to_string(static_cast<int>(degrees)) + " degrees: scale in the plane",
            (body.state.x.col(end) - body.state.x.col(origin)).norm() / 0.4, scale, 1e-10);
      EXPECT_LT((body.state.x - expected).cwiseAbs().maxCoeff(), 1e-10) << name_of(law) << " " << degrees;
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
