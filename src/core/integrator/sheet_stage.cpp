#include "deformable_sim/core/integrator/sheet_stage.h"

#include <algorithm>

namespace deformable_sim {

void SheetStage::reset() {
  prepared_ = false;
  generic_.reset();
}

bool SheetStage::is_enough_for(const Dynamics& d) {
  if (d.grids == nullptr || d.mass_matrix != nullptr) return false;
  Eigen::Index count = 0;
  std::vector<const Energy*> in_rows;
  for (const GridSheet& grid : *d.grids) {
    count += grid.node_count();
    in_rows.insert(in_rows.end(), grid.replaces.begin(), grid.replaces.end());
  }
  const auto fits = [&in_rows](const Energy* energy) {
    return energy->mass_force() != nullptr || dynamic_cast<const TargetSprings*>(energy) != nullptr ||
           dynamic_cast<const LimitSprings*>(energy) != nullptr ||
           std::find(in_rows.begin(), in_rows.end(), energy) != in_rows.end();
  };
  return count == d.mass->size() && std::all_of(d.energies.begin(), d.energies.end(), fits);
}

/// Sorts the terms and lays out the sheets.
void SheetStage::prepare(const Dynamics& d) {
  prepared_ = true;
  sheets_.clear();
  around_ = SheetSurroundings();
  fits_ = is_enough_for(d);
  if (!fits_) return;
  for (const Energy* energy : d.energies) {
    if (const MassForce* force = energy->mass_force()) {
      around_.everywhere.acceleration += force->acceleration;
      around_.everywhere.rate += force->rate;
    } else if (const auto* targets = dynamic_cast<const TargetSprings*>(energy)) {
      around_.targets.push_back(targets);
    } else if (const auto* limits = dynamic_cast<const LimitSprings*>(energy)) {
      around_.limits.push_back(limits);
    }
  }
  for (const GridSheet& grid : *d.grids) sheets_.push_back(std::make_unique<SheetSolve>(grid, d, settings_));
}

StepReport SheetStage::solve(const StageEquation& equation, const State& start, const Dynamics& d) {
  if (!prepared_) prepare(d);
  if (!fits_) return generic_.solve(equation, start, d);
  for (Nodes* nodes : {&end_.x, &end_.v, &force_, &outer_force_}) nodes->resize(3, start.x.cols());
  end_.time = start.time + equation.duration;
  StepReport report;
  for (const auto& sheet : sheets_) {
    const StepReport part = sheet->solve(equation, start, d, around_);
    sheet->store(&end_, &force_, &outer_force_);
    report.converged = report.converged && part.converged;
    report.newton_iterations = std::max(report.newton_iterations, part.newton_iterations);
    report.linear_iterations += part.linear_iterations;
    report.force_evaluations = std::max(report.force_evaluations, part.force_evaluations);
    if (!(part.residual <= report.residual)) report.residual = part.residual;  // keeps a NaN
    report.seconds_assembly += part.seconds_assembly;
    report.seconds_solve += part.seconds_solve;
  }
  return report;
}

void SheetStage::find_force(const State& s, const Dynamics& d, Nodes* f) {
  if (!prepared_) prepare(d);
  if (!fits_) return generic_.find_force(s, d, f);
  f->resize(3, s.x.cols());
  for (const auto& sheet : sheets_) sheet->find_force(s, around_, f);
  for (const TargetSprings* springs : around_.targets) springs->add_force(s, f);
  for (const LimitSprings* limits : around_.limits) limits->add_force(s, f);
}

void SheetStage::report_contacts(ContactConstraints* contacts) const {
  if (!fits_) return generic_.report_contacts(contacts);
  for (const auto& sheet : sheets_) sheet->report_contacts(contacts);
}

std::unique_ptr<StageSolver> make_stage_solver(const SolverSettings& settings) {
  if (settings.linear == SolverSettings::Linear::kMultigrid) return std::make_unique<SheetStage>(settings);
  return std::make_unique<ImplicitStage>(settings);
}

}  // namespace deformable_sim
