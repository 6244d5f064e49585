#include "deformable_sim/core/integrator/sheet_solve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim {
namespace {

// As in ImplicitStage.
constexpr double kEnough = 0.9;
constexpr double kMostGrowth = 1.5;
constexpr double kInexact = 0.3;
constexpr double kFarthest = 4.0;
constexpr double kLeastLeft = 1.0 - 1.0 / kFarthest;
constexpr int kHalvings = 8;
constexpr double kLinearShare = 0.3;
constexpr double kAtRest = 1e-3;
constexpr int kFrictionIterations = 5;
constexpr int kMore = 4;

constexpr double kDigits = 1e-4;  // relative residual that single precision can give

}  // namespace

SheetSolve::SheetSolve(const GridSheet& sheet, const Dynamics& d, const SolverSettings& settings)
    : settings_(settings),
      bands_(Bands::of(sheet.rows, sheet.cols), d.workers),
      rows_(sheet, bands_.scratch_count()),
      kernels_(stage_kernels(simd_level())),
      forces_(sheet_kernels(simd_level())),
      first_(sheet.first_node),
      count_(sheet.node_count()),
      x_(rows_.make_xyz()),
      before_(rows_.make_xyz()),
      base_(rows_.make_xyz()),
      target_(rows_.make_xyz()),
      v_(rows_.make_xyz()),
      y_(rows_.make_xyz()),
      force_(rows_.make_xyz()),
      mass_rows_(rows_.make_array()),
      per_tau_(rows_.make_array()),
      inertia_(rows_.make_array()),
      touched_of_(static_cast<size_t>(count_), -1) {
  for (int k = 0; k < count_; ++k) {
    mass_.push_back((*d.mass)[first_ + k]);
    mass_rows_.data()[rows_.place(k)] = mass_.back();
  }
  std::vector<char> free(static_cast<size_t>(count_), 1);
  for (size_t k = 0; k < d.kinematics.node.size(); ++k) {
    const int node = d.kinematics.node[k] - first_;
    if (node < 0 || node >= count_) continue;
    held_.push_back({node, k});
    free[static_cast<size_t>(node)] = 0;
  }
  free_count_ = static_cast<double>(std::max(1, count_ - static_cast<int>(held_.size())));
  system_ = std::make_unique<SheetSystem>(sheet, mass_, free, d.workers);
  untouched_weight_ = system_->rows().make_array();
  for (int k = 0; k < count_; ++k) {
    untouched_weight_.data()[rows_.place(k)] = system_->weight()[rows_.place(k)];
  }
}

void SheetSolve::put(Xyz<double> rows, std::ptrdiff_t place, const Vec3& value) {
  rows.x[place] = value[0];
  rows.y[place] = value[1];
  rows.z[place] = value[2];
}

StepReport SheetSolve::solve(const StageEquation& equation, const State& start, const Dynamics& d,
                             const SheetSurroundings& around) {
  StepReport report;
  double began = thread_cpu_time();
  begin(equation, start, d, around);
  report.residual = start_iteration();
  const double enough = settings_.tolerance;
  report.converged = report.residual <= kAtRest * enough;
  const int most = settings_.newton_iterations;
  for (int k = 0; k < most || (k < most + kMore && is_rough(report)); ++k) {
    if (report.converged) break;
    couple();
    system_->linearise(x_.data(), rows_.shape());
    const double solving = thread_cpu_time();
    report.seconds_assembly += solving - began;
    LinearReport linear;
    const LinearTolerance tolerance{std::max(settings_.linear_tolerance, kDigits), kLinearShare * settings_.tolerance,
                                    settings_.linear_iterations};
    slope_ = system_->solve(tolerance, report.residual, free_count_, &linear);
    report.linear_iterations += linear.iterations;
    began = thread_cpu_time();
    report.seconds_solve += began - solving;
    if (!(slope_ > 0.0) || !std::isfinite(slope_)) break;
    search_along_step();
    if (!contacts_.empty() && k < kFrictionIterations) {
      contacts_.update_normal_forces(touched_x_);
      add_touched(false);
    }
    ++report.newton_iterations;
    report.residual = unbalanced();
    report.converged = report.residual <= enough;
  }
  if (!report.converged && !contacts_.empty()) push_out();
  report.seconds_assembly += thread_cpu_time() - began;
  report.force_evaluations = force_evaluations_;
  return report;
}

