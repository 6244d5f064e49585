#include "work_precision_run.h"

#include <algorithm>

#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim::work_precision {
namespace {

constexpr double kLookEvery = 0.05;       // CPU s between looks at the clock
constexpr int kConvergedIterations = 60;  // of Newton's method, at most
constexpr double kSafety = 0.9;           // of the stability limit, that worlds keep
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kRounding = 8.0 * 2.2e-16;

Sample sample_of(const World& world) {
  const State& s = world.state();
  const Model& model = world.model();
  Sample sample;
  sample.x = s.x;
  if (model.mass_matrix.nonZeros() > 0) {
    sample.kinetic = 0.5 * (s.v * model.mass_matrix).cwiseProduct(s.v).sum();
  } else {
    sample.kinetic = 0.5 * s.v.colwise().squaredNorm().dot(model.mass);
  }
  for (const auto& energy : model.energies) sample.stored += energy->value(s);
  return sample;
}

/// Thread CPU time of the steps alone, and a limit on it.
class Clock {
 public:
  explicit Clock(double most) : most_(most) { resume(); }
  void resume() { began_ = thread_cpu_time(); }
  void pause() { spent_ += thread_cpu_time() - began_; }
  double first_step() const { return first_; }
  double spent() const { return spent_; }

  /// After each step. False: it has cost too much.
  bool step() {
    if (++since_ < stride_) return true;
    since_ = 0;
    const double now = spent_ + thread_cpu_time() - began_;
    if (first_ < 0.0) {
      first_ = now;
      stride_ = static_cast<long>(std::clamp(kLookEvery / std::max(now, 1e-9), 1.0, 1000.0));
    }
    return now <= most_;
  }

 private:
  double most_, began_ = 0.0, spent_ = 0.0, first_ = -1.0;
  long since_ = 0, stride_ = 1;
};

/// Mean of what each grasp feels over the steps since the last time.
class MeanPull {
 public:
  void add(const std::vector<GraspReport>& grasps) {
    if (steps_++ == 0) sum_.setZero(6, static_cast<Eigen::Index>(grasps.size()));
    for (Eigen::Index g = 0; g < sum_.cols(); ++g) {
      const GraspReport& grasp = grasps[static_cast<size_t>(g)];
      sum_.col(g).head<3>() += grasp.force;
      sum_.col(g).tail<3>() += grasp.torque;
    }
  }
  Eigen::Matrix<double, 6, Eigen::Dynamic> take() {
    const Eigen::Matrix<double, 6, Eigen::Dynamic> mean = sum_ / std::max(1, steps_);
    steps_ = 0;
    return mean;
  }

 private:
  Eigen::Matrix<double, 6, Eigen::Dynamic> sum_;
  int steps_ = 0;
};

/// Sums of the reports of all steps.
struct Tally {
  long steps = 0, forces = 0, newton = 0, linear = 0, unconverged = 0;

  void add(const StepReport& report) {
    ++steps;
    forces += report.force_evaluations;
    newton += report.newton_iterations;
    linear += report.linear_iterations;
    unconverged += report.converged ? 0 : 1;
  }
};

Cost cost_of(const Tally& tally, const Clock& clock, double dt) {
  Cost cost;
  const double seconds = static_cast<double>(tally.steps) * dt;
  cost.first_step = clock.first_step();
  cost.cpu = tally.steps > 1 ? (clock.spent() - clock.first_step()) / (seconds - dt) : clock.spent() / seconds;
  cost.force_evaluations = static_cast<double>(tally.forces) / seconds;
  cost.newton_iterations = static_cast<double>(tally.newton) / seconds;
  cost.linear_iterations = static_cast<double>(tally.linear) / seconds;
  cost.unconverged = static_cast<double>(tally.unconverged) / static_cast<double>(tally.steps);
  return cost;
}

}  // namespace

