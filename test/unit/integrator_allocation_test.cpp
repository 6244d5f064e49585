// A warm step takes no memory from the heap.
#include <gtest/gtest.h>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/energy/solid_terms.h"
#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/strain_limit.h"
#include "support/count_allocations.h"
#include "support/crooked_sheet.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

class WarmStep : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Registry, WarmStep, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(WarmStep, AllocatesNothing) {
  const TriangleMesh mesh = make_grid(0.3, 0.3, 5, 5);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  stiffness.damping_time = 1e-3;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add_springs(sheet_network(mesh, stiffness)).add_gravity();
  body.add(make_sheet_drag(mesh.triangles, {})).add(make_mass_damping(body.mass, 0.1)).hold(0);
  const auto integrator = make_integrator(GetParam(), {});
  body.dynamics.contacts.assign(36, {});
  for (int i = 0; i < 36; ++i) {
    body.dynamics.contacts[static_cast<size_t>(i)].node[0] = i;
    body.dynamics.contacts[static_cast<size_t>(i)].friction = 0.4;
    body.dynamics.contacts[static_cast<size_t>(i)].offset = -1e-5;
  }
  for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-3);
  allocations = 0;
  counting = true;
  for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-3);
  counting = false;
  EXPECT_EQ(allocations, 0);
}

TEST_P(WarmStep, OfAVolumeAllocatesNothing) {
  if (takes_known_terms_only(GetParam())) GTEST_SKIP() << "refuses solids";
  for (const bool quadratic : {false, true}) {
    TetMesh mesh = make_box(Vec3(0.3, 0.2, 0.2), {3, 2, 2});
    if (quadratic) mesh = with_mid_nodes(mesh);
    System body(mesh.rest, solid_masses(mesh, 1000.0));
    body.add(make_solid(mesh, solid_material(SolidLaw::kStableNeoHookean, 1e4, 0.4), 1e-3, 0)).add_gravity().hold(0);
    const auto integrator = make_integrator(GetParam(), {});
    for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-4);
    allocations = 0;
    counting = true;
    for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-4);
    counting = false;
    EXPECT_EQ(allocations, 0) << quadratic;
  }
}

TEST(WarmStep, OfASheetSolvedInLinesAllocatesNothing) {
  // Bending, flexion, damping, held nodes, several sweeps, and contacts that come and go.
  const TriangleMesh mesh = make_grid(0.6, 0.5, 14, 11);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  stiffness.bend = 1.0;
  stiffness.damping_time = 1e-3;
  const SpringNetwork network = sheet_network(mesh, stiffness);
  const std::vector<QuadraticWeight> weights = grid_bending_weights(mesh, isotropic_bending(1e-4, 0.3));
  for (const char* name : {"line_dual", "xpbd", "projective_dynamics"}) {
    System body(mesh.rest, sheet_masses(mesh, 0.2));
    body.add_springs(network).add(make_quadratic_links("bending", weights, 1e-3, 0));
    std::vector<GridSheet> grids{*make_grid_sheet(mesh, network, weights, 1e-3, 0)};
    grids[0].replaces = body.dynamics.energies;
    body.dynamics.grids = &grids;
    body.add_gravity().add(make_mass_damping(body.mass, 0.1)).hold(0);
    SolverSettings settings;
    settings.newton_iterations = 2;
    const auto integrator = make_integrator(name, settings);
    ContactConstraints contacts(36);
    for (int i = 0; i < 36; ++i) {
      contacts[static_cast<size_t>(i)].node[0] = i;
      contacts[static_cast<size_t>(i)].offset = -1e-5;
    }
    body.dynamics.contacts.reserve(36);
    const auto step = [&](int k) {
      body.dynamics.contacts.assign(contacts.begin(), contacts.end() - (k % 3) * 10);
      if (k % 3 == 2) body.dynamics.contacts.clear();
      body.step(*integrator, 1e-3);
    };
    for (int k = 0; k < 9; ++k) step(k);
    allocations = 0;
    counting = true;
    for (int k = 0; k < 9; ++k) step(k);
    counting = false;
    EXPECT_EQ(allocations, 0) << name;
    EXPECT_TRUE(body.state.finite()) << name;
  }
}

TEST(WarmStep, OfARopeInOneWalkAllocatesNothing) {
  // Also where the step, and with it the matrix, is another one than before.
  const Polyline line = make_line(1.0, 24);
  LineStiffness stiffness;
  stiffness.axial = 1e4;
  stiffness.bend = 10.0;
  stiffness.damping_time = 1e-3;
  SolverSettings settings;
  settings.linear = SolverSettings::Linear::kBanded;
  settings.jacobian = Jacobian::kLagged;
  settings.newton_iterations = 20;
  for (const char* name : {"implicit_euler", "bdf2", "tr_bdf2"}) {
    System body(line.rest, line_masses(line, 0.05));
    body.add_springs(line_network(line, stiffness)).add(make_line_bending(line, 1e-4, 1e-3, 0));
    body.add_gravity().add(make_mass_damping(body.mass, 0.1)).hold(0);
    const auto integrator = make_integrator(name, settings);
    for (int k = 0; k < 5; ++k) body.step(*integrator, 2e-3);
    allocations = 0;
    counting = true;
    for (int k = 0; k < 3; ++k) body.step(*integrator, 2e-3);
    for (int k = 0; k < 3; ++k) body.step(*integrator, 1e-3);
    counting = false;
    EXPECT_EQ(allocations, 0) << name;
  }
}

