#include <algorithm>
#include <utility>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/grasp_set.h"

namespace deformable_sim {

void GraspSet::continue_from(const GraspSet& before, const std::vector<char>& is_continued) {
  const auto continued = [&](const Grasp& g) {
    const int body = model_->find_body(g.request.body);
    return body >= 0 && is_continued[static_cast<size_t>(body)] != 0;
  };
  std::vector<Grasp> kept;
  for (const Grasp& old : before.grasps_) {
    if (!continued(old)) continue;
    Grasp grasp;
    grasp.request = old.request;
    grasp.body = model_->find_body(old.request.body);
    const Body& there = before.model_->bodies[static_cast<size_t>(old.body)];
    const Body& here = model_->bodies[static_cast<size_t>(grasp.body)];
    for (const int node : old.nodes) grasp.nodes.push_back(node - there.first_node + here.first_node);
    grasp.local = old.local;
    grasp.max_speed = old.max_speed;
    grasp.lever = old.lever;
    grasp.motion = old.motion;
    grasp.phase = old.phase;
    grasp.speed_limited = old.speed_limited;
    grasp.force = old.force;
    grasp.torque = old.torque;
    grasp.segments = old.segments;
    for (HeldSegment& held : grasp.segments) held.segment += here.first_segment - there.first_segment;
    grasp.targets = old.targets;
    if (old.springs) {
      grasp.springs = std::make_unique<TargetSprings>(grasp.nodes, old.springs->stiffness());
      grasp.springs->set_targets(old.targets);
    }
    kept.push_back(std::move(grasp));
  }
  for (Grasp& mine : grasps_) {
    if (continued(mine)) continue;
    for (const Grasp& grasp : kept)
      if (grasp.request.name == mine.request.name)
        throw InputError("a grasp named '" + mine.request.name + "' holds '" + grasp.request.body +
                             "'; release it first or choose another name",
                         Code::kAlreadyExists);
  }
  for (Grasp& mine : grasps_)
    if (!continued(mine)) kept.push_back(std::move(mine));
  grasps_ = std::move(kept);
}

}  // namespace deformable_sim
