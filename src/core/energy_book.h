// The books of mechanical energy: what a world has, what was put into it, and what came from nowhere.
#pragma once

#include <array>
#include <limits>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// A step may lose energy, to damping and to its scheme; it must not make any. With K the kinetic and V the stored
/// energy, W the work of what moves from outside (grasps, colliders, wind),
///
///   K + V <= K0 + V0 + W.
///
/// Stored energy costs as much as a force, so every step is tested by its kinetic energy and weight alone, which
/// elastic energy, never negative, can only make stricter:
///
///   K + V_gravity <= (K0 + V0) + W since then + half of K + 0.02 J/kg of all mass
///
/// The last is what contact may lift bodies by to put them apart, 2 mm. A look takes all energies, every kLookSteps,
/// and the largest of the last kLooks, with what was done since, is what there may be: a symplectic scheme's energy
/// swings. What a look finds beyond is created().
///
/// Not good at: telling a slow gain from such swings; wind, whose work is only
/// estimated from look to look, so that nothing is called created while it blows.
class EnergyBook {
 public:
  static constexpr int kLookSteps = 16;
  static constexpr int kLooks = 4;

  /// The books begin anew: something was changed from outside.
  void begin();
  /// A step begins; it begins anew.
  void begin_step();
  void restart_step();

  /// Work of rigid grasps in a part of a step, in which x goes to where it ends: begins, ends.
  void begin_held(const Kinematics& kinematics, const Nodes& x);
  void end_held(const Kinematics& kinematics, const Nodes& x);
  /// Work of colliders that move, in a part of h (s).
  void add_colliders(const ContactConstraints& contacts, double h);
  void add(double work) { work_ += work; }
  /// Between two steps something that stores energy came, or went with what it stored.
  void change(double stored) {
    work_ += stored;
    at_end_ = kUnknown;
  }

  /// Whether the step that ended at `s` is possible, as far as weight and motion tell.
  bool is_possible(const Model& model, const State& s) const;
  /// Whether the look of has_gained() costs little beside the forces that were evaluated since the last of its kind,
  /// `evaluations` of them in the present step.
  bool is_look_cheap(int evaluations) const { return evaluations_ + evaluations >= kManyEvaluations; }
  /// Whether there is more energy of all kinds at `s`, where a step ends, than there was and was given since, by a
  /// share of what moves and is stored and `lift` (J/kg); for steps of which anything may come. "Was": where the step
  /// began, if that was asked then, but no more than at the last looks.
  bool has_gained(const Model& model, const Dynamics& d, const Energy* ignored, const State& s, double share,
                  double lift);
  /// The step is accepted: takes a look when it is time, at all energies of `d` but `ignored`, which stores none of its
  /// own; dt: of the step, s, in which forces were evaluated so many times.
  void end_step(const Model& model, const Dynamics& d, const Energy* ignored, const State& s, double dt,
                int evaluations);

  /// The next look is due.
  void hurry() { age_ = kLookSteps; }

  /// J, since the start and within about the last second.
  double created() const { return created_; }
  double created_lately() const { return lately_; }
  /// J: what moved, swung and was done at most within about the last second.
  double scale() const { return scale_; }
  void forget();
  /// Saved states.
  void pass(Archive* archive);

 private:
  static constexpr int kManyEvaluations = 16;
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  /// J, that there may be at the last look.
  double level() const;
  double last_level() const { return level_[static_cast<size_t>((looks_ - 1) % kLooks)]; }
  /// J/s of terms that store nothing.
  double power(const Dynamics& d, const State& s);

  int looks_ = 0;
  int age_ = 0;                                     // steps since the look
  std::array<double, kLooks> level_{};              // J, at the last looks, with what was done since the look after
  double drive_ = 0.0;                              // J/s, of wind, at the look
  double work_ = 0.0, work_before_ = 0.0;           // J since the look, and when the step began
  double allowed_ = 0.0;                            // J since the look, of wind
  double at_start_ = kUnknown, at_end_ = kUnknown;  // J, of the step, where has_gained() asked; else NaN
  int evaluations_ = 0;                             // of forces, since has_gained() was asked of an accepted step
  double mass_ = 0.0;                               // kg
  double created_ = 0.0, lately_ = 0.0, scale_ = 0.0;
  Nodes force_;
  Nodes held_;  // m, held columns of x when the part began
};

/// K = 1/2 v^T M v, J, and the weight's potential -sum m g . x, J.
struct MotionEnergy {
  double kinetic = 0.0, weight = 0.0;
};
MotionEnergy motion_energy(const Model& model, const State& s);

}  // namespace deformable_sim
