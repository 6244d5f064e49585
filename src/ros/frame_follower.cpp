#include "deformable_sim/ros/frame_follower.h"

#include <algorithm>
#include <utility>

#include <ros/console.h>

namespace deformable_sim {

namespace {

constexpr double kLongestPeriod = 0.2;  // s: slower transforms are followed in moves of this length
constexpr double kMissedPeriods = 3.0;  // a frame may skip some before it counts as lost

bool same(const Pose& a, const Pose& b) {
  return a.matrix() == b.matrix();
}

}  // namespace

FrameFollower::FrameFollower(const Frames& frames, Warnings* warnings) : frames_(frames), warnings_(warnings) {}

void FrameFollower::begin(const std::vector<Collider>& attached, const std::vector<GraspReport>& grasps) {
  remove(Kind::kGrasp, "");
  remove(Kind::kCollider, "");
  for (const Collider& collider : attached) {
    Follower follower;
    follower.kind = Kind::kCollider;
    follower.name = collider.name;
    follower.frame = collider.frame;
    follower.frame_from_part = collider.world_from_collider;
    follower.absent = collider;
    followers_.push_back(std::move(follower));
  }
  keep(grasps);
}

void FrameFollower::keep(const std::vector<GraspReport>& grasps) {
  std::vector<std::string> gone;
  for (const Follower& follower : followers_) {
    const auto is_it = [&](const GraspReport& grasp) { return grasp.name == follower.name; };
    if (follower.kind == Kind::kGrasp && std::none_of(grasps.begin(), grasps.end(), is_it))
      gone.push_back(follower.name);
  }
  for (const std::string& name : gone) remove(Kind::kGrasp, name);
  for (const GraspReport& grasp : grasps) {
    if (grasp.follow_frame.empty() || !frame_of(grasp.name).empty()) continue;
    Follower follower;
    follower.name = grasp.name;
    follower.frame = grasp.follow_frame;
    follower.world_from_part = grasp.world_from_grasp;
    followers_.push_back(std::move(follower));
  }
}

void FrameFollower::attach(const Collider& collider, const Pose& frame_from_collider) {
  Follower follower;
  follower.kind = Kind::kCollider;
  follower.name = collider.name;
  follower.frame = collider.frame;
  follower.frame_from_part = frame_from_collider;
  followers_.push_back(std::move(follower));
}

void FrameFollower::applied(const Command& command) {
  if (const auto* grasp = std::get_if<command::Grasp>(&command)) {
    if (grasp->request.follow_frame.empty()) return;
    Follower follower;
    follower.name = grasp->request.name;
    follower.frame = grasp->request.follow_frame;
    follower.frame_from_part = Pose::Identity();  // the grasp frame is the followed frame
    followers_.push_back(std::move(follower));
  } else if (const auto* release = std::get_if<command::Release>(&command)) {
    remove(Kind::kGrasp, release->name);
  } else if (const auto* removed = std::get_if<command::RemoveCollider>(&command)) {
    remove(Kind::kCollider, removed->name);
  }
}

void FrameFollower::remove(Kind kind, const std::string& name) {
  const auto gone = [&](const Follower& f) { return f.kind == kind && (name.empty() || f.name == name); };
  for (const Follower& follower : followers_) {
    if (gone(follower)) warnings_->clear("frame of " + follower.name);
  }
  followers_.erase(std::remove_if(followers_.begin(), followers_.end(), gone), followers_.end());
}

std::string FrameFollower::frame_of(const std::string& name) const {
  for (const Follower& follower : followers_) {
    if (follower.name == name) return follower.frame;
  }
  return "";
}

std::vector<std::string> FrameFollower::colliders() const {
  std::vector<std::string> names;
  for (const Follower& follower : followers_) {
    if (follower.kind == Kind::kCollider) names.push_back(follower.name);
  }
  return names;
}

void FrameFollower::pass(Archive* archive, const std::vector<Collider>& attached,
                         std::vector<Follower>* followers) const {
  archive->pass_each(followers, sizeof(Pose), [&](Follower* f) {
    bool placed = f->frame_from_part.has_value(), absent = f->absent.has_value();
    Pose frame_from_part = f->frame_from_part.value_or(Pose::Identity());
    archive->pass_enum(&f->kind, Kind::kCollider);
    archive->pass(&f->name);
    archive->pass(&f->frame);
    archive->pass(&placed);
    archive->pass(&frame_from_part);
    archive->pass(&f->world_from_part);
    archive->pass(&absent);
    archive->pass(&f->waiting);
    if (!archive->reads()) return;
    if (placed) f->frame_from_part = frame_from_part;
    if (!absent) return;
    // Only the scene's own wait for their frames outside the world.
    const auto given =
        std::find_if(attached.begin(), attached.end(), [f](const Collider& c) { return c.name == f->name; });
    if (given == attached.end()) Archive::refuse("of another robot: it has " + f->name);
    f->absent = *given;
  });
}

std::string FrameFollower::save() const {
  Archive archive;
  std::vector<Follower> followers = followers_;
  pass(&archive, {}, &followers);
  return archive.bytes();
}

std::vector<FrameFollower::Follower> FrameFollower::read(const std::string& bytes,
                                                         const std::vector<Collider>& attached) const {
  std::vector<Follower> followers;
  if (bytes.empty()) return followers;
  Archive archive(bytes);
  pass(&archive, attached, &followers);
  archive.end();
  return followers;
}

void FrameFollower::go_on_with(std::vector<Follower> followers) {
  remove(Kind::kGrasp, "");
  remove(Kind::kCollider, "");
  followers_ = std::move(followers);
}

void FrameFollower::update(World* world) {
  for (Follower& follower : followers_) {
    const auto pose = frames_.latest(follower.frame);
    const bool is_new = pose && (!follower.seen || pose->stamp != follower.last.stamp ||
                                 !same(pose->world_from_frame, follower.last.world_from_frame));
    if (is_new) take(*pose, world, &follower);
    if (!is_new) check_age(world, &follower);
  }
  report_unseen();
}

void FrameFollower::take(const FramePose& pose, World* world, Follower* follower) {
  const double dt = world->settings().dt;
  const double apart = follower->seen ? world->time() - follower->seen_at : dt;
  const double period = std::clamp(apart, dt, kLongestPeriod);
  follower->period = follower->seen ? 0.5 * (follower->period + period) : period;
  follower->seen = true;
  follower->seen_at = world->time();
  follower->seen_at_wall = Clock::now();
  follower->last = pose;
  if (!follower->frame_from_part) {
    follower->frame_from_part = pose.world_from_frame.inverse() * follower->world_from_part;
  }
  const Pose target = pose.world_from_frame * *follower->frame_from_part;
  if (follower->absent) {
    follower->absent->world_from_collider = target;
    follower->absent->frame_from_collider = *follower->frame_from_part;
    const Reply reply = world->apply(command::AddCollider{*follower->absent});
    follower->absent.reset();
    if (!reply.status.ok()) warnings_->set("frame of " + follower->name, follower->name + ": " + reply.status.message);
    return;
  }
  set_waiting(world, follower, false);
  if (follower->kind == Kind::kGrasp) {
    world->apply(command::MoveGrasp{follower->name, target, follower->period});
  } else {
    world->apply(command::MoveCollider{follower->name, target, follower->period});
  }
}

void FrameFollower::check_age(World* world, Follower* follower) {
  if (!follower->seen) {
    if (follower->kind == Kind::kGrasp) set_waiting(world, follower, true);
    return;
  }
  if (follower->last.stamp.isZero()) return;  // static
  // Lost only if both clocks say so: on demand, wall time passes between steps; as fast as possible, simulated time
  // flies.
  const double limit = frames_.timeout() + kMissedPeriods * follower->period;
  const double wall = std::chrono::duration<double>(Clock::now() - follower->seen_at_wall).count();
  const double simulated = world->time() - follower->seen_at;
  if (wall > limit && simulated > limit) set_waiting(world, follower, true);
}

void FrameFollower::set_waiting(World* world, Follower* follower, bool waiting) {
  if (waiting == follower->waiting) return;
  follower->waiting = waiting;
  if (follower->kind == Kind::kGrasp) world->apply(command::SetGraspWaiting{follower->name, waiting});
  const std::string key = "frame of " + follower->name;
  if (!waiting) {
    warnings_->clear(key);
    ROS_INFO_STREAM_THROTTLE_NAMED(1.0, "frames",
                                   "tf frame " << follower->frame << " is back: " << follower->name << " follows");
    return;
  }
  if (!follower->seen) return;  // said once for all by report_unseen()
  const std::string text = "tf frame " + follower->frame + " stopped arriving: " + follower->name + " holds still";
  warnings_->set(key, text);
  ROS_WARN_STREAM_THROTTLE_NAMED(1.0, "frames", text);
}

void FrameFollower::report_unseen() {
  std::string unseen;
  for (const Follower& follower : followers_) {
    if (!follower.seen) unseen += (unseen.empty() ? "" : ", ") + follower.frame;
  }
  if (unseen == unseen_) return;
  unseen_ = unseen;
  if (unseen.empty()) {
    warnings_->clear("unseen frames");
  } else {
    warnings_->set("unseen frames", "no transform yet to " + frames_.world_frame() + " from: " + unseen);
  }
}

}  // namespace deformable_sim
