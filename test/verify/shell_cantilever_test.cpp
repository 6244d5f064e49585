// Strips of cloth clamped at one end: under their weight, under a tip load, upright, on edge.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kLength = 0.1, kRigidity = 1e-5;  // m, N m: of cloth

/// H / W of the heavy elastica, from its table: cubic through four neighbours in log Gamma.
double heavy_elastica(double gamma) {
  std::vector<double> x, y;
  for (const TableRow& row : read_rows("A1_cantilever_heavy_elastica.csv")) {
    x.push_back(std::log(row("Gamma")));
    y.push_back(std::log(row("H_over_W")));
  }
  size_t above = 2;
  while (above + 2 < x.size() && x[above] < std::log(gamma)) ++above;
  double sum = 0.0;
  for (size_t i = above - 2; i < above + 2; ++i) {
    double weight = y[i];
    for (size_t k = above - 2; k < above + 2; ++k) {
      if (k != i) weight *= (std::log(gamma) - x[k]) / (x[i] - x[k]);
    }
    sum += weight;
  }
  return std::exp(sum);
}

struct StripMesh {
  int degrees = 0;  // of the lattice against the strip
  Diagonals diagonals = Diagonals::kUniform;
  int cells = 50;  // over the length
  std::string name() const {
    return std::to_string(degrees) + " degrees, " + (diagonals == Diagonals::kUniform ? "uniform" : "alternating") +
           " diagonals, " + std::to_string(cells) + " cells";
  }
};

/// A strip along x, a tenth as wide as long, the clamp at x = 0 half way along its first column of cells, free to
/// x = length.
TriangleMesh strip_mesh(const StripMesh& strip, double length = kLength, double width_ratio = 0.1) {
  const double h = length / (strip.cells - 0.5);
  const int across = std::max(1, static_cast<int>(std::lround(width_ratio * strip.cells)));
  TriangleMesh mesh = strip.degrees == 0
                          ? grid(strip.diagonals, strip.cells * h, across * h, strip.cells, across)
                          : cut_strip(strip.cells * h, across * h, h, strip.degrees * M_PI / 180.0, strip.diagonals);
  const double start = mesh.rest.row(0).minCoeff() + 0.5 * h;
  mesh.rest.row(0).array() -= start;
  return mesh;
}

enum class Element { kHinges, kQuadratic, kDifferences };

/// A strip in equilibrium; loads are made by the caller from `force`, the unit of weight (N).
class Strip {
 public:
  /// Stretch stiffness is that many times `load` (N/m, force over width).
  Strip(const TriangleMesh& rest, const BendingMaterial& bending, double stretch, double nu, Element element)
      : mesh(rest), system(rest.rest, triangle_masses(rest, 1.0)) {
    system.add(make_membrane(mesh, isotropic_sheet(SolidLaw::kStVenantKirchhoff, stretch, nu), 0));
    if (element == Element::kDifferences) {
      mesh.cols = static_cast<int>((mesh.rest.row(1).array() == mesh.rest(1, 0)).count());
      mesh.rows = static_cast<int>(mesh.rest.cols()) / mesh.cols;
      system.add(make_quadratic_links("bending", grid_bending_weights(mesh, bending), 0.0, 0));
    } else {
      system.add(element == Element::kHinges ? make_bending(mesh, bending, 0)
                                             : make_quadratic_bending(mesh, bending, 0));
    }
    const double h = -2.0 * mesh.rest.row(0).minCoeff();
    for (int i = 0; i < mesh.rest.cols(); ++i) {
      if (mesh.rest(0, i) < 0.5 * h + 1e-9) system.hold(i);
      if (mesh.rest(0, i) > mesh.rest.row(0).maxCoeff() - 1e-9) tip.push_back(i);
    }
  }
  void solve(double force) {
    StaticSettings settings;
    settings.tolerance = 1e-7 * force;
    settings.largest_move = 0.2 * kLength;
    settings.iterations = 400;
    equilibrium = find_equilibrium(&system, settings);
    EXPECT_TRUE(equilibrium.converged);
  }
  Vec3 mean_tip() const {
    Vec3 sum = Vec3::Zero();
    for (const int i : tip) sum += system.state.x.col(i);
    return sum / static_cast<double>(tip.size());
  }
  double width() const { return mesh.rest.row(1).maxCoeff() - mesh.rest.row(1).minCoeff(); }

