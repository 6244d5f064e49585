#include "deformable_sim/core/grasp/grasp_set.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "deformable_sim/core/element/rod_frame.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/selection.h"
#include "deformable_sim/core/rod_frames.h"

namespace deformable_sim {
namespace {

void check_number(const std::string& who, const char* what, double value) {
  if (!std::isfinite(value) || value < 0.0) throw InputError(who + what + " must be a finite number >= 0");
}

double furthest(const Nodes& local) {
  return std::sqrt(local.colwise().squaredNorm().maxCoeff());
}

}  // namespace

void GraspSet::check_request(const GraspRequest& request) const {
  const std::string who = "grasp '" + request.name + "': ";
  if (request.name.empty()) throw InputError("a grasp needs a name");
  for (const Grasp& g : grasps_)
    if (g.request.name == request.name && g.phase != GraspPhase::kSlipped)
      throw InputError("a grasp named '" + request.name + "' exists; release it first or choose another name",
                       Code::kAlreadyExists);
  check_number(who, "max_force", request.max_force);
  check_number(who, "max_speed", request.max_speed);
  check_number(who, "stiffness", request.stiffness);
  if (request.has_frame && !is_valid_pose(request.world_from_grasp))
    throw InputError(who + "the pose must be finite, within 1e6 m, with a unit quaternion");
  if (model_->find_body(request.body) < 0) {
    std::string known;
    for (const Body& b : model_->bodies) known += (known.empty() ? "" : ", ") + b.name;
    throw InputError(who + "no body named '" + request.body + "'; there are: " + (known.empty() ? "none" : known),
                     Code::kNotFound);
  }
}

void GraspSet::check_free(const std::vector<int>& nodes, const std::string& taker) const {
  for (const Grasp& g : grasps_) {
    if (g.springs || g.phase == GraspPhase::kSlipped) continue;
    for (int node : nodes)
      if (std::binary_search(g.nodes.begin(), g.nodes.end(), node))
        throw InputError("grasp '" + taker + "': node " +
                             std::to_string(node - model_->bodies[static_cast<size_t>(g.body)].first_node) + " of '" +
                             g.request.body + "' is held by grasp '" + g.request.name + "'; release that first",
                         Code::kUnavailable);
  }
}

Vec3 GraspSet::material_director(const Grasp& grasp, int segment, const State& s) const {
  const Body& body = model_->bodies[static_cast<size_t>(grasp.body)];
  return material_frame(*model_, body, s, segment - body.first_segment).col(0);
}

void GraspSet::find_segments(const State& s, Grasp* grasp) const {
  const Body& body = model_->bodies[static_cast<size_t>(grasp->body)];
  if (body.first_segment < 0 || grasp->request.points_only) return;
  const auto held = [&](int node) {
    return std::lower_bound(grasp->nodes.begin(), grasp->nodes.end(), body.first_node + node);
  };
  for (int k = 0; k < body.line->segment_count(); ++k) {
    const auto [a, b] = body.line->segment(k);
    const auto at_a = held(a), at_b = held(b);
    if (at_a == grasp->nodes.end() || *at_a != body.first_node + a) continue;
    if (at_b == grasp->nodes.end() || *at_b != body.first_node + b) continue;
    const int segment = body.first_segment + k;
    const Mat3 grasp_from_world = grasp->motion.pose().linear().transpose();
    grasp->segments.push_back({segment, static_cast<size_t>(at_a - grasp->nodes.begin()),
                               static_cast<size_t>(at_b - grasp->nodes.begin()),
                               grasp_from_world * material_director(*grasp, segment, s), -1});
  }
}

std::vector<int> GraspSet::add(const GraspRequest& request, const State& s) {
  check_request(request);
  const Nodes& x = s.x;
  Grasp grasp;
  grasp.request = request;
  grasp.body = model_->find_body(request.body);
  const Body& body = model_->bodies[static_cast<size_t>(grasp.body)];
  std::vector<int> taken;
  try {
    taken = select_nodes(body, x, request.selection);
  } catch (const InputError& e) {
    throw InputError("grasp '" + request.name + "': " + e.what(), e.code());
  }
  if (request.stiffness == 0.0 && !request.points_only) taken = clamped_nodes(body, taken);
  for (int node : taken) grasp.nodes.push_back(body.first_node + node);
  check_free(grasp.nodes, request.name);

  const auto count = static_cast<Eigen::Index>(grasp.nodes.size());
  Nodes held(3, count);
  for (Eigen::Index i = 0; i < count; ++i) held.col(i) = x.col(grasp.nodes[static_cast<size_t>(i)]);
  Pose frame = Pose::Identity();
  if (request.has_frame) {
    frame = request.world_from_grasp;
  } else {
    frame.translation() = held.rowwise().mean();
  }
  grasp.motion = FrameMotion(frame);
  grasp.local = frame.inverse() * held;
  grasp.lever = furthest(grasp.local);
  grasp.max_speed = request.max_speed > 0.0 ? request.max_speed : default_max_speed_;
  if (request.stiffness > 0.0) {
    grasp.springs = std::make_unique<TargetSprings>(grasp.nodes, request.stiffness / static_cast<double>(count));
    grasp.springs->set_targets(held);
    grasp.targets = held;
  } else {
    find_segments(s, &grasp);
  }
  grasps_.erase(
      std::remove_if(grasps_.begin(), grasps_.end(), [&](const Grasp& g) { return g.request.name == request.name; }),
      grasps_.end());
  grasps_.push_back(std::move(grasp));
  return taken;
}

GraspSet::Grasp& GraspSet::find(const std::string& name) {
  std::string known;
  for (Grasp& g : grasps_) {
    if (g.request.name == name) return g;
    known += (known.empty() ? "" : ", ") + g.request.name;
  }
  throw InputError("no grasp named '" + name + "'; there are: " + (known.empty() ? "none" : known), Code::kNotFound);
}

std::string GraspSet::move(const std::string& name, const Pose& target, double duration, double dt) {
  Grasp& g = find(name);
  const std::string who = "grasp '" + name + "': ";
  if (!is_valid_pose(target)) throw InputError(who + "the target must be finite, within 1e6 m, with a unit quaternion");
  check_number(who, "duration", duration);
  if (g.phase == GraspPhase::kSlipped)
    throw InputError("grasp '" + name + "' has slipped and holds nothing; grasp again or release it",
                     Code::kUnavailable);
  g.motion.move_to(target, duration);
  if (g.phase == GraspPhase::kWaitingForFrame) return "holds still: it is waiting for its frame";
  const double way = FrameMotion::travel(g.motion.pose(), target, g.lever);
  if (way <= g.max_speed * std::max(duration, dt) * (1.0 + 1e-9)) return "";
  char note[160];
  std::snprintf(note, sizeof note, "rate-limited to %g m/s: the target is reached after %.3g s", g.max_speed,
                way / g.max_speed);
  return note;
}

void GraspSet::set_waiting(const std::string& name, bool waiting) {
  Grasp& g = find(name);
  if (g.phase == GraspPhase::kSlipped)
    throw InputError("grasp '" + name + "' has slipped and holds nothing; grasp again or release it",
                     Code::kUnavailable);
  g.phase = waiting ? GraspPhase::kWaitingForFrame : GraspPhase::kHolding;
  if (waiting) g.motion.stop();
}

void GraspSet::release(const std::string& name) {
  if (name.empty()) {
    grasps_.clear();
    return;
  }
  const Grasp* g = &find(name);
  grasps_.erase(grasps_.begin() + (g - grasps_.data()));
}

bool GraspSet::hold_in_place(int body, const State& s) {
  bool moved = false;
  for (Grasp& g : grasps_) {
    if (g.body != body || g.springs) continue;
    const Pose grasp_from_world = g.motion.pose().inverse();
    for (Eigen::Index i = 0; i < g.local.cols(); ++i) {
      const Vec3 now = s.x.col(g.nodes[static_cast<size_t>(i)]);
      // A node that is where it was keeps its place to the last bit: a state read and set back changes nothing.
      if ((g.motion.pose() * Vec3(g.local.col(i)) - now).norm() < 1e-9) continue;
      g.local.col(i) = grasp_from_world * now;
      moved = true;
    }
    if (g.local.cols() > 0) g.lever = furthest(g.local);
    for (HeldSegment& segment : g.segments) {
      const Vec3 now = grasp_from_world.linear() * material_director(g, segment.segment, s);
      if ((segment.director - now).norm() < 1e-9) continue;
      segment.director = now;
      moved = true;
    }
  }
  return moved;
}

Kinematics GraspSet::kinematics() {
  Kinematics k;
  for (const Grasp& g : grasps_) {
    if (g.springs) continue;
    k.node.insert(k.node.end(), g.nodes.begin(), g.nodes.end());
    for (const HeldSegment& segment : g.segments) k.node.push_back(angle_column(segment.segment));
  }
  std::sort(k.node.begin(), k.node.end());
  k.target = Nodes::Zero(3, static_cast<Eigen::Index>(k.node.size()));
  k.reaction = k.target;
  for (Grasp& g : grasps_) {
    g.slot.clear();
    if (g.springs) continue;
    const auto slot_of = [&k](int column) {
      return static_cast<int>(std::lower_bound(k.node.begin(), k.node.end(), column) - k.node.begin());
    };
    for (int node : g.nodes) g.slot.push_back(slot_of(node));
    for (HeldSegment& segment : g.segments) segment.slot = slot_of(angle_column(segment.segment));
  }
  return k;
}

std::vector<TargetSprings*> GraspSet::springs() const {
  std::vector<TargetSprings*> springs;
  for (const Grasp& g : grasps_)
    if (g.springs && g.phase != GraspPhase::kSlipped) springs.push_back(g.springs.get());
  return springs;
}

double GraspSet::stored_energy(const State& s) const {
  double sum = 0.0;
  for (const Grasp& g : grasps_)
    if (g.springs && g.phase != GraspPhase::kSlipped) sum += g.springs->value(s);
  return sum;
}

void GraspSet::advance(double dt, const State& s, Kinematics* kinematics) {
  for (Grasp& g : grasps_) {
    if (g.phase == GraspPhase::kSlipped) continue;
    g.speed_limited = false;
    if (g.phase == GraspPhase::kHolding) g.speed_limited = !g.motion.advance(dt, g.max_speed, g.lever);
    if (g.springs) {
      g.targets.noalias() = g.motion.pose().linear() * g.local;
      g.targets.colwise() += g.motion.pose().translation();
      g.springs->set_targets(g.targets);
    } else {
      for (size_t i = 0; i < g.slot.size(); ++i)
        kinematics->target.col(g.slot[i]) = g.motion.pose() * Vec3(g.local.col(static_cast<Eigen::Index>(i)));
      for (const HeldSegment& held : g.segments) {
        const Vec3 edge = kinematics->target.col(g.slot[held.b]) - kinematics->target.col(g.slot[held.a]);
        const Vec3 before = s.tangents.col(held.segment), tangent = RodSegment(edge, before).tangent;
        const Vec3 reference = transported(s.directors.col(held.segment), before, tangent);
        const double radius = model_->bodies[static_cast<size_t>(g.body)].radius_of_gyration;
        const double now = s.x(0, angle_column(held.segment)) / radius;
        const double angle = unwrapped(angle_about(tangent, reference, g.motion.pose().linear() * held.director), now);
        kinematics->target.col(held.slot) = Vec3(radius * angle, 0.0, 0.0);
      }
    }
  }
}

void GraspSet::clear_wrenches() {
  for (Grasp& g : grasps_) {
    g.force.setZero();
    g.torque.setZero();
  }
}

void GraspSet::measure(const Kinematics& kinematics, const State& s, double fraction) {
  for (Grasp& g : grasps_) {
    if (g.phase == GraspPhase::kSlipped) continue;
    const Vec3 origin = g.motion.pose().translation();
    for (size_t i = 0; i < g.nodes.size(); ++i) {
      const Vec3 x = s.x.col(g.nodes[i]);
      // What the body does to the gripper: minus what holds the node.
      const Vec3 force = g.springs ? Vec3(g.springs->stiffness() * (x - g.targets.col(static_cast<Eigen::Index>(i))))
                                   : Vec3(-kinematics.reaction.col(g.slot[i]));
      g.force += fraction * force;
      g.torque += fraction * (x - origin).cross(force);
    }
    for (const HeldSegment& held : g.segments) {
      const double moment =
          model_->bodies[static_cast<size_t>(g.body)].radius_of_gyration * kinematics.reaction(0, held.slot);
      g.torque -= fraction * moment * s.tangents.col(held.segment);
    }
  }
}

bool GraspSet::slip_overloaded() {
  bool slipped = false;
  for (Grasp& g : grasps_) {
    if (g.phase == GraspPhase::kSlipped || g.request.max_force <= 0.0 || g.force.norm() <= g.request.max_force)
      continue;
    g.phase = GraspPhase::kSlipped;
    g.motion.stop();
    g.speed_limited = false;
    g.nodes.clear();
    g.slot.clear();
    g.segments.clear();
    g.local.resize(3, 0);
    slipped = true;
  }
  return slipped;
}

std::vector<GraspReport> GraspSet::reports() const {
  std::vector<GraspReport> reports;
  for (const Grasp& g : grasps_) {
    GraspReport r;
    r.name = g.request.name;
    r.body = g.request.body;
    r.follow_frame = g.request.follow_frame;
    for (int node : g.nodes) r.nodes.push_back(node - model_->bodies[static_cast<size_t>(g.body)].first_node);
    r.phase = g.phase;
    r.world_from_grasp = g.motion.pose();
    r.force = g.force;
    r.torque = g.torque;
    r.load = g.request.max_force > 0.0 ? g.force.norm() / g.request.max_force : 0.0;
    r.speed_limited = g.speed_limited;
    reports.push_back(std::move(r));
  }
  return reports;
}

int GraspSet::held_count() const {
  int count = 0;
  for (const Grasp& g : grasps_) count += static_cast<int>(g.nodes.size());
  return count;
}

void GraspSet::save_motions(std::vector<FrameMotion>* motions) const {
  motions->clear();
  for (const Grasp& g : grasps_) motions->push_back(g.motion);
}

void GraspSet::restore_motions(const std::vector<FrameMotion>& motions) {
  for (size_t i = 0; i < grasps_.size(); ++i) grasps_[i].motion = motions[i];
}

}  // namespace deformable_sim