SolverSettings settings_of(const Case& c, const Configuration& configuration, double tight) {
  SolverSettings settings = c.solver;
  settings.precision =
      configuration.precision == "single" ? SolverSettings::Precision::kSingle : SolverSettings::Precision::kDouble;
  if (configuration.is_explicit()) return settings;
  const std::string& linear = configuration.linear_solver;
  settings.linear = linear == "banded"      ? SolverSettings::Linear::kBanded
                    : linear == "multigrid" ? SolverSettings::Linear::kMultigrid
                    : linear == "direct"    ? SolverSettings::Linear::kDirect
                                            : SolverSettings::Linear::kConjugateGradient;
  // What a rope takes where its scene says nothing.
  if (linear == "banded" && !c.jacobian_given) settings.jacobian = Jacobian::kLagged;
  if (configuration.is_iterative()) {
    settings.linear_tolerance = configuration.linear_tolerance;
    settings.linear_iterations = configuration.linear_iterations;
  }
  settings.newton_iterations = configuration.is_converged() ? kConvergedIterations : configuration.newton_iterations;
  if (configuration.is_converged()) settings.tolerance = tight;
  return settings;
}

Run run(const Case& c, const Configuration& configuration, double tight, double most, Pulls pulls) {
  Run run;
  run.dt = c.quarter() / configuration.steps;
  const std::unique_ptr<World> world = c.make(run.dt, configuration.integrator, settings_of(c, configuration, tight));
  const bool feel = pulls == Pulls::kMeasured && !world->grasp_reports().empty();
  Tally tally;
  MeanPull pull;
  Clock clock(most);
  for (int quarter = 0; quarter < kQuarters && run.status == Status::kDone; ++quarter) {
    for (int k = 0; k < configuration.steps; ++k) {
      const StepOutcome outcome = world->step();
      if (!outcome.ok) {
        run.status = Status::kDiverged;
        run.note = outcome.message;
        break;
      }
      tally.add(outcome.report);
      if (!clock.step()) {
        run.status = Status::kStopped;
        run.note = "had cost more than its share of the budget by t = " + std::to_string(world->time()) + " s";
        break;
      }
      if (!feel) continue;
      clock.pause();
      pull.add(world->grasp_reports());
      clock.resume();
    }
    clock.pause();
    if (run.status == Status::kDone) {
      run.trajectory.push_back(sample_of(*world));
      run.trajectory.back().pull = pull.take();
    }
    clock.resume();
  }
  run.cpu_seconds = clock.spent();
  if (tally.steps > 0) run.cost = cost_of(tally, clock, run.dt);
  return run;
}

double probe(const Case& c, const Configuration& configuration, double dt, double most) {
  Configuration k = configuration;
  k.steps = std::max(k.steps, static_cast<int>(std::min(1e9, std::ceil(c.quarter() / dt))));
  const Run begun = run(c, k, 0.0, most, Pulls::kLeftOut);
  return begun.cost.cpu * c.seconds;
}

double usable_step(const Case& c, const std::string& integrator) {
  if (std::isinf(make_integrator(integrator, c.solver)->stability_limit())) return kUnlimited;
  constexpr double kShortest = 1e-7, kLongest = 0.05;  // s
  constexpr int kEnough = 20;                          // parts
  for (double dt = kShortest;; dt *= 10.0) {
    const std::unique_ptr<World> world = c.make(std::min(dt, kLongest), integrator, c.solver);
    world->step();
    const int parts = world->snapshot().substeps;
    if (parts >= kEnough || dt >= kLongest) return std::min(dt, kLongest) / parts;
  }
}

double tight_tolerance(const Case& c, double verlet_step, double least) {
  const double omega = 2.0 * kSafety / verlet_step;
  const Nodes x = c.make(verlet_step, "velocity_verlet", c.solver)->state().x;
  const double size = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).maxCoeff();
  return std::max(least, kRounding * omega * omega * size);
}

}  // namespace deformable_sim::work_precision