void SheetSolve::begin(const StageEquation& equation, const State& start, const Dynamics& d,
                       const SheetSurroundings& around) {
  equation_ = equation;
  start_ = &start;
  dynamics_ = &d;
  around_ = &around;
  force_evaluations_ = 0;
  find_touched(d, around);
  set_formula();
  set_target();
  residual_.x_base = base_.data();
  residual_.per_tau = per_tau_.data();
  residual_.inertia = inertia_.data();
  residual_.target = target_.data();
  residual_.v = v_.data();
  residual_.y = y_.data();
  residual_.force = force_.data();
  residual_.downhill = system_->residual();
  residual_.weight = untouched_weight_.data();
}

Vec3 SheetSolve::held_position(const Held& held) const {
  const Vec3 target = dynamics_->kinematics.target.col(static_cast<Eigen::Index>(held.column));
  const Vec3 x = start_->x.col(first_ + held.node);
  return equation_.fraction == 1.0 ? target : Vec3(x + equation_.fraction * (target - x));
}

/// per_tau_ and inertia_: the same everywhere but where contacts are near.
void SheetSolve::set_formula() {
  const double tau = equation_.tau, rate = around_->everywhere.rate;
  const auto set = [this, rate](std::ptrdiff_t place, int node, double time) {
    per_tau_.data()[place] = 1.0 / time;
    const double inertia = mass_[static_cast<size_t>(node)] * (1.0 / time + rate) / time;
    inertia_.data()[place] = inertia;
    system_->inertia()[place] = static_cast<float>(inertia);
  };
  if (formula_tau_ != tau || formula_rate_ != rate || !off_formula_.empty()) {
    for (int k = 0; k < count_; ++k) set(rows_.place(k), k, tau);
    formula_tau_ = tau;
    formula_rate_ = rate;
    off_formula_.clear();
  }
  if (equation_.duration != tau) {
    for (const Touched& t : touched_) {
      if (!t.near || system_->weight()[t.place] == 0.0f) continue;
      set(t.place, t.node, equation_.duration);
      off_formula_.push_back(t.place);
    }
  }
  system_->set_step(tau, (1.0 / tau + rate) / tau, settings_.jacobian);
}

/// x_ of free nodes, base_, and target_: with inertia x less target = M a + rate M v - weight - more_force.
void SheetSolve::set_target() {
  const double tau = equation_.tau, rate = around_->everywhere.rate;
  const std::ptrdiff_t offset = 3 * static_cast<std::ptrdiff_t>(first_);
  SheetStart begin{};
  begin.x0 = start_->x.data() + offset;
  begin.v0 = start_->v.data() + offset;
  begin.x_base = equation_.x_base->data() + offset;
  begin.v_base = equation_.v_base->data() + offset;
  begin.more = equation_.more_force != nullptr ? equation_.more_force->data() + offset : nullptr;
  begin.reach = equation_.duration;
  begin.of_x = (1.0 / tau + rate) / tau;
  begin.of_v = 1.0 / tau;
  for (int k = 0; k < 3; ++k) begin.weight[k] = around_->everywhere.acceleration[k];
  begin.mass = mass_rows_.data();
  begin.x = x_.data();
  begin.base = base_.data();
  begin.target = target_.data();
  bands_.run([&](const RowBand& rows, int) { kernels_.start(rows_.shape(), begin, rows); });
  for (const Touched& t : touched_) {
    if (per_tau_.data()[t.place] != 1.0 / tau) follow_implicit_euler(t.place, t.node);
  }
}

void SheetSolve::follow_implicit_euler(std::ptrdiff_t place, int node) {
  const Vec3 x = start_->x.col(first_ + node), v = start_->v.col(first_ + node);
  const double time = equation_.duration, rate = around_->everywhere.rate;
  put(base_.data(), place, x);
  put(target_.data(), place,
      mass_[static_cast<size_t>(node)] *
          ((1.0 / time + rate) / time * x + v / time + around_->everywhere.acceleration));
}

/// From where every node would be with the velocity it has. Accelerations are left out: those of stiff springs are
/// large and short-lived, and take more iterations to undo than they save; at rest there are none. Strain limits, met
/// at the start and all but rigid, are not always met there: with them the start itself is the other choice.
double SheetSolve::start_iteration() {
  for (const Held& held : held_) put(x_.data(), rows_.place(held.node), held_position(held));
  evaluate(false);
  if (around_->limits.empty()) return unbalanced();
  const double moved = unbalanced();
  rows_.load(start_->x, before_.data());
  for (const Held& held : held_) put(before_.data(), rows_.place(held.node), held_position(held));
  std::swap(x_, before_);
  evaluate(false);
  if (moved < unbalanced()) {
    std::swap(x_, before_);
    evaluate(false);
  }
  return unbalanced();
}

