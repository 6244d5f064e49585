// Gauge pressure in closed membranes against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/collider_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kRadius = 0.1, kMembrane = 200.0, kNu = 0.3;  // m, N/m

TEST(Pressure, BlowsAMembraneUpAsLaplaceSays) {
  // A sphere stretched by s in all directions: St Venant-Kirchhoff has the tension N = Eh / (1 - nu) (s^2 - 1) / 2 per
  // stretched width, Laplace's law says p = 2 N / (s R), so s - 1 / s = p R (1 - nu) / Eh. Taken from the volume,
  // V / V0 = s^3. Of chords in place of arcs the error is of second order: 26 x 40 cells have 0.6 % of the stretch.
  double error_before = 0.0;
  for (const int rings : {13, 26}) {
    const TriangleMesh mesh = round_mesh(kRadius, rings, rings * 20 / 13);
    for (const double pressure : {20.0, 600.0}) {
      System system(mesh.rest, triangle_masses(mesh, 0.1));
      system.add(make_membrane(mesh, isotropic_sheet(SolidLaw::kStVenantKirchhoff, kMembrane, kNu), 0));
      system.add(make_pressure(mesh.triangles, pressure, 0.0, 0));
      system.hold(0);
      StaticSettings settings;
      settings.tolerance = 1e-9;
      settings.rollers = {{1, 0}, {1, 1}, {2, 1}};  // the other pole stays on the axis, a node of a ring in its plane
      const Equilibrium found = StaticSolver(&system, settings).solve();
      ASSERT_TRUE(found.converged && found.stable) << found.residual;
      TriangleMesh blown = mesh;
      blown.rest = system.state.x;
      const double stretch = std::cbrt(enclosed_volume(blown) / enclosed_volume(mesh));
      const double c = pressure * kRadius * (1.0 - kNu) / kMembrane;
      const double expected = 0.5 * (c + std::sqrt(c * c + 4.0)) - 1.0;
      if (rings == 26) {
        check("P1", "stretch - 1 of a sphere of 100 mm at " + std::to_string(pressure) + " Pa", stretch - 1.0, expected,
              0.01);
      }
      const double error = std::abs(stretch - 1.0 - expected) / expected;
      if (pressure == 20.0 && rings == 26) {
        EXPECT_NEAR(error_before / error, 4.0, 0.8);
      }
      if (pressure == 20.0) error_before = error;
    }
  }
}

TEST(Pressure, PushesAClosedSurfaceNowhere) {
  // Forces and moments of a closed surface cancel, and are the same wherever the origin is.
  const TriangleMesh mesh = channel_mesh();
  for (const Vec3& origin : {Vec3(0, 0, 0), Vec3(30, -20, 50)}) {
    System system(mesh.rest.colwise() + origin, triangle_masses(mesh, 0.1));
    system.add(make_pressure(mesh.triangles, 1000.0, 0.0, 0));
    const Nodes f = system.forces();
    Vec3 moment = Vec3::Zero();
    for (int i = 0; i < f.cols(); ++i) moment += Vec3(mesh.rest.col(i)).cross(Vec3(f.col(i)));
    EXPECT_NEAR(f.rowwise().sum().norm(), 0.0, 1e-8);
    EXPECT_NEAR(moment.norm(), 0.0, 1e-8);
    EXPECT_GT(f.colwise().norm().maxCoeff(), 0.1);
    EXPECT_NEAR(system.potential_energy(), -1000.0 * enclosed_volume(mesh), 1e-8);
  }
}

}  // namespace
}  // namespace deformable_sim::test
