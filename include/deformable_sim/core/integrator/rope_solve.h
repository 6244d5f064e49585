// Newton's method for a stage of one rope, in one walk along it.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/integrator/stage_solver.h"
#include "deformable_sim/core/rope/rope_chain.h"
#include "deformable_sim/core/rope/rope_kernels.h"

namespace deformable_sim {

/// What acts on ropes beside their own springs and bending.
struct RopeSurroundings {
  MassForce everywhere;
  std::vector<const TargetSprings*> targets;
};

/// The whole Newton steps of ImplicitStage (same matrix, start and measure of what is left) for one chain without
/// contacts. Forces, matrix, factors and solution are made in one walk from both ends of the rope to its middle and
/// back (RopeKernels), in double precision.
///
/// Not good at: slack chains without bending, whose folds whole steps throw to and fro: solve() says so.
class RopeSolve {
 public:
  RopeSolve(const RopeChain& chain, const Dynamics& d, const SolverSettings& settings, const RopeSurroundings& around);

  /// False: whole steps lead nowhere here.
  bool solve(const StageEquation& equation, const State& start, const Dynamics& d, const RopeSurroundings& around,
             StepReport* report);
  /// f := the terms' force, in this rope's columns.
  void find_force(const State& s, const RopeSurroundings& around, Nodes* f);
  /// The same of held nodes alone.
  void find_held_force(const State& s, const RopeSurroundings& around, Nodes* f) const;
  /// Into this rope's columns: x and v at the stage; of held nodes only the terms' force, and M a - f - more_force.
  void store(const StageEquation& equation, const RopeSurroundings& around, State* end, Nodes* force,
             Nodes* outer_force) const;

 private:
  struct Held {
    int node;  // of the rope
    Eigen::Index column;
  };
  struct Soft {
    int node;
    const TargetSprings* springs;
    Eigen::Index column;
  };

  void lay_out();
  void set_step(double tau, double rate);
  void begin(const StageEquation& equation, const State& start, const Dynamics& d, const RopeSurroundings& around);
  void load(const Nodes& nodes);
  void set_bases();
  void guess(const StageEquation& equation, const State& start, const RopeSurroundings& around);
  void place_held(const StageEquation& equation, const State& start, const Kinematics& kinematics);
  void add_soft();
  void copy_middle();
  void store(int place, const Two* values, double* to) const;
  std::array<std::ptrdiff_t, 2> columns(int place) const;
  int column(int node) const { return chain_.first_node + node; }
  /// Of a node: place and lane.
  std::pair<int, int> seat(int node) const {
    return node < system_.half ? std::pair<int, int>{node, 0} : std::pair<int, int>{2 * system_.half - 1 - node, 1};
  }

  RopeChain chain_;
  SolverSettings settings_;
  const RopeKernels& kernels_;
  Eigen::VectorXd mass_;
  std::vector<Held> held_;
  std::vector<Soft> soft_;
  double free_ = 1.0;  // number of free nodes
  double tau_ = 0.0, rate_ = -1.0;
  std::vector<std::array<double, 3>> band_;  // by node: RopePlace::band, without and with what holds
  std::vector<double> inertia_;
  RopeSystem system_;
  std::vector<RopePlace> places_;
  std::vector<RopeSpan> spans_;
  std::vector<RopeDamping> damping_;
  std::vector<RopeFactor> factors_;
};

}  // namespace deformable_sim