TEST(WarmStep, OfASheetByMultigridAllocatesNothing) {
  // With contacts, which set the coarse operators up anew, and with fewer of them in every other step.
  const TriangleMesh mesh = make_grid(0.6, 0.5, 14, 11);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  stiffness.damping_time = 1e-3;
  const SpringNetwork network = sheet_network(mesh, stiffness);
  for (const char* name : {"implicit_euler", "bdf2", "tr_bdf2"}) {
    System body(mesh.rest, sheet_masses(mesh, 0.2));
    body.add_springs(network);
    std::vector<GridSheet> grids{*make_grid_sheet(mesh, network, {}, 0.0, 0)};
    grids[0].replaces = body.dynamics.energies;
    body.dynamics.grids = &grids;
    body.add_gravity().add(make_mass_damping(body.mass, 0.1)).hold(0);
    SolverSettings settings;
    settings.linear = SolverSettings::Linear::kMultigrid;
    const auto integrator = make_integrator(name, settings);
    ContactConstraints contacts(36);
    for (int i = 0; i < 36; ++i) {
      contacts[static_cast<size_t>(i)].node[0] = i;
      contacts[static_cast<size_t>(i)].friction = 0.4;
      contacts[static_cast<size_t>(i)].offset = -1e-5;
    }
    body.dynamics.contacts.reserve(36);
    const auto step = [&](int k) {
      body.dynamics.contacts.assign(contacts.begin(), contacts.end() - (k % 2) * 10);
      return body.step(*integrator, 1e-3);
    };
    for (int k = 0; k < 6; ++k) step(k);
    allocations = 0;
    counting = true;
    int iterations = 0;
    for (int k = 0; k < 6; ++k) iterations += step(k).linear_iterations;
    counting = false;
    EXPECT_EQ(allocations, 0) << name;
    EXPECT_GT(iterations, 0) << name;
  }
}

TEST(WarmStep, OfAMeshByMultigridAllocatesNothing) {
  // With contacts, which set the coarse operators up anew, in every other step, and steps of two lengths.
  const TriangleMesh mesh = crooked_sheet(12);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  for (const char* name : {"implicit_euler", "bdf2", "tr_bdf2"}) {
    System body(mesh.rest, sheet_masses(mesh, 0.2));
    body.add_springs(sheet_network(mesh, stiffness));
    body.add(make_quadratic_links("b", quadratic_bending_weights(mesh, isotropic_bending(1e-5, 0.3)), 0.01, 0));
    body.add_gravity().hold(0);
    SolverSettings settings;
    settings.linear = SolverSettings::Linear::kMultigrid;
    const auto integrator = make_integrator(name, settings);
    ContactConstraints contacts(36);
    for (int i = 0; i < 36; ++i) {
      contacts[static_cast<size_t>(i)].node[0] = i;
      contacts[static_cast<size_t>(i)].offset = -1e-5;
    }
    body.dynamics.contacts.reserve(36);
    const auto step = [&](int k) {
      body.dynamics.contacts.assign(contacts.begin(), contacts.end() - (k % 2) * 36);
      return body.step(*integrator, k % 3 == 0 ? 5e-4 : 1e-3);
    };
    for (int k = 0; k < 6; ++k) step(k);
    allocations = 0;
    counting = true;
    int iterations = 0;
    for (int k = 0; k < 6; ++k) iterations += step(k).linear_iterations;
    counting = false;
    EXPECT_EQ(allocations, 0) << name;
    EXPECT_GT(iterations, 0) << name;
  }
}

TEST(WarmStep, AllocatesNothingForSheetsAsContinua) {
  const TriangleMesh mesh = make_grid(0.3, 0.3, 5, 5);
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  SheetMaterial stretch = isotropic_sheet(SolidLaw::kStableNeoHookean, 100.0, 0.3);
  BendingMaterial bend = isotropic_bending(1e-4, 0.3);
  stretch.damping = bend.damping = 1e-3;
  body.add(make_membrane(mesh, stretch, 0)).add(make_bending(mesh, bend, 0)).add(make_quadratic_bending(mesh, bend, 0));
  body.add_gravity().hold(0);
  const auto integrator = make_integrator("implicit_euler", {});
  for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-3);
  allocations = 0;
  counting = true;
  for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-3);
  for (const Energy* term : body.dynamics.energies) {
    term->add_jacobian(body.state, 1.0, 1.0, Jacobian::kExact, &body.pattern);
  }
  counting = false;
  EXPECT_EQ(allocations, 0);
}

