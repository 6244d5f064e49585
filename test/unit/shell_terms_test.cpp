// Sheets as continua: refusals, rest angles, free fall, what is reported.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "deformable_sim/core/element/hinge.h"
#include "deformable_sim/core/element/principal_stretches.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/plate_patches.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"

namespace deformable_sim::test {
namespace {

template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool names(const std::string& message, const std::string& word) {
  return message.find(word) != std::string::npos;
}

TEST(SheetMaterial, IsRefusedWhereItIsNone) {
  const TriangleMesh mesh = make_grid(1, 1, 2, 2);
  const auto made = [&](const std::function<void(SheetMaterial*)>& spoil, SolidLaw law) {
    SheetMaterial material = isotropic_sheet(law, 100.0, 0.3);
    spoil(&material);
    return refusal([&] { make_membrane(mesh, material, 0); });
  };
  const SolidLaw any = SolidLaw::kStVenantKirchhoff, isotropic = SolidLaw::kNeoHookean;
  EXPECT_EQ(made([](SheetMaterial*) {}, any), "");
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->warp = 0.0; }, any), "warp"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->weft = NAN; }, any), "weft"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->shear = -1.0; }, any), "shear"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->poissons_ratio = 1.0; }, any), "Poisson"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->damping = -1.0; }, any), "damping"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->weft = 50.0; }, isotropic), "isotropic"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->shear = 50.0; }, isotropic), "isotropic"));
  EXPECT_TRUE(names(made([](SheetMaterial* m) { m->warp_direction = Vec3::Zero(); }, any), "warp direction"));
  const auto up = [](SheetMaterial* m) { m->warp_direction = Vec3::UnitZ(); };
  EXPECT_EQ(made(up, any), "");  // isotropic: no matter
  EXPECT_TRUE(names(made([&](SheetMaterial* m) { up(m), m->weft = 50.0; }, any), "normal to face 0"));
  EXPECT_TRUE(names(refusal([] { isotropic_sheet(SolidLaw::kNeoHookean, 100.0, 0.6); }), "Poisson"));
}

TEST(BendingMaterial, IsRefusedWhereItIsNone) {
  const TriangleMesh mesh = make_grid(1, 1, 2, 2);
  const auto made = [&](const std::function<void(BendingMaterial*)>& spoil) {
    BendingMaterial material = isotropic_bending(1.0, 0.3);
    spoil(&material);
    return refusal([&] { make_bending(mesh, material, 0); });
  };
  EXPECT_EQ(made([](BendingMaterial*) {}), "");
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->warp = 0.0; }), "warp"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->weft = -1.0; }), "weft"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->twist = 0.0; }), "twist"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->poissons_ratio = -1.0; }), "Poisson"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->damping = NAN; }), "damping"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->creases = {{0, 1, 0.5}}; }), "0 and 1"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->creases = {{0, 4, 4.0}}; }), "crease"));
  EXPECT_TRUE(names(made([](BendingMaterial* m) { m->warp_direction = Vec3(NAN, 0, 0); }), "warp direction"));
  const auto up = [](BendingMaterial* m) { m->warp_direction = Vec3::UnitZ(); };
  EXPECT_EQ(made(up), "");
  EXPECT_TRUE(names(made([&](BendingMaterial* m) { up(m), m->weft = 0.5; }), "normal to face 0"));
  BendingMaterial folded = isotropic_bending(1.0, 0.3);
  folded.rest = BendingMaterial::Rest::kAsMeshed;
  EXPECT_TRUE(names(refusal([&] { make_quadratic_bending(mesh, folded, 0); }), "flat"));
}

TEST(Hinge, MeasuresTheFoldOverTheFullRange) {
  // Face b a d turned about the edge by t from flat: angle = t, positive towards the outer side, to pi.
  for (const double t : {-3.1, -1.5, -1e-9, 0.0, 0.7, 2.2, 3.14}) {
    Hinge::Points x;
    x << 0, 0, -0.8, 0.5 * std::cos(t), 0, 1, 0.4, 0.3, 0, 0, 0, 0.5 * std::sin(t);
    EXPECT_NEAR(Hinge(x).angle(), t, 1e-14);
  }
}