  TriangleMesh mesh;
  System system;
  std::vector<int> tip;
  Equilibrium equilibrium;
};

/// H / W of a strip under its weight. The cloth stretches by less than 1 / 200 under it.
double drop_over_reach(const StripMesh& strip, double gamma, const BendingMaterial& bending, Element element,
                       double along = kRigidity) {
  const double weight = gamma * along / std::pow(kLength, 3);  // N/m^2
  Strip cloth(strip_mesh(strip), bending, 200.0 * weight * kLength, bending.poissons_ratio, element);
  cloth.system.add(make_gravity(cloth.system.mass, Vec3(0, 0, -weight)));
  cloth.solve(weight * kLength * cloth.width());
  EXPECT_TRUE(cloth.equilibrium.stable);
  return -cloth.mean_tip().z() / cloth.system.state.x.row(0).maxCoeff();
}

TEST(ClothCantilever, FollowsTheMasterCurveOnAnyMesh) {
  // theta'' = -Gamma (1 - s) cos theta; 2 % at 50 elements for Gamma = rho g L^3 / B from 0.1 to 850. The spread over
  // the meshes, their bias, is below 2 % too.
  const std::vector<double> gammas = verify_all()
                                         ? std::vector<double>{0.1, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 400, 850}
                                         : std::vector<double>{0.1, 10, 100, 850};
  for (const double gamma : gammas) {
    const double expected = heavy_elastica(gamma);
    double low = 1e9, high = 0.0;
    for (const int degrees : {0, 30, 45, 90}) {
      for (const Diagonals diagonals : {Diagonals::kUniform, Diagonals::kAlternating}) {
        const StripMesh strip{degrees, diagonals, 50};
        const double measured = drop_over_reach(strip, gamma, isotropic_bending(kRigidity, 0.0), Element::kHinges);
        check("A1", "cloth, H/W at Gamma " + std::to_string(gamma) + ", " + strip.name(), measured, expected, 0.02);
        low = std::min(low, measured);
        high = std::max(high, measured);
      }
    }
    check("A1", "cloth, spread of H/W over meshes at Gamma " + std::to_string(gamma), high / low - 1.0, 0.0, 0.02,
          Tolerance::kAbsolute);
  }
}

TEST(ClothCantilever, ConvergesToTheMasterCurve) {
  // Second order: (4 f(2n) - f(n)) / 3 within 1 %.
  for (const double gamma :
       verify_all() ? std::vector<double>{0.1, 1, 10, 100, 400, 850} : std::vector<double>{1, 100}) {
    for (const int degrees : {0, 45}) {
      const int coarse = gamma > 200 ? 50 : 25;
      const BendingMaterial material = isotropic_bending(kRigidity, 0.0);
      const double f1 = drop_over_reach({degrees, Diagonals::kAlternating, coarse}, gamma, material, Element::kHinges);
      const double f2 =
          drop_over_reach({degrees, Diagonals::kAlternating, 2 * coarse}, gamma, material, Element::kHinges);
      check("A1",
            "cloth, Richardson limit of H/W at Gamma " + std::to_string(gamma) + ", " + std::to_string(degrees) +
                " degrees",
            (4.0 * f2 - f1) / 3.0, heavy_elastica(gamma), 0.01);
    }
  }
}

TEST(ClothCantilever, FollowsTheMasterCurveWithQuadraticBending) {
  // 2 sin(angle / 2) in place of the angle is softer by angle^2 / 8: at Gamma = 850 the clamp bends by 0.8 rad a cell
  // of L / 50, where it costs 2.1 %, and 100 cells are taken.
  for (const double gamma : {0.1, 10.0, 100.0, 850.0}) {
    for (const int degrees : {0, 45}) {
      if (gamma > 500.0 && degrees > 0 && !verify_all()) continue;
      const StripMesh strip{degrees, Diagonals::kAlternating, gamma > 500.0 ? 100 : 50};
      check("A1", "cloth, quadratic bending, H/W at Gamma " + std::to_string(gamma) + ", " + strip.name(),
            drop_over_reach(strip, gamma, isotropic_bending(kRigidity, 0.0), Element::kQuadratic),
            heavy_elastica(gamma), 0.02);
    }
  }
}

