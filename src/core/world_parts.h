// What a World owns, shared by the files that implement it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/body_contacts.h"
#include "deformable_sim/core/contact/collider_set.h"
#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/grasp/grasp_set.h"
#include "deformable_sim/core/parallel/workers.h"
#include "deformable_sim/core/step_control.h"
#include "deformable_sim/core/strain_limit.h"
#include "deformable_sim/core/world.h"
#include "energy_book.h"

namespace deformable_sim {

constexpr int kMaxParts = 100000;  // of a step

/// Thread CPU seconds by part, of the window being filled and of the last full one.
struct CostWindow {
  static constexpr int kSteps = 50;
  double assembly = 0.0, solve = 0.0, integrate = 0.0, limits = 0.0, contact = 0.0, meetings = 0.0, grasps = 0.0;
  int steps = 0;
  double total() const { return integrate + limits + contact + meetings + grasps; }
};

/// Worlds smaller than this ask for the time in one step of kTimedSteps only: with some 0.2 us each, asking would be a
/// third of what a short rope costs.
constexpr int kSmallWorld = 300;  // nodes
constexpr int kTimedSteps = 8;
constexpr double kRemembered = 1.0;  // s of simulated time for which what went wrong in a step is told

struct World::Parts {
  Parts(std::shared_ptr<const Model> shared_model, WorldSettings world_settings, std::vector<Collider> colliders,
        std::vector<GraspRequest> grasps);

  // What the world was made of.
  std::shared_ptr<const Model> model;
  WorldSettings settings;
  std::vector<Collider> initial_colliders;
  std::vector<GraspRequest> initial_grasps;

  // What changes.
  State state;
  std::uint64_t step_count = 0;
  std::unique_ptr<Workers> workers;  // only for more threads than one
  std::unique_ptr<Integrator> integrator;
  BlockMatrix pattern;                     // empty for schemes without a Jacobian; see make_pattern()
  std::unique_ptr<StrainLimiter> limiter;  // only where the model has strain limits
  Dynamics dynamics;
  GraspSet grasps;
  ColliderSet colliders;
  std::unique_ptr<ContactFinder> contacts;  // only while there is a collider
  Eigen::VectorXd inverse_mass;             // 1/kg, 0 at held nodes; only with meetings
  std::unique_ptr<BodyContacts> meetings;   // only where bodies may touch one another, or themselves
  std::vector<PoseStep> collider_steps;     // of the last part of a step
  std::vector<NodeRole> roles;              // per node

  // Of the last step.
  StepReport report;
  std::vector<std::string> identity;  // for saved states; found when one is first written or read
  int substeps = 1;
  int refinements = 0;       // how often the last step was begun anew in shorter parts
  bool last_resort = false;  // step_safely() is at work
  double max_penetration = 0.0;
  double violation = 0.0;      // m, of the worst contact in any part of the step
  bool makes_energy = false;   // so it seems: see EnergyBook::is_possible()
  std::uint64_t repeated = 0;  // steps that were begun anew, since the start
  // The step from which on what sinks into colliders is got out: not what was put or left there.
  std::uint64_t sunk_until = 0;
  double safe_until = 0.0;  // s: until when it is told that the safe scheme had to make a step
  EnergyBook book;
  std::unique_ptr<StepController> controller;  // only where the parts of steps are not fixed
  std::string failure;                         // why the last step could not be made
  double excess = 0.0;                         // over the worst strain limit, relative, after the projection
  bool limits_met = true;
  bool timed = true;  // the present step
  CostWindow cost, last_cost;
  std::vector<int> body_of_energy;  // of the model's; found when energies are first reported

  // Largest stable step of an explicit scheme, s, and how many steps ago it was measured; infinite for implicit ones.
  double stable_dt = 0.0;
  int stable_dt_age = 0;

  // To repeat a step.
  State good_state, part_state;
  Nodes coarse_x, coarse_v;  // of step_twice()
  std::vector<FrameMotion> good_grasps, good_colliders;

  std::string start_crosses;  // bodies that may touch, where they start; empty: none

  /// What the schemes' matrices are made of, as far as this scene needs any.
  void make_pattern();
  /// Throws InputError where bodies that may not cross do from the start.
  void make_meetings();
  void set_control(const StepControlSettings& control);
  /// Initial state, colliders and grasps. Throws InputError.
  void start();
  /// After grasps came or went; stored: by soft ones before, J.
  void held_nodes_changed(double stored);
  /// The terms of the forces, which nodes are held, and what depends on the scheme.
  void bind_terms();
  void colliders_changed();

  /// Thread CPU time, s; 0 in a step that is not timed.
  double clock() const;
  void keep_last_good();
  void restore_last_good();
  bool step_in_parts();
  bool step_twice();
  bool step_safely(double depth);
  /// m, that the deepest point is inside a collider, 0: none, with the planes of the last part.
  double depth_of_state();
  bool step_somehow();
  void accept_step();
  std::string refuse_step();
  std::string turned_by_grasps();
  void add_report(const StepReport& part);
  /// One step in `parts` equal parts. False when the state left the finite world.
  bool try_step(int parts);
  /// Prescribes, finds contacts, integrates, measures: one part of a step, h seconds. before: where it starts, for
  /// contacts to begin again from. False when the state left the finite world.
  bool advance(double h, double fraction, const State& before);
  /// Finds contacts and integrates, again with a wider reach while some node moved further than was looked for.
  bool integrate_with_contacts(double h, const State& before);
  /// After a part of a step from `before`: nothing has crossed, or the step is made again.
  void keep_bodies_apart(double h, const State& before);
  void prescribe(double h);
  void integrate(double h);
  void limit_strain(double h);
  bool state_is_sane() const;
  bool unsound_step_gains();
  bool is_shortest() const;
  /// A finite step that had better be made again in shorter parts; `refinement` = how often that was done.
  bool is_poor(int refinement) const;
  /// Parts that this step needs: 1, or more for an explicit scheme past its stability limit.
  int wanted_parts();
  /// Saved states. Throws InputError; what was read up to then stays.
  void pass(Archive* archive);
  std::vector<std::string> warnings() const;
  /// Elastic energies of the bodies.
  void add_elastic_energies(std::vector<BodyReport>* reports);
};

/// Thread CPU time, s.
double cpu_seconds();

}  // namespace deformable_sim
