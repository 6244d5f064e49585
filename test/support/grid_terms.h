// Crumpled sheets on grids: as terms, and as the rows that kernels see.
#pragma once

#include <cstdlib>
#include <memory>
#include <random>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/grid/sheet_rows.h"
#include "deformable_sim/core/integrator/sheet_motion.h"

namespace deformable_sim::test {

struct GridFeatures {
  int cells_x = 0, cells_y = 0;
  bool shear = true, damped = false, flexion = false, bending = false;
};

/// A crumpled sheet as terms and as a grid.
class GridTerms {
 public:
  explicit GridTerms(const GridFeatures& features) {
    const TriangleMesh mesh = make_grid(0.7, 0.5, features.cells_x, features.cells_y);
    SheetStiffness stiffness;
    stiffness.stretch = 300.0;
    stiffness.shear = features.shear ? 80.0 : 0.0;
    stiffness.bend = features.flexion ? 7.0 : 0.0;
    stiffness.damping_time = features.damped ? 0.01 : 0.0;
    const SpringNetwork network = sheet_network(mesh, stiffness);
    for (const auto* links : {&network.stretch, &network.shear, &network.bend}) {
      if (!links->empty()) terms.push_back(make_springs("springs", *links, kFirst));
    }
    std::vector<QuadraticWeight> weights;
    if (features.bending) {
      weights = grid_bending_weights(mesh, isotropic_bending(0.02, 0.3));
      terms.push_back(make_quadratic_links("bending", weights, kBendingDamping, kFirst));
    }
    grid = make_grid_sheet(mesh, network, weights, kBendingDamping, kFirst);
    const Eigen::Index n = mesh.rest.cols() + kFirst + 1;
    state.x = state.v = Nodes::Zero(3, n);
    state.x.middleCols(kFirst, mesh.rest.cols()) = mesh.rest;
    std::mt19937 random(7);
    std::normal_distribution<double> some(0.0, 0.01);
    for (Eigen::Index i = 0; i < state.x.size(); ++i) {
      state.x.data()[i] += some(random);
      state.v.data()[i] += 100.0 * some(random);
    }
  }

  /// M / tau^2 - df/dx - (1 / tau) df/dv, projected, of masses `mass` (kg, all nodes).
  BlockMatrix matrix(double tau, double mass) {
    std::vector<std::array<int, 2>> pairs;
    for (const auto& term : terms) term->add_pattern(&pairs);
    BlockMatrix a(static_cast<int>(state.x.cols()), pairs);
    for (const auto& term : terms) {
      term->bind(a);
      term->add_jacobian(state, 1.0, 1.0 / tau, Jacobian::kProjected, &a);
    }
    for (int i = 0; i < a.rows(); ++i) a.block(a.diagonal_slot(i)).diagonal().array() += mass / (tau * tau);
    return a;
  }

  Nodes force_of_terms() const {
    Nodes f = Nodes::Zero(3, state.x.cols());
    for (const auto& term : terms) term->add_force(state, &f);
    return f;
  }

  Nodes force_of_kernels(SimdLevel level) const {
    SheetRows<double> rows(*grid);
    auto x = rows.make_xyz(), v = rows.make_xyz(), y = rows.make_xyz(), force = rows.make_xyz();
    rows.load(state.x, x.data());
    rows.load(state.v, v.data());
    rows.load(state.x + kBendingDamping * state.v, y.data());
    sheet_kernels(level).forces(rows.shape(), x.data(), v.data(), y.data(), force.data(), rows.scratch());
    Nodes f = Nodes::Zero(3, state.x.cols());
    rows.add(force.data(), &f);
    return f;
  }

  /// From what a kick of 1 s adds to the velocities of nodes of 1 kg.
  template <class Real>
  Nodes force_of_motion(SimdLevel level) const {
    SheetMotion<Real> motion(*grid, Eigen::VectorXd::Ones(state.x.cols()), {}, level);
    Nodes x = Nodes::Zero(3, state.x.cols()), v = state.v;
    motion.load(state.x, state.v, 1e-3);
    motion.leap(1.0, 0.0, MassForce(), nullptr);
    for (int k = 0; k < grid->node_count(); ++k) {
      Vec3 at, rate;
      motion.get(kFirst + k, &at, &rate);
      v.col(kFirst + k) = rate;
    }
    return v - state.v;
  }

  static constexpr int kFirst = 3;
  static constexpr double kBendingDamping = 0.02;
  std::vector<std::unique_ptr<Energy>> terms;
  std::optional<GridSheet> grid;
  State state;
};

inline std::vector<SimdLevel> levels() {
  std::vector<SimdLevel> all;
  for (SimdLevel level : {SimdLevel::kSse2, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (level <= simd_level()) all.push_back(level);
  }
  return all;
}

}  // namespace deformable_sim::test
