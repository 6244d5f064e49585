#include "deformable_sim/core/integrator/sheet_stage.h"

#include <algorithm>

#include "deformable_sim/core/integrator/rope_stage.h"

namespace deformable_sim {
namespace {

/// Sheets are shared out whole where there is one for every thread, or where none is large enough for bands.
bool are_shared_whole(const std::vector<GridSheet>& grids, int threads) {
  int nodes = 0;
  bool small = true;
  for (const GridSheet& grid : grids) {
    nodes += grid.node_count();
    small = small && Bands::of(grid.rows, grid.cols).count() == 1;
  }
  return nodes >= Workers::kLeastSolvedNodes && (small || static_cast<int>(grids.size()) >= threads);
}

}  // namespace

void SheetStage::reset() {
  prepared_ = false;
  generic_.reset();
}

bool sheets_fit(const Dynamics& d) {
  std::vector<const Energy*> in_rows;
  Eigen::Index count = 0;
  if (d.grids != nullptr) {
    for (const GridSheet& grid : *d.grids) {
      count += grid.node_count();
      in_rows.insert(in_rows.end(), grid.replaces.begin(), grid.replaces.end());
    }
  }
  const auto known = [&](const Energy* energy) {
    return energy->mass_force() != nullptr || dynamic_cast<const TargetSprings*>(energy) != nullptr ||
           dynamic_cast<const LimitSprings*>(energy) != nullptr ||
           std::find(in_rows.begin(), in_rows.end(), energy) != in_rows.end();
  };
  return count == d.mass->size() && d.mass_matrix == nullptr && !d.bodies_meet &&
         std::all_of(d.energies.begin(), d.energies.end(), known);
}

/// Sorts the terms and lays out the sheets.
void SheetStage::prepare(const Dynamics& d) {
  prepared_ = true;
  sheets_.clear();
  around_ = SheetSurroundings();
  fits_ = sheets_fit(d);
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
  reports_.resize(sheets_.size());
  workers_ = d.workers != nullptr && are_shared_whole(*d.grids, d.workers->threads()) ? d.workers : nullptr;
}

StepReport SheetStage::solve(const StageEquation& equation, const State& start, const Dynamics& d) {
  if (!prepared_) prepare(d);
  in_rows_ = fits_ && !is_unresolved(equation.tau, start, d);
  if (!in_rows_) return generic_.solve(equation, start, d);
  for (Nodes* nodes : {&end_.x, &end_.v, &force_, &outer_force_}) nodes->resize(3, start.x.cols());
  end_.time = start.time + equation.duration;
  for_each_piece(workers_, static_cast<int>(sheets_.size()), [&](int k) {
    const auto i = static_cast<size_t>(k);
    reports_[i] = sheets_[i]->solve(equation, start, d, around_);
    sheets_[i]->store(&end_, &force_, &outer_force_);
  });
  StepReport report;
  for (const StepReport& part : reports_) {
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
  if (!in_rows_) return generic_.report_contacts(contacts);
  for (const auto& sheet : sheets_) sheet->report_contacts(contacts);
}

std::unique_ptr<StageSolver> make_stage_solver(const SolverSettings& settings) {
  if (settings.linear == SolverSettings::Linear::kMultigrid) return std::make_unique<SheetStage>(settings);
  if (settings.linear == SolverSettings::Linear::kBanded && settings.jacobian == Jacobian::kLagged) {
    return std::make_unique<RopeStage>(settings);
  }
  return std::make_unique<ImplicitStage>(settings);
}

Needs stage_needs(const SolverSettings& settings) {
  return {true, false, settings.linear == SolverSettings::Linear::kMultigrid};
}

}  // namespace deformable_sim