TEST(WarmStep, AllocatesNothingForRopesSolvedDirectly) {
  // A chain with bending, a closed one, and a sheet that is left to conjugate gradients; alone and beside each other.
  for (const bool sheet : {false, true}) {
    const Polyline line = make_line(1.0, 12), ring = make_ring(1.0, 9);
    LineStiffness along;
    along.axial = 1e3;
    SheetStiffness stiffness;
    stiffness.membrane = 100.0;
    const TriangleMesh mesh = make_grid(0.3, 0.3, 11, 11);
    const Eigen::Index points = line.rest.cols() + ring.rest.cols(), all = points + (sheet ? mesh.rest.cols() : 0);
    Nodes x(3, all);
    x.leftCols(points) << line.rest, ring.rest;
    if (sheet) x.rightCols(mesh.rest.cols()) = mesh.rest;
    System body(x, Eigen::VectorXd::Constant(all, 1e-3));
    const int first_of_ring = static_cast<int>(line.rest.cols());
    body.add(make_springs("line", line_network(line, along).stretch, 0));
    body.add(make_line_bending(line, 1e-5, 1e-3, 0)).add(make_line_bending(ring, 1e-5, 0.0, first_of_ring));
    body.add(make_springs("ring", line_network(ring, along).stretch, first_of_ring));
    if (sheet) body.add(make_springs("sheet", sheet_network(mesh, stiffness).stretch, static_cast<int>(points)));
    body.add_gravity().hold(0);
    SolverSettings settings;
    settings.linear = SolverSettings::Linear::kBanded;
    settings.jacobian = Jacobian::kLagged;
    settings.newton_iterations = 20;
    const auto integrator = make_integrator("bdf2", settings);
    for (int k = 0; k < 10; ++k) body.step(*integrator, 1e-3);
    allocations = 0;
    counting = true;
    for (int k = 0; k < 10; ++k) body.step(*integrator, 1e-3);
    counting = false;
    EXPECT_EQ(allocations, 0) << sheet;
    EXPECT_TRUE(body.state.finite());
  }
}

TEST_P(WarmStep, AllocatesNothingWithAMassMatrixAndAMovingHolder) {
  const TriangleMesh mesh = make_grid(0.3, 0.3, 4, 4);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add_springs(sheet_network(mesh, stiffness)).add_gravity().hold(0);
  Eigen::SparseMatrix<double> mass(body.mass.size(), body.mass.size());
  for (int i = 0; i < body.mass.size(); ++i) mass.insert(i, i) = body.mass[i];
  mass.coeffRef(1, 2) = mass.coeffRef(2, 1) = 0.1 * body.mass[1];
  body.dynamics.mass_matrix = &mass;
  const auto integrator = make_integrator(GetParam(), {});
  const auto step = [&] {
    body.dynamics.kinematics.target(2, 0) += 1e-4;
    body.step(*integrator, 1e-3);
  };
  for (int k = 0; k < 5; ++k) step();
  allocations = 0;
  counting = true;
  for (int k = 0; k < 5; ++k) step();
  counting = false;
  EXPECT_EQ(allocations, 0);
}

TEST(WarmStep, HasAHookThatSeesAllocations) {
  allocations = 0;
  counting = true;
  {
    const Eigen::VectorXd vector = Eigen::VectorXd::Zero(100);
    EXPECT_EQ(vector.size(), 100);
  }
  counting = false;
  EXPECT_GT(allocations, 0);
}

TEST(WarmStep, WithStrainLimitsAllocatesNothing) {
  // A sheet that hangs from two corners, taut enough that every step is projected.
  const TriangleMesh mesh = make_grid(0.3, 0.3, 5, 5);
  SheetStiffness stiffness;
  stiffness.membrane = 5.0;
  const SpringNetwork network = sheet_network(mesh, stiffness);
  Model model;
  model.mass = sheet_masses(mesh, 0.2);
  model.strain_limits = strain_limits(network.stretch, 1e-3, 0);
  StrainLimiter limiter(model);
  System body(mesh.rest, model.mass);
  body.add_springs(network).add_gravity().hold(0).hold(5);
  const auto integrator = make_integrator("symplectic_euler", {});
  int iterations = 0;
  const auto step = [&] {
    limiter.begin(2e-3, body.dynamics.kinematics, &body.state);
    body.step(*integrator, 2e-3);
    iterations += limiter.project(2e-3, &body.dynamics, &body.state).iterations;
  };
  for (int k = 0; k < 30; ++k) step();
  iterations = 0;
  allocations = 0;
  counting = true;
  for (int k = 0; k < 5; ++k) step();
  counting = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_GE(iterations, 10);
}

}  // namespace
}  // namespace deformable_sim::test