TEST(Hinge, GivesNothingWhereATriangleVanishes) {
  Hinge::Points x = Hinge::Points::Zero();
  EXPECT_EQ(Hinge(x).angle(), 0.0);
  EXPECT_TRUE(Hinge(x).gradient().isZero());
  x.col(1) = Vec3::UnitY();
  x.col(2) = Vec3(0, 0.5, 0);
  x.col(3) = Vec3(0.5, 0.5, 0);
  EXPECT_EQ(Hinge(x).angle(), 0.0);
  EXPECT_TRUE(Hinge(x).gradient().allFinite());
  EXPECT_TRUE(Hinge(x).hessian().allFinite());
}

TEST(PrincipalStretches, KeepTheAccuracyOfSmallOnes) {
  // F = U diag(s) V^T, down to a sheet flattened to a line.
  const Mat3 u = Eigen::AngleAxisd(0.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::Matrix2d v = Eigen::Rotation2Dd(0.7).toRotationMatrix();
  for (const double small : {1.0, 0.3, 1e-6, 1e-12, 0.0}) {
    const Matrix32 f = u.leftCols<2>() * Eigen::Vector2d(1.0, small).asDiagonal() * v.transpose();
    const PrincipalStretches at = principal_stretches(f);
    EXPECT_NEAR(at.stretch[0], 1.0, 1e-14);
    EXPECT_NEAR(at.stretch[1], small, 1e-15 + 1e-3 * small * (small < 1e-3 ? 1.0 : 1e-11));
    EXPECT_LT((at.u * at.stretch.asDiagonal() * at.v.transpose() - f).norm(), 1e-14);
    EXPECT_LT((at.u.transpose() * at.u - Eigen::Matrix2d::Identity()).norm(), 1e-14);
  }
}

/// A flat strip along x with a crease of `angle` across its middle, held by its first two columns.
System* creased_strip(const TriangleMesh& mesh, double angle) {
  BendingMaterial material = isotropic_bending(1e-3, 0.0);
  for (int r = 0; r + 1 < mesh.rows; ++r) {
    material.creases.push_back({r * mesh.cols + 5, (r + 1) * mesh.cols + 5, angle});
  }
  auto* system = new System(mesh.rest, triangle_masses(mesh, 0.1));
  system->add(make_membrane(mesh, isotropic_sheet(SolidLaw::kStVenantKirchhoff, 1e3, 0.0), 0));
  system->add(make_bending(mesh, material, 0));
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    if (i % mesh.cols < 2) system->hold(i);
  }
  return system;
}

TEST(Crease, FoldsTheSheetByItsAngle) {
  // Every hinge can have its rest angle at once: no energy, the far wing turned by the angle towards the outer side.
  const TriangleMesh mesh = uniform_grid(1.0, 0.2, 10, 2);
  for (const double angle : {1.2, -2.0}) {
    const std::unique_ptr<System> strip(creased_strip(mesh, angle));
    StaticSettings settings;
    settings.tolerance = 1e-10;
    settings.largest_move = 0.1;
    ASSERT_TRUE(find_equilibrium(strip.get(), settings).converged);
    EXPECT_LT(strip->potential_energy(), 1e-12);
    const Vec3 wing = strip->state.x.col(10) - strip->state.x.col(5);
    EXPECT_NEAR(std::atan2(wing.z(), wing.x()), angle, 1e-6);
  }
}

TEST(RestAngles, AsMeshedKeepACurvedSheetInShape) {
  // A quarter of a cylinder: no energy as meshed; flat at rest it has the energy B / 2 (pi / 2)^2 / (pi / 2 R) per
  // width.
  const double radius = 0.3, rigidity = 2e-3;
  const int cells = 40;
  TriangleMesh mesh = uniform_grid(0.5 * M_PI * radius, 0.4, cells, 20);
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    const double t = mesh.rest(0, i) / radius;
    mesh.rest.col(i) = Vec3(radius * std::sin(t), mesh.rest(1, i), -radius * std::cos(t));
  }
  BendingMaterial material = isotropic_bending(rigidity, 0.0);
  State s;
  s.x = mesh.rest;
  s.v = Nodes::Zero(3, mesh.rest.cols());
  material.rest = BendingMaterial::Rest::kAsMeshed;
  EXPECT_LT(make_bending(mesh, material, 0)->value(s), 1e-20);
  material.rest = BendingMaterial::Rest::kFlat;
  // The free edges' half cells at both ends bear no moment: 1 / cells less.
  EXPECT_NEAR(make_bending(mesh, material, 0)->value(s) / (0.25 * M_PI * rigidity * 0.4 / radius), 1.0, 1.1 / cells);
}

