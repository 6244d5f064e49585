// The world's grasps: who holds which nodes, where to, and with what force.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/frame_motion.h"
#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/grasp/kinematics.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// Rigid grasps prescribe the motion of their nodes; soft ones (stiffness > 0) pull them with springs. A rigid grasp of
/// an end of a rod with twist clamps it: the end, its neighbour and the angle of the segment between them follow the
/// frame, as do the angles of all segments held at both ends; the wrench then includes the rod's twisting moment. The
/// angle is unwrapped: turning the frame turns the rod, any number of times, by less than half a turn a step.
///
/// Whenever the set of held nodes changes, take kinematics() and springs() anew.
class GraspSet {
 public:
  GraspSet(const Model* model, double default_max_speed) : model_(model), default_max_speed_(default_max_speed) {}

  /// Nodes taken, body-local. Throws InputError and changes nothing when the request cannot be met. A grasp that
  /// slipped may be taken again under its name.
  std::vector<int> add(const GraspRequest& request, const State& s);
  /// Note when max_speed does not allow that duration (or one step of dt); otherwise empty. Throws InputError.
  std::string move(const std::string& name, const Pose& target, double duration, double dt);
  void set_waiting(const std::string& name, bool waiting);
  /// Empty name = all, which may be none. Throws InputError (kNotFound) for a name that does not exist.
  void release(const std::string& name);
  /// Nodes of this body were put elsewhere: rigid grasps hold them where they are now. Returns whether any moved.
  bool hold_in_place(int body, const State& s);

  /// Grasps of bodies that `before` holds as well become those of there, as they are; `is_continued` says of which
  /// bodies of this model. Throws InputError (kAlreadyExists) where one of another body has the name of one of those.
  void continue_from(const GraspSet& before, const std::vector<char>& is_continued);

  bool empty() const { return grasps_.empty(); }
  /// Held nodes and angle columns, ascending; targets and reactions sized.
  Kinematics kinematics();
  std::vector<TargetSprings*> springs() const;

  /// Of soft grasps, J.
  double stored_energy(const State& s) const;
  /// Moves the frames on by dt from the state s and writes where held nodes have to be at its end.
  void advance(double dt, const State& s, Kinematics* kinematics);
  /// Start of a step: forgets the last wrenches.
  void clear_wrenches();
  /// Adds `fraction` of the wrench of the step just made (a step of n parts is measured n times with 1/n).
  void measure(const Kinematics& kinematics, const State& s, double fraction);
  /// Lets go of what pulls harder than allowed. Returns whether any grasp slipped.
  bool slip_overloaded();

  std::vector<GraspReport> reports() const;
  int held_count() const;

  /// Saved states.
  void pass(Archive* archive);

  /// Motions only, for repeating a step.
  void save_motions(std::vector<FrameMotion>* motions) const;
  void restore_motions(const std::vector<FrameMotion>& motions);

 private:
  /// A segment of a rod with twist whose ends are both held.
  struct HeldSegment {
    int segment;    // of State's frames
    size_t a, b;    // its ends, in Grasp::nodes
    Vec3 director;  // the first material director, in the grasp frame
    int slot;       // of its angle in Kinematics
  };
  struct Grasp {
    GraspRequest request;
    int body = 0;
    std::vector<int> nodes;  // world indices, ascending
    Nodes local;             // in the grasp frame
    double max_speed = 0.0;  // m/s
    double lever = 0.0;      // m, furthest held node from the grasp's origin
    FrameMotion motion{Pose::Identity()};
    GraspPhase phase = GraspPhase::kHolding;
    bool speed_limited = false;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    std::vector<int> slot;                   // of each node in Kinematics; rigid only
    std::vector<HeldSegment> segments;       // rigid only
    std::unique_ptr<TargetSprings> springs;  // soft only
    Nodes targets;                           // of the springs
  };

  void pass_grasp(Archive* archive, Grasp* grasp);
  void check_free_of_others(size_t which) const;
  void check_request(const GraspRequest& request) const;
  void check_free(const std::vector<int>& nodes, const std::string& taker) const;
  Grasp& find(const std::string& name);
  void find_segments(const State& s, Grasp* grasp) const;
  Vec3 material_director(const Grasp& grasp, int segment, const State& s) const;
  int angle_column(int segment) const { return model_->point_count() + segment; }

  const Model* model_;
  double default_max_speed_;
  std::vector<Grasp> grasps_;
};

/// What was asked for, in saved states and recorded commands. It is not checked.
void pass_request(Archive* archive, GraspRequest* request);

}  // namespace deformable_sim
