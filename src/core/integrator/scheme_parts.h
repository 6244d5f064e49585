// Steps and bookkeeping that several implicit schemes share.
#pragma once

#include "deformable_sim/core/integrator/stage_solver.h"

namespace deformable_sim {

/// One step of implicit Euler.
StepReport implicit_euler_step(double dt, StageSolver* stage, Dynamics* d, State* s);

/// Reactions from the outer force (3 x nodes, N) of one stage.
inline void take_reactions(const Nodes& outer_force, Kinematics* kinematics) {
  kinematics->reaction.resize(3, static_cast<Eigen::Index>(kinematics->node.size()));
  for (size_t k = 0; k < kinematics->node.size(); ++k) {
    kinematics->reaction.col(static_cast<Eigen::Index>(k)) = outer_force.col(kinematics->node[k]);
  }
}

/// Prescribed nodes take up the velocity of a step of dt seconds: they move straight from where they are to their
/// targets.
void take_up_speed(double dt, const Kinematics& kinematics, State* s);

/// The mean acceleration of a step of dt (s) needs the mean force: reaction = M (v1 - v0) / dt - f at prescribed nodes.
/// v0, v1 3 x nodes, m/s; mean_force 3 x nodes, N.
void average_reactions(double dt, const Nodes& v0, const Nodes& v1, const Nodes& mean_force, Dynamics* d);

/// The two stages of TR-BDF2, see tr_bdf2.cpp.
class TrBdf2Step {
 public:
  StepReport advance(double dt, StageSolver* stage, Dynamics* d, State* s);

 private:
  StepReport first_stage(double dt, StageSolver* stage, Dynamics* d, State* s);
  StepReport second_stage(double dt, StageSolver* stage, Dynamics* d, const State& s);
  void remember(double dt, const Dynamics& d, State* s) const;

  State middle_;   // at t + gamma dt
  Nodes v_start_;  // before prescribed nodes took up the speed of this step
  Nodes x_base_, v_base_;
  Nodes mean_force_, force_;  // of the terms: over the step, and at the middle
  std::vector<Vec3> contact_force_;
  Nodes prescribed_inertia_, remaining_force_;  // only with a mass matrix
};

}  // namespace deformable_sim
