// One cell of the map: a run, how far it is from the converged solution, and what that makes of it.
#pragma once

#include <array>
#include <map>
#include <string>

#include "deformable_sim/scene/solver_choice.h"
#include "stability_subject.h"

namespace deformable_sim::stability {

constexpr double kOnePercent = 0.01;  // error up to which a run is right
constexpr double kSeconds = 0.5;      // simulated, s, at least four steps and at most kMostSteps
constexpr int kMostSteps = 500;       // whose result is compared
constexpr int kQuarters = 4;          // instants at which it is
constexpr double kLongest = 2.0;      // s, the longest step

/// Steps to each quarter of a run.
int quarter_steps(double dt);
/// The instant (s) after quarter k = 1 ... 4.
double instant(double dt, int k);

/// The solution everything is compared with: rk4, where half a step of its limit gets through in time, else tr_bdf2
/// with a banded or direct factor and Newton's method down to rounding; steps that grow with the time.
/// Solved twice, the second time in steps half as long; how far the two are apart is what it is uncertain by.
class Reference {
 public:
  /// `dts`: steps (s) whose instants will be asked for. most: CPU s for both.
  Reference(const Subject& subject, const std::vector<double>& dts, double most);

  struct Instant {
    Nodes x;                 // m
    double uncertain = 0.0;  // m, RMS
  };
  /// Null: it was not reached, or is not finite.
  const Instant* at(double time) const;
  /// m, the furthest that any node got from where it started.
  double furthest() const { return furthest_; }
  const std::string& method() const { return method_; }

 private:
  bool solve(const Subject& subject, int finer, double most, std::map<double, Instant>* solution);
  std::map<double, Instant> instants_;
  double furthest_ = 0.0;
  std::string method_;
};

/// kRight within 1 %; kWrong bounded, but further off; kDiverged no finite or bounded state; kRefused the input was
/// refused; kSlow stopped, too dear; kUnknown bounded, and no reference to compare with.
enum class Class { kRight, kWrong, kDiverged, kRefused, kSlow, kUnknown };
std::string class_text(Class verdict);

struct Outcome {
  Class verdict = Class::kRight;
  /// RMS distance from the reference, largest of the quarters, over the body's size, or over how far it would have
  /// fallen by the end of the run, g t^2 / 2, where that is less. NaN: not known.
  double error = 0.0;
  bool says = false;     // by itself, that it may not be right
  std::string note;      // what it says, or why it was refused
  double cpu = 0.0;      // s
  double reached = 0.0;  // simulated s
};

/// A scheme by itself, in steps of dt as they are. Bounded: for four hundred steps (explicit) or sixty.
/// most: CPU s. It says something where a compared step was not converged.
Outcome run_scheme(const Subject& subject, const std::string& integrator, const SolverSettings& settings, double dt,
                   const Reference& reference, double most);

/// The world as users get it. expected: the error that the choice of a solver expects; above 1 %, or NaN where nothing
/// like the scene was measured, `chosen` says so; 0: it was not asked. Warnings of substeps are no such saying.
Outcome run_world(const Subject& subject, const WorldSettings& settings, double expected, const Reference& reference,
                  double most);

}  // namespace deformable_sim::stability