TEST(ClothCantilever, FollowsTheMasterCurveWithBendingByDifferences) {
  // 2 sin(angle / 2) for the angle as above. B is that of a narrow strip: free edges leave no moment across, at any nu,
  // as long as the strip is narrow beside the length that bends, L / sqrt(Gamma): the clamp keeps its width flat.
  for (const double gamma : {0.1, 10.0, 100.0, 850.0}) {
    for (const double nu : {0.0, 0.3}) {
      if (nu > 0.0 && gamma > 50.0) continue;
      const StripMesh strip{0, Diagonals::kAlternating, gamma > 500.0 ? 100 : 50};
      check("A1",
            "cloth, bending by differences, H/W at Gamma " + std::to_string(gamma) + ", nu " + std::to_string(nu) +
                ", " + strip.name(),
            drop_over_reach(strip, gamma, isotropic_bending(kRigidity, nu), Element::kDifferences),
            heavy_elastica(gamma), 0.02);
    }
  }
}

TEST(ClothCantilever, KnowsOnlyTheStiffnessAlongTheStrip) {
  // Warp ten times the weft: a strip along each of them.
  for (const bool along_warp : {true, false}) {
    BendingMaterial material;
    material.warp = 1e-5;
    material.weft = 1e-6;
    if (!along_warp) material.warp_direction = Vec3::UnitY();
    check("A1", std::string("cloth, strip along the ") + (along_warp ? "warp" : "weft") + ", H/W at Gamma 30",
          drop_over_reach({}, 30.0, material, Element::kHinges, along_warp ? 1e-5 : 1e-6), heavy_elastica(30.0), 0.02);
  }
}

TEST(ClothCantilever, HasPeircesBendingLength) {
  // The chord reaches 41.5 degrees where Gamma = 8.0042: B = rho g l^3 / 8.0042, by secants on the overhang's load.
  for (const int degrees : {0, 45}) {
    double gamma = 8.0, before = 7.0, chord_before = 0.0;
    const auto chord = [&](double g) {
      return std::atan(
          drop_over_reach({degrees, Diagonals::kUniform, 50}, g, isotropic_bending(kRigidity, 0.0), Element::kHinges));
    };
    chord_before = chord(before);
    for (int k = 0; k < 3; ++k) {
      const double at = chord(gamma),
                   next = gamma + (41.5 * M_PI / 180.0 - at) * (gamma - before) / (at - chord_before);
      before = gamma;
      chord_before = at;
      gamma = next;
    }
    check("A2", "cloth, B recovered / B, " + std::to_string(degrees) + " degrees", gamma / 8.004197, 1.0, 0.02);
  }
}

TEST(ClothStrip, BendsUnderATipLoadAsTheElastica) {
  // alpha = P L^2 / B: drop and shortening of the tip over L [Bisshopp 1945].
  const double table[][3] = {{0.5, 0.1621435757, 0.01591896247},
                             {1, 0.3017207738, 0.05643323628},
                             {2, 0.4934574804, 0.1606417208},
                             {4, 0.6699641813, 0.3289412422},
                             {10, 0.8106090249, 0.5549955978}};
  for (const auto& [alpha, drop, shortening] : table) {
    for (const int degrees : {0, 45}) {
      const double pull = alpha * kRigidity / (kLength * kLength);  // N/m
      Strip strip(strip_mesh({degrees, Diagonals::kAlternating, 50}), isotropic_bending(kRigidity, 0.0), 4e3 * pull,
                  0.0, Element::kHinges);
      Eigen::VectorXd load = Eigen::VectorXd::Constant(strip.mesh.rest.cols(), 0.0);
      // Corners carry half of what their neighbours do.
      const double each = pull * strip.width() / static_cast<double>(strip.tip.size() - 1);
      for (const int i : strip.tip) {
        load[i] = std::abs(strip.mesh.rest(1, i)) > 0.5 * strip.width() - 1e-9 ? 0.5 * each : each;
      }
      strip.system.add(make_gravity(load, Vec3(0, 0, -1)));
      strip.solve(pull * strip.width());
      const std::string what = ", alpha " + std::to_string(alpha) + ", " + std::to_string(degrees) + " degrees";
      check("A5", "cloth strip, tip drop" + what, -strip.mean_tip().z() / kLength, drop, 0.01);
      check("A5", "cloth strip, tip shortening" + what, 1.0 - strip.mean_tip().x() / kLength, shortening, 0.01);
    }
  }
}