void SheetSolve::evaluate(bool along_step) {
  residual_.x = x_.data();
  residual_.step = along_step ? system_->step() : Xyz<float>{nullptr, nullptr, nullptr};
  if (bands_.apart()) {
    bands_.run([&](const RowBand& rows, int) { kernels_.rates(rows_.shape(), residual_, rows); });
  }
  std::array<SheetResidualSums, Bands::kMost> parts;
  bands_.run_each([&](int band, const RowBand& rows, int scratch) {
    parts[static_cast<size_t>(band)] = kernels_.residual(rows_.shape(), residual_, rows_.scratch(scratch), rows);
  });
  sums_ = {parts[0].squares, parts[0].work};
  for (int k = 1; k < bands_.count(); ++k) {
    sums_.squares += parts[static_cast<size_t>(k)].squares;
    sums_.work += parts[static_cast<size_t>(k)].work;
  }
  base_sums_ = sums_;
  ++force_evaluations_;
  if (touched_.empty()) return;
  gather();
  add_terms(&touched_force_);
  const Xyz<double> f = force_.data(), target = target_.data(), x = x_.data();
  const Xyz<float> step = system_->step();
  for (size_t k = 0; k < touched_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::ptrdiff_t place = touched_[k].place;
    put(f, place, at(f, place) + touched_force_.col(i));
    touched_base_[k] = at(target, place) + at(f, place) - inertia_.data()[place] * at(x, place);
    if (along_step) base_sums_.work += touched_force_.col(i).dot(Vec3(step.x[place], step.y[place], step.z[place]));
  }
  add_touched(along_step);
}

/// RMS of r / m over the free nodes, m/s^2.
double SheetSolve::unbalanced() const {
  return std::sqrt(sums_.squares / free_count_);
}

/// x_ = before_ + fraction * step.
void SheetSolve::advance(double fraction) {
  bands_.run([&](const RowBand& rows, int) {
    kernels_.advance(rows_.shape(), before_.data(), fraction, system_->step(), x_.data(), rows);
  });
}

/// See ImplicitStage::search_along_step.
void SheetSolve::search_along_step() {
  std::swap(x_, before_);
  double fraction = 1.0;
  for (int k = 0; k <= kHalvings; ++k, fraction *= 0.5) {
    advance(fraction);
    evaluate(true);
    if (unbalanced() <= settings_.tolerance) return;
    const double ratio = sums_.work / slope_;
    if (!(ratio >= -kEnough && ratio <= kMostGrowth)) continue;
    if (std::abs(ratio) <= kInexact) return;
    const double full = unbalanced();
    const double other = ratio < kLeastLeft ? fraction / (1.0 - ratio) : kFarthest * fraction;
    advance(other);
    evaluate(true);
    if (unbalanced() < full) return;
    advance(fraction);
    evaluate(true);
    return;
  }
}

void SheetSolve::find_force(const State& s, const SheetSurroundings& around, Nodes* f) {
  const Xyz<double> x = x_.data(), v = v_.data(), y = y_.data(), force = force_.data();
  const std::ptrdiff_t offset = 3 * static_cast<std::ptrdiff_t>(first_);
  kernels_.load(rows_.shape(), s.x.data() + offset, s.v.data() + offset, x, v, y);
  forces_.forces(rows_.shape(), x, v, y, force, rows_.scratch());
  rows_.store(force, f);
  const MassForce& everywhere = around.everywhere;
  for (int k = 0; k < count_; ++k) {
    f->col(first_ + k) +=
        mass_[static_cast<size_t>(k)] * (everywhere.acceleration - everywhere.rate * s.v.col(first_ + k));
  }
}

void SheetSolve::store(State* end, Nodes* force, Nodes* outer_force) {
  const std::ptrdiff_t offset = 3 * static_cast<std::ptrdiff_t>(first_);
  SheetEnd all{};
  all.x = x_.data();
  all.base = base_.data();
  all.force = force_.data();
  all.per_tau = per_tau_.data();
  all.mass = mass_rows_.data();
  all.rate = around_->everywhere.rate;
  for (int k = 0; k < 3; ++k) all.weight[k] = around_->everywhere.acceleration[k];
  all.points = end->x.data() + offset;
  all.velocities = end->v.data() + offset;
  all.forces = equation_.force_wanted ? force->data() + offset : nullptr;
  bands_.run([&](const RowBand& rows, int) { kernels_.end(rows_.shape(), all, rows); });
  for (const Held& held : held_) {
    const std::ptrdiff_t place = rows_.place(held.node);
    outer_force->col(first_ + held.node) =
        inertia_.data()[place] * at(all.x, place) - at(target_.data(), place) - at(all.force, place);
  }
}

}  // namespace deformable_sim
