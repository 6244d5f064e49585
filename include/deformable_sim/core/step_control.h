// How long the parts of a step may be: to hold an error, or a budget of time.
#pragma once

#include <string>

#include "deformable_sim/core/archive.h"

namespace deformable_sim {

/// What decides in how many parts a step is taken.
enum class StepControl { kFixed, kError, kBudget };

struct StepControlSettings {
  StepControl control = StepControl::kFixed;
  double error = 0.01;  // of the positions after a second, RMS, relative to the size of the bodies
  double budget = 0.8;  // CPU s per simulated s; kBudget
  double floor = 0.1;   // error up to which it may give way to the budget; kBudget
};

/// Step doubling: now and then a step is made twice, in p parts and in 2 p. A scheme of order q whose error is C h^q a
/// second has made
///
///   e = sqrt(|x_p - x_2p|^2 + T^2 |v_p - v_2p|^2) / (1 - 2^-q) / (size dt)
///
/// of it with p, T = 0.2 s standing for how long an error of velocity is carried along, and p (e / error)^(1/q) parts
/// are as many as are needed [Hairer, Norsett & Wanner 1993, II.4]. Errors of one step are taken to add up over a
/// second, which is the worst that they can do where motion is damped.
///
/// kBudget: as many parts as the error asks for, while the time that they take is in the budget, and never so few that
/// the error passes the floor: then the budget is not held, which complaint() tells. What a step takes is
/// measured, so that two runs need not be alike; the other two are.
///
/// Not good at: seeing what both have wrong alike (a residual that Newton leaves, a mesh too coarse); motion that is
/// chaotic, whose errors grow.
class StepController {
 public:
  static constexpr int kMostParts = 64;

  explicit StepController(const StepControlSettings& settings) : settings_(settings) {}
  /// From now on, from the parts that steps are taken in.
  void set(const StepControlSettings& settings) { settings_ = settings; }

  /// Parts of the next step.
  int parts() const { return parts_; }
  /// Whether the next step is to be made twice, in parts() and in 2 parts().
  bool is_check_due() const { return since_check_ >= kCheckEvery; }
  /// Something was changed from outside, or a step had to be repeated: look again soon.
  void hurry() { since_check_ = kCheckEvery; }

  static constexpr double kCarried = 0.2;  // T, s

  /// A step of dt (s) was made twice; difference: the root above, RMS over nodes, relative to the bodies' size.
  void checked(double difference, double dt, int order);
  /// A step was made; cost: CPU s per simulated s as far as measured, 0: not measured.
  void stepped(double cost);

  const StepControlSettings& settings() const { return settings_; }
  /// Error after a second at the present parts, relative, as last estimated.
  double error() const { return error_; }
  /// Saved states.
  void pass(Archive* archive);
  /// What cannot be held, empty: all that was asked for is.
  std::string complaint() const;

 private:
  static constexpr int kCheckEvery = 8;  // steps

  void choose();

  StepControlSettings settings_;
  int parts_ = 1;
  int wanted_ = 1;  // by the error alone
  int least_ = 1;   // by the floor
  int affordable_ = kMostParts;
  int since_check_ = kCheckEvery;
  double error_ = 0.0;  // at parts_
  double cost_ = 0.0;   // CPU s per simulated s at parts_
};

}  // namespace deformable_sim
