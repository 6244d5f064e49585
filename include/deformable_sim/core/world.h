// The simulation: a model, a state, grasps and colliders, advanced step by step.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/command.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/model.h"
#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/core/step_control.h"

namespace deformable_sim {

constexpr double kLeastStep = 1e-9, kLongestStep = 2.0;  // s, allowed; not wise

struct WorldSettings {
  double dt = 0.01;  // s, one step
  int parts = 1;     // that a step is taken in, at least; with a control other than kFixed it decides
  StepControlSettings control;
  std::string integrator = "implicit_euler";
  SolverSettings solver;
  std::string chosen;               // why these, where the scene left it open; shown to people
  double grasp_max_speed = 1.0;     // m/s, for grasps that name none
  double collider_max_speed = 5.0;  // m/s, faster moves are spread over steps
  bool may_start_crossed = false;   // of a world that is to continue_from() another: Reset is refused where it does
  int threads = 1;                  // 1 ... Workers::kMost; the bits of a result do not depend on it
};

/// One line of the bill: a part the scene pays for.
struct BillItem {
  std::string part;
  std::string detail;  // for example "7062 springs"
  double share = 0.0;  // of the step time so far, 0..1
};

struct StepOutcome {
  bool ok = true;       // false: no finite state even with smaller steps; the world stays at its last good state
  std::string message;  // why not
  StepReport report;
};

/// Throws InputError naming what the scheme cannot do with the model: consistent masses, or terms it does not know.
void check_scheme(const Integrator& scheme, const Model& model);

/// Owns everything that changes. One thread at a time. The same model, commands and step count give the same bits.
class World {
 public:
  World(std::shared_ptr<const Model> model, WorldSettings settings, std::vector<Collider> colliders,
        std::vector<GraspRequest> grasps);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Advances by settings().dt: prescribe grasps and colliders, find contacts, integrate, measure wrenches.
  StepOutcome step();
  /// Applies one command between steps. A refusal changes nothing.
  Reply apply(const Command& command);

  /// `applied` hears, at once, of every command that was not refused; null: nobody does.
  void watch(std::function<void(const Command&)> applied);

  /// From now on, until the world is reset. Throws InputError.
  void set_control(const StepControlSettings& control);
  /// Everything that changes, as bytes: time, motion, grasps, colliders, and what friction, contact and the scheme
  /// remember. A world of the same scene that restores them goes on to the same bits as this one, in this process or
  /// another on the same kind of processor, with any number of threads. What is kept only to be quicker (factors, which
  /// pieces are near) is made anew by both: a world that was never saved goes on alike within its solver's tolerance.
  std::string save();
  /// The same bytes, of a world that goes on as if they had not been taken. A world that restores them goes on as this
  /// one within its solver's tolerance.
  std::string copy() const;
  /// Throws InputError and changes nothing: bytes that save() did not write, or a world of another scene or solver.
  void restore(const std::string& bytes);

  /// Takes over what another world with the same dt has come to: its time, its colliders and, of every body that both
  /// have with as many nodes, motion and grasps, which replace those this world began with. Bodies that only this one
  /// has start now. What friction remembers stays where both have the same bodies; else it begins anew, and what rests
  /// may creep by 20 um. `before` stays as it is. Throws InputError and changes nothing where a new body crosses
  /// another (kUnavailable), or brings a grasp whose name is in use.
  void continue_from(World& before);

  double time() const;
  std::uint64_t step_count() const;
  const State& state() const;
  const Model& model() const;
  std::shared_ptr<const Model> shared_model() const;
  const WorldSettings& settings() const;
  /// kMotion leaves out the bodies' energies and strains, which cost about as much as the forces, cost and warnings.
  Snapshot snapshot(SnapshotDetail detail = SnapshotDetail::kReports) const;
  /// Of the snapshot, the grasps alone.
  std::vector<GraspReport> grasp_reports() const;
  /// Contacts that carried a force in the last step, in the order of colliders and points. Not part of snapshot().
  std::vector<ContactReport> contact_reports() const;
  std::vector<BillItem> bill() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  std::function<void(const Command&)> applied_;
};

}  // namespace deformable_sim
