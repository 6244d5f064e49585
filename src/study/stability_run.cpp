#include "stability_run.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/scene/build.h"

namespace deformable_sim::stability {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
constexpr int kBoundedExplicit = 400, kBoundedImplicit = 60;  // steps
constexpr double kFar = 20.0;          // times the size and the furthest of the reference: no longer bounded
constexpr double kWithoutReach = 1e4;  // sizes, where the reference is not known
constexpr double kClear = 0.2;         // of kOnePercent, that a reference may be uncertain by
constexpr int kLookEvery = 16;         // steps, at the clock

double rms(const Nodes& a, const Nodes& b, int points) {
  return std::sqrt((a.leftCols(points) - b.leftCols(points)).colwise().squaredNorm().mean());
}

/// What a run is judged by, quarter after quarter.
class Judge {
 public:
  Judge(const Subject& subject, const Reference& reference, double dt)
      : subject_(subject), reference_(reference), dt_(dt), points_(subject.model->point_count()) {
    const double reach = reference.furthest() > 0.0 ? kFar * reference.furthest() : kWithoutReach * subject.size;
    most_ = kFar * subject.size + reach;
    const double seconds = instant(dt, kQuarters), fall = 0.5 * subject.model->gravity.norm() * seconds * seconds;
    scale_ = fall > 0.0 ? std::min(subject.size, fall) : subject.size;
  }
  bool bounded(const Nodes& x) const {
    return x.allFinite() && (x - subject_.model->initial.x).leftCols(points_).cwiseAbs().maxCoeff() < most_;
  }
  void compare(const Nodes& x, int quarter) {
    const Reference::Instant* exact = reference_.at(instant(dt_, quarter));
    if (exact == nullptr) {
      known_ = false;
      return;
    }
    known_ = known_ && exact->uncertain <= kClear * kOnePercent * scale_;
    error_ = std::max(error_, rms(x, exact->x, points_) / scale_);
  }
  void settle(Outcome* outcome) const {
    outcome->error = known_ ? error_ : kNotKnown;
    outcome->verdict = !known_ ? Class::kUnknown : error_ <= kOnePercent ? Class::kRight : Class::kWrong;
  }

 private:
  const Subject& subject_;
  const Reference& reference_;
  double dt_, most_ = 0.0, scale_ = 1.0, error_ = 0.0;
  int points_;
  bool known_ = true;
};

/// Runs out of time.
class Patience {
 public:
  explicit Patience(double most) : began_(thread_cpu_time()), most_(most) {}
  double spent() const { return thread_cpu_time() - began_; }
  bool is_over(int step) const { return step % kLookEvery == 0 && spent() > most_; }
  bool is_over() const { return spent() > most_; }

 private:
  double began_, most_;
};

void diverged(Outcome* outcome, double time) {
  outcome->verdict = Class::kDiverged;
  outcome->error = std::numeric_limits<double>::infinity();
  outcome->reached = time;
}

void too_slow(Outcome* outcome, double time) {
  outcome->verdict = Class::kSlow;
  outcome->error = kNotKnown;
  outcome->note = "stopped: too dear";
  outcome->reached = time;
}

/// Warnings about the accuracy of steps, or nothing. How many parts a step is cut into is none, nor is what a mesh or
/// a material's law is not good for.
std::string doubts(const World& world) {
  std::string text;
  const std::vector<std::string>& notes = world.model().notes;
  for (const std::string& warning : world.snapshot().warnings) {
    const bool of_parts = warning.find("to stay stable") != std::string::npos;
    const bool of_law = warning.find("material law holds for") != std::string::npos;
    const bool of_model = std::find(notes.begin(), notes.end(), warning) != notes.end();
    if (of_parts || of_law || of_model) continue;
    text += (text.empty() ? "" : "; ") + warning;
  }
  return text;
}

}  // namespace

int quarter_steps(double dt) {
  const double wanted = std::ceil(kSeconds / (kQuarters * dt) - 1e-9);
  return static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMostSteps / kQuarters)));
}

double instant(double dt, int k) {
  return dt * quarter_steps(dt) * k;
}

