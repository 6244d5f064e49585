// Crooked sheets as linear systems, and random numbers for them.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/linear/multigrid_solver.h"
#include "deformable_sim/core/linear/scalar_factor.h"
#include "support/crooked_sheet.h"
#include "support/system.h"

namespace deformable_sim::test {

inline Nodes noise(int n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, size);
  return Nodes::NullaryExpr(3, n, [&] { return normal(generator); });
}

inline double dot(const PaddedNodes& a, const PaddedNodes& b) {
  return a.cast<double>().cwiseProduct(b.cast<double>()).sum();
}

/// An implicit step's matrix of a crooked sheet of springs, 1 m wide, 0.2 kg/m^2, E h = 1e3 N/m, crumpled, one corner
/// held, and quadratic bending apart from it.
struct Sheet {
  enum class Shape { kCrumpled, kStretched };
  explicit Sheet(int side, Shape shape = Shape::kCrumpled)
      : mesh(crooked_sheet(side)), body(mesh.rest, sheet_masses(mesh, 0.2)) {
    SheetStiffness stiffness;
    stiffness.membrane = 1e3;
    body.add_springs(sheet_network(mesh, stiffness));
    body.add(
        make_quadratic_links("bending", quadratic_bending_weights(mesh, isotropic_bending(1e-5, 0.3)), kDamping, 0));
    body.build_pattern();
    if (shape == Shape::kCrumpled) {
      body.state.x += noise(side * side, 0.05 / side, 3);
    } else {
      body.state.x *= 1.02;
    }
    blocks = whole = body.pattern;
    for (const Energy* term : body.dynamics.energies) {
      term->add_jacobian(body.state, 1.0, 1.0 / kTau, Jacobian::kProjected, &whole);
      if (term->constant_links() == nullptr) {
        term->add_jacobian(body.state, 1.0, 1.0 / kTau, Jacobian::kProjected, &blocks);
      } else {
        links.push_back(term->constant_links());
      }
    }
    for (BlockMatrix* a : {&blocks, &whole}) {
      for (int i = 0; i < a->rows(); ++i) {
        a->block(a->diagonal_slot(i)).diagonal().array() += body.mass[i] / (kTau * kTau);
      }
      hold_first(a);
    }
    right_side = noise(side * side, 1.0, 7).array().rowwise() * body.mass.transpose().array();
    right_side.col(0).setZero();
    weight = body.mass.cwiseInverse();
    weight[0] = 0.0;
  }
  static void hold_first(BlockMatrix* a) {
    for (int k = a->row_start()[0]; k < a->row_start()[1]; ++k) {
      const int j = a->column()[static_cast<size_t>(k)];
      a->block(k).setZero();
      a->block(a->slot(j, 0)).setZero();
    }
    a->block(a->diagonal_slot(0)).setIdentity();
  }
  LinearReport solve(double tolerance, Nodes* x) const {
    const auto solver = make_multigrid_solver();
    solver->set_links(links, kTau, {0});
    solver->prepare(blocks);
    x->setZero(3, blocks.rows());
    LinearTolerance asked;
    asked.relative = tolerance;
    return solver->solve(blocks, right_side, weight, asked, x);
  }

  static constexpr double kTau = 1.0 / 180.0, kDamping = 0.01;  // s
  TriangleMesh mesh;
  System body;
  BlockMatrix blocks, whole;
  std::vector<const ConstantLinks*> links;
  Nodes right_side;
  Eigen::VectorXd weight;
};

}  // namespace deformable_sim::test