/// Whether a strip that is straight in its equilibrium is stable there, under `gravity` (N/m^2).
bool stays_straight(const StripMesh& strip, double width_ratio, const BendingMaterial& bending, double stretch,
                    const Vec3& gravity) {
  Strip cloth(strip_mesh(strip, kLength, width_ratio), bending, stretch, bending.poissons_ratio, Element::kHinges);
  cloth.system.add(make_gravity(cloth.system.mass, gravity));
  cloth.solve(gravity.norm() * kLength * cloth.width());
  return cloth.equilibrium.stable;
}

TEST(ClothStrip, StandsUprightBelowGreenhillsLoadAndFallsAboveIt) {
  // rho g L^3 / B = 7.8373: the straight state is a minimum below it and none above.
  const double unit = kRigidity / std::pow(kLength, 3);
  for (const auto& [gamma, stands] : {std::pair<double, bool>{7.4, true}, {8.3, false}}) {
    const bool stood = stays_straight({0, Diagonals::kAlternating, 50}, 0.1, isotropic_bending(kRigidity, 0.0),
                                      2e4 * unit * kLength, Vec3(-gamma * unit, 0, 0));
    check("A5", "cloth strip upright at Gamma " + std::to_string(gamma) + ", stands", stood, stands, 0.0,
          Tolerance::kAbsolute);
  }
}

/// Weight Gamma = rho g w L^3 / (B w) at which a ribbon on edge turns sideways, by bisection on stability, over that of
/// an infinitely narrow one, 12.8538 sqrt(2 / (1 + nu)).
double buckling_weight(double width_ratio, double nu, int cells) {
  const double unit = kRigidity / std::pow(kLength, 3), thickness = 0.02 * width_ratio * kLength;
  const double ideal = 12.85376332 * std::sqrt(2.0 / (1.0 + nu));
  double low = 0.8 * ideal, high = 1.3 * ideal;
  while (high - low > 2e-3 * ideal) {
    const double gamma = 0.5 * (low + high);
    const bool stable =
        stays_straight({0, Diagonals::kAlternating, cells}, width_ratio, isotropic_bending(kRigidity, nu),
                       12.0 * kRigidity / (thickness * thickness), Vec3(0, -gamma * unit, 0));
    (stable ? low : high) = gamma;
  }
  return 0.5 * (low + high) / ideal;
}

TEST(ClothRibbon, BucklesSidewaysAtTheCriticalWeight) {
  // q L^3 / sqrt(B C) = 6 j_{-1/6,1} = 12.8538, C / B = 2 / (1 + nu); 8 % for the finite width, whose clamp shortens
  // the ribbon by about half of it; 3 % in the limit of no width.
  for (const double nu : {0.0, 0.3}) {
    const std::string what =
        "cloth ribbon on edge, critical weight over that of a narrow one, nu " + std::to_string(nu);
    check("A4", what + ", w / L = 0.06", buckling_weight(0.06, nu, 50), 1.0, 0.08);
    if (!verify_all()) continue;
    check("A4", what + ", limit of no width", 2.0 * buckling_weight(0.05, nu, 100) - buckling_weight(0.1, nu, 100), 1.0,
          0.03);
  }
}

}  // namespace
}  // namespace deformable_sim::test