std::string class_text(Class verdict) {
  switch (verdict) {
    case Class::kRight:
      return "right";
    case Class::kWrong:
      return "wrong";
    case Class::kDiverged:
      return "diverged";
    case Class::kRefused:
      return "refused";
    case Class::kSlow:
      return "slow";
    case Class::kUnknown:
      break;
  }
  return "unknown";
}

Outcome run_scheme(const Subject& subject, const std::string& integrator, const SolverSettings& settings, double dt,
                   const Reference& reference, double most) {
  Outcome outcome;
  const Patience patience(most);
  try {
    const std::unique_ptr<Integrator> scheme = make_integrator(integrator, settings);
    check_scheme(*scheme, *subject.model);
    Plain plain(subject, scheme->needs().jacobian);
    Judge judge(subject, reference, dt);
    const int quarter = quarter_steps(dt);
    const int steps = std::max(kQuarters * quarter, scheme->needs().jacobian ? kBoundedImplicit : kBoundedExplicit);
    for (int k = 1; k <= steps; ++k) {
      const StepReport report = plain.step(scheme.get(), dt);
      if (!judge.bounded(plain.state.x)) {
        diverged(&outcome, k * dt);
        outcome.says = !report.converged;
        break;
      }
      const bool compared = k <= kQuarters * quarter;
      if (compared && !report.converged) outcome.says = true;
      if (compared && k % quarter == 0) judge.compare(plain.state.x, k / quarter);
      if (patience.is_over(k)) {
        too_slow(&outcome, k * dt);
        break;
      }
      outcome.reached = k * dt;
    }
    if (outcome.verdict == Class::kRight) judge.settle(&outcome);
    if (outcome.says) outcome.note = "not converged";
  } catch (const InputError& error) {
    outcome.verdict = Class::kRefused;
    outcome.error = kNotKnown;
    outcome.says = true;
    outcome.note = error.what();
  }
  outcome.cpu = patience.spent();
  return outcome;
}

Outcome run_world(const Subject& subject, const WorldSettings& settings, double expected, const Reference& reference,
                  double most) {
  Outcome outcome;
  const Patience patience(most);
  const double dt = settings.dt;
  if (!(expected <= kOnePercent)) {
    outcome.says = true;
    outcome.note = std::isnan(expected) ? "chosen: its error unknown" : "chosen: expects more than 1 %";
  }
  const auto remark = [&outcome](const std::string& text) {
    outcome.says = true;
    outcome.note = text;
  };
  try {
    std::vector<Collider> colliders;
    for (const ColliderSpec& collider : subject.spec.colliders) colliders.push_back(collider.collider);
    World world(subject.model, settings, std::move(colliders), grasps_of(subject.spec));
    Judge judge(subject, reference, dt);
    const int quarter = quarter_steps(dt), compared = kQuarters * quarter, steps = std::max(compared, kBoundedImplicit);
    for (int k = 1; k <= steps; ++k) {
      const StepOutcome step = world.step();
      if (!step.ok) {
        diverged(&outcome, k * dt);
        remark(step.message);
        break;
      }
      if (!judge.bounded(world.state().x)) {
        diverged(&outcome, k * dt);
        if (const std::string text = doubts(world); !text.empty()) remark(text);
        break;
      }
      if (k <= compared && (!step.report.converged || k % quarter == 0)) {
        if (const std::string text = doubts(world); !text.empty()) remark(text);
      }
      if (k <= compared && k % quarter == 0) judge.compare(world.state().x, k / quarter);
      // A step of 1e5 parts cannot be stopped; after it there is time enough lost.
      if (patience.is_over(k) || (k < compared && patience.is_over() && k % quarter == 0)) {
        too_slow(&outcome, k * dt);
        break;
      }
      if (k >= compared && patience.is_over()) break;
      outcome.reached = k * dt;
    }
    if (outcome.verdict == Class::kRight) judge.settle(&outcome);
  } catch (const InputError& error) {
    outcome.verdict = Class::kRefused;
    outcome.error = kNotKnown;
    remark(error.what());
  }
  outcome.cpu = patience.spent();
  return outcome;
}

}  // namespace deformable_sim::stability
