#include "work_precision_sweep.h"

#include <algorithm>

#include "work_precision_run.h"

namespace deformable_sim::work_precision {
namespace {

constexpr double kShort = 0.1;       // CPU s: shorter runs are repeated ...
constexpr int kRepeats = 2;          // ... so many times, and the fastest counts
constexpr double kProbe = 0.02;      // of what a run may cost
constexpr double kLongSteps = 16.0;  // limits in a step of a probe
constexpr double kForBases = 0.25;   // of the budget, for runs that only tell what of an error is the solver's
constexpr double kWildStrain = 1.0;  // off by more than this, a finite state is no solution either

/// What the solver's part of an error is measured at.
std::string place(const Configuration& k) {
  return k.integrator + ", " + std::to_string(k.steps);
}

std::string seconds_text(double seconds) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g CPU s", seconds);
  return text;
}

}  // namespace

void Sweep::go(const std::vector<Family>& families) {
  for (const Family& family : families) {
    lanes_.push_back({family, 0, {}, 0.0});
    if (is_base(family.configuration)) bases_.push_back(family.configuration);
    if (!family.configuration.is_explicit()) continue;
    const double most = std::max(kShort, kProbe * bench_.most_per_run);
    lanes_.back().probed = probe(*bench_.subject, family.configuration, kLongSteps * bench_.verlet_step, most);
  }
  while (!lanes_.empty()) {
    const auto next = std::min_element(lanes_.begin(), lanes_.end(),
                                       [this](const Lane& a, const Lane& b) { return expected(a) < expected(b); });
    const double cost = expected(*next);
    std::string why;
    if (bench_.budget->spent() + cost > bench_.until) {
      why = "the budget ended it";
    } else if (cost > bench_.most_per_run) {
      why = "a run would cost " + seconds_text(cost);
    } else {
      Configuration k = next->family.configuration;
      k.steps = next->family.ladder[next->next++];
      next->rows.push_back(find_row(k));
      why = reason_to_stop(next->rows, rows_, bench_.reference->resolution());
      if (why.empty() && next->next < next->family.ladder.size()) continue;
    }
    if (!why.empty()) give_up(*next, why);
    lanes_.erase(next);
  }
}

double Sweep::expected(const Lane& lane) const {
  Configuration k = lane.family.configuration;
  k.steps = lane.family.ladder[lane.next];
  const double known_cost = expected_cpu(k, rows_);
  if (known_cost > 0.0) return known_cost;
  return k.is_explicit() ? lane.probed : guessed_cpu(*bench_.subject, k);
}

void Sweep::give_up(const Lane& lane, const std::string& why) {
  Configuration k = lane.family.configuration;
  const int steps = lane.rows.empty() ? 0 : lane.rows.back().configuration.steps;
  const std::string until =
      steps == 0 ? "not run" : "last step " + std::to_string(bench_.subject->quarter() / steps) + " s";
  left_out_.push_back(k.family() + ": " + until + "; " + why);
}

const Row* Sweep::known(const Configuration& k) const {
  const std::string key = k.key();
  const auto found =
      std::find_if(rows_.begin(), rows_.end(), [&key](const Row& row) { return row.configuration.key() == key; });
  return found == rows_.end() ? nullptr : &*found;
}

Row Sweep::find_row(const Configuration& k) {
  if (const Row* row = known(k)) return *row;
  if (const Row* row = bench_.log->find(k)) {
    rows_.push_back(*row);
    return *row;
  }
  // Before the run itself, since it may run another.
  const Trajectory* exact = k.is_explicit() || is_base(k) ? nullptr : base(k);
  Row row = measure(k);
  if (exact != nullptr) row.time_error = bench_.yardstick->position(*exact, bench_.reference->trajectory);
  rows_.push_back(row);
  bench_.log->append(row);
  return row;
}

Row Sweep::measure(const Configuration& k) {
  const double left = bench_.until - bench_.budget->spent();
  bench_.progress->show(k.key(), bench_.budget->spent(), left);
  const Case& c = *bench_.subject;
  Run best = run(c, k, bench_.tight, bench_.most_per_run);
  for (int again = 0; again < kRepeats && best.status == Status::kDone && best.cpu_seconds < kShort; ++again) {
    const Run other = run(c, k, bench_.tight, bench_.most_per_run, Pulls::kLeftOut);
    if (other.cost.cpu < best.cost.cpu) best.cost = other.cost;
  }
  Row row;
  row.configuration = k;
  row.dt = best.dt;
  row.status = best.status;
  row.note = best.note;
  row.cost = best.cost;
  row.cpu_seconds = best.cpu_seconds;
  row.errors = bench_.yardstick->errors(best.trajectory, bench_.reference->trajectory);
  if (row.status == Status::kDone && !(row.errors.strain <= kWildStrain) && !std::isnan(row.errors.strain)) {
    row.status = Status::kDiverged;
    row.note = "finite, but strains are off by " + std::to_string(row.errors.strain);
  }
  if (row.status != Status::kDone) {
    row.errors = Errors();
    return row;
  }
  const auto at = base_.find(place(k));
  if (k.is_explicit() || is_base(k)) {
    row.time_error = row.errors.position;
  } else if (at != base_.end()) {
    row.solver_error = bench_.yardstick->position(best.trajectory, at->second);
  }
  if (is_base(k) && at == base_.end()) base_[place(k)] = best.trajectory;
  return row;
}

const Trajectory* Sweep::base(const Configuration& k) {
  const auto known_base = base_.find(place(k));
  if (known_base != base_.end()) return &known_base->second;
  if (spent_on_bases_ > kForBases * bench_.until) return nullptr;
  const Configuration* cheapest = nullptr;
  double least = bench_.most_per_run;
  for (Configuration& candidate : bases_) {
    if (candidate.integrator != k.integrator) continue;
    candidate.steps = k.steps;
    const double known_cost = expected_cpu(candidate, rows_);
    const double expected = known_cost > 0.0 ? known_cost : guessed_cpu(*bench_.subject, candidate);
    if (expected > least || bench_.budget->spent() + expected > bench_.until) continue;
    least = expected;
    cheapest = &candidate;
  }
  if (cheapest == nullptr) return nullptr;
  const Row* before = bench_.log->find(*cheapest);
  if (before == nullptr) before = known(*cheapest);
  if (before != nullptr && before->status != Status::kDone) return nullptr;
  const Configuration chosen = *cheapest;
  const double began = bench_.budget->spent();
  if (before != nullptr) {
    // Run by the study that is resumed: its states were not kept.
    base_[place(k)] = run(*bench_.subject, chosen, bench_.tight, bench_.most_per_run).trajectory;
  } else {
    find_row(chosen);
  }
  spent_on_bases_ += bench_.budget->spent() - began;
  const auto made = base_.find(place(k));
  return made == base_.end() ? nullptr : &made->second;
}

}  // namespace deformable_sim::work_precision
