// What is left of a model's terms for solvers that know springs, quadratic energies and forces on single nodes only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {

struct ConstantLinks;

struct KnownSpring {
  int a, b;          // world nodes
  double length;     // m
  double stiffness;  // N/m
  double damping;    // N s/m
  int term;          // springs of one term have one number
};

struct KnownTerms {
  MassForce everywhere;  // gravity, drag per mass
  std::vector<KnownSpring> springs;
  Eigen::SparseMatrix<double> stiffness, damping;  // n x n, f = -stiffness x - damping v; empty without such terms
  std::vector<const TargetSprings*> targets;
  std::vector<const Energy*> local;  // forces on nodes by themselves, and drag of the air
};

/// Sorts the terms of `energies` that are not in `without` (those of sheets on grids). Throws InputError naming the
/// first that is none of the above: finite elements, rods, bending by angles. nodes: 0 to refuse only, no matrices.
KnownTerms sort_terms(const std::string& integrator, const std::vector<const Energy*>& energies, Eigen::Index nodes,
                      const std::vector<const Energy*>& without);

/// Springs and constant links, for kernels that know nothing else.
struct SpringTerms {
  std::vector<KnownSpring> springs;
  std::vector<const ConstantLinks*> links;  // exact, with one damping
  std::vector<const Energy*> link_terms;    // what they are of
};

/// Whether a solver that takes springs and constant links apart (Needs::links_apart) has no need of the term's blocks.
bool stays_apart(const Energy& energy);

/// Takes springs out of `terms`, and constant links between nodes that have springs.
SpringTerms take_springs(std::vector<const Energy*>* terms);

/// Throws what sort_terms() would.
void refuse_unknown_terms(const std::string& integrator, const std::vector<std::unique_ptr<Energy>>& energies);

/// Whether the scheme of that name takes what sort_terms() takes, and nothing else.
bool takes_known_terms_only(const std::string& integrator);

}  // namespace deformable_sim
