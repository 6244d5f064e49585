#include "deformable_sim/core/integrator/rope_stage.h"

#include <algorithm>

#include "deformable_sim/core/parallel/workers.h"

namespace deformable_sim {

RopeStage::RopeStage(const SolverSettings& settings) : settings_(settings), generic_(settings) {}

void RopeStage::reset() {
  prepared_ = false;
  generic_.reset();
}

/// Sorts the terms and lays out the ropes.
void RopeStage::prepare(const Dynamics& d) {
  prepared_ = true;
  ropes_.clear();
  around_ = RopeSurroundings();
  fits_ = d.mass_matrix == nullptr;
  for (const Energy* energy : d.energies) {
    if (const MassForce* force = energy->mass_force()) {
      around_.everywhere.acceleration += force->acceleration;
      around_.everywhere.rate += force->rate;
    } else if (const auto* targets = dynamic_cast<const TargetSprings*>(energy)) {
      around_.targets.push_back(targets);
    } else {
      fits_ = fits_ && is_chain_term(*energy);
    }
  }
  const auto n = static_cast<int>(d.mass->size());
  const auto chains = fits_ ? find_chains(n, d.energies) : std::nullopt;
  fits_ = chains.has_value();
  if (!fits_) return;
  for (const RopeChain& chain : *chains) ropes_.emplace_back(chain, d, settings_, around_);
  parts_.resize(ropes_.size());
  workers_ = n >= Workers::kLeastSolvedNodes ? d.workers : nullptr;
  for (Nodes* nodes : {&end_.x, &end_.v, &force_, &outer_force_}) nodes->setZero(3, n);
}

StepReport RopeStage::solve(const StageEquation& equation, const State& start, const Dynamics& d) {
  if (!prepared_) prepare(d);
  solved_ = fits_ && d.contacts.empty();
  if (!solved_) return generic_.solve(equation, start, d);
  end_.time = start.time + equation.duration;
  end_.x.resize(3, start.x.cols());
  end_.v.resize(3, start.x.cols());
  for_each_piece(workers_, static_cast<int>(ropes_.size()), [&](int k) {
    RopeSolve& rope = ropes_[static_cast<size_t>(k)];
    Part& part = parts_[static_cast<size_t>(k)];
    part.report = StepReport();
    part.solved = rope.solve(equation, start, d, around_, &part.report);
    if (part.solved) rope.store(equation, around_, &end_, &force_, &outer_force_);
  });
  StepReport report;
  for (const auto& [solved, part] : parts_) {
    if (!solved) return solve_otherwise(equation, start, d);
    report.converged = report.converged && part.converged;
    report.newton_iterations = std::max(report.newton_iterations, part.newton_iterations);
    report.force_evaluations = std::max(report.force_evaluations, part.force_evaluations);
    if (!(part.residual <= report.residual)) report.residual = part.residual;  // keeps a NaN
  }
  return report;
}

StepReport RopeStage::solve_otherwise(const StageEquation& equation, const State& start, const Dynamics& d) {
  solved_ = false;
  StageEquation unknown_force = equation;  // force() knows held nodes only
  unknown_force.start_force = nullptr;
  return generic_.solve(unknown_force, start, d);
}

void RopeStage::find_force(const State& s, const Dynamics& d, Nodes* f) {
  if (!prepared_) prepare(d);
  if (!fits_) return generic_.find_force(s, d, f);
  f->resize(3, s.x.cols());
  for (RopeSolve& rope : ropes_) rope.find_force(s, around_, f);
}

void RopeStage::find_held_force(const State& s, const Dynamics& d, Nodes* f) {
  if (!prepared_) prepare(d);
  if (!fits_) return generic_.find_force(s, d, f);
  if (f->cols() != s.x.cols()) f->setZero(3, s.x.cols());
  for (const RopeSolve& rope : ropes_) rope.find_held_force(s, around_, f);
}

void RopeStage::report_contacts(ContactConstraints* contacts) const {
  if (!solved_) generic_.report_contacts(contacts);
}

}  // namespace deformable_sim