TEST(WarpDirection, FollowsACurvedSheet) {
  // Rolled up about y, the projection of x onto each face is still the yarn direction that was x when flat.
  TriangleMesh flat = uniform_grid(0.4, 0.4, 8, 8), rolled = flat;
  for (Eigen::Index i = 0; i < flat.rest.cols(); ++i) {
    const double t = flat.rest(0, i) / 0.3;
    rolled.rest.col(i) = Vec3(0.3 * std::sin(t), flat.rest(1, i), -0.3 * std::cos(t));
  }
  SheetMaterial woven;
  woven.warp = 300.0;
  woven.weft = 100.0;
  woven.shear = 20.0;
  State s;
  s.v = Nodes::Zero(3, flat.rest.cols());
  s.x = Vec3(1.0, 1.05, 1.0).asDiagonal() * flat.rest;
  const double along_weft = make_membrane(flat, woven, 0)->value(s);
  s.x = Vec3(1.0, 1.05, 1.0).asDiagonal() * rolled.rest;
  EXPECT_NEAR(make_membrane(rolled, woven, 0)->value(s) / along_weft, 1.0, 0.01);
}

TEST(FreeFall, KnowsNoInternalForce) {
  // Backward Euler from rest: z = z0 - g t (t + dt) / 2 for every node, dampers and all.
  const TriangleMesh mesh = make_grid(0.5, 0.4, 6, 5);
  SheetMaterial stretch = isotropic_sheet(SolidLaw::kStableNeoHookean, 200.0, 0.3);
  stretch.damping = 0.01;
  BendingMaterial bend = isotropic_bending(1e-4, 0.3);
  bend.damping = 0.05;
  System cloth(mesh.rest, triangle_masses(mesh, 0.2));
  cloth.add(make_membrane(mesh, stretch, 0)).add(make_bending(mesh, bend, 0)).add_gravity();
  const auto integrator = make_integrator("implicit_euler", exact_settings());
  const double dt = 0.01;
  const int steps = 50;
  for (int k = 0; k < steps; ++k) cloth.step(*integrator, dt);
  const double t = dt * steps;
  Nodes expected = mesh.rest;
  expected.row(2).array() -= 0.5 * kGravity * t * (t + dt);
  EXPECT_LT((cloth.state.x - expected).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(PrincipalStrains, AreThoseOfTheFacesAroundEachNode) {
  const TriangleMesh mesh = irregular_mesh(1.0, 1.0, 4, 4, 0.2);
  const Mat3 turn = Eigen::AngleAxisd(1.0, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  const Eigen::Matrix2Xf strain = principal_strains(mesh, turn * Vec3(0.9, 1.2, 1.0).asDiagonal() * mesh.rest);
  EXPECT_NEAR(strain.row(0).minCoeff(), 0.2, 1e-6);
  EXPECT_NEAR(strain.row(0).maxCoeff(), 0.2, 1e-6);
  EXPECT_NEAR(strain.row(1).minCoeff(), -0.1, 1e-6);
  EXPECT_NEAR(strain.row(1).maxCoeff(), -0.1, 1e-6);
}

TEST(SmallMeshes, HaveABendingTermOfTheirHinges) {
  // One triangle: no hinge, no force. Two: one hinge, positive energy when folded.
  TriangleMesh mesh;
  mesh.rest = (Nodes(3, 4) << 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0).finished();
  mesh.triangles = {{0, 1, 2}};
  State s;
  s.x = mesh.rest;
  s.v = Nodes::Zero(3, 4);
  const auto none = make_bending(mesh, isotropic_bending(1.0, 0.3), 0);
  EXPECT_EQ(none->element_count(), 0);
  EXPECT_EQ(none->value(s), 0.0);
  mesh.triangles.push_back({1, 3, 2});
  s.x(2, 3) = 0.5;
  EXPECT_GT(make_bending(mesh, isotropic_bending(1.0, 0.3), 0)->value(s), 0.01);
}

}  // namespace
}  // namespace deformable_sim::test
