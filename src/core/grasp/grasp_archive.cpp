// Grasps in saved states.
#include <algorithm>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/grasp_set.h"

namespace deformable_sim {
void pass_request(Archive* archive, GraspRequest* request) {
  Selection& selection = request->selection;
  archive->pass(&request->name);
  archive->pass(&request->body);
  archive->pass_enum(&selection.method, SelectionMethod::kFeature);
  archive->pass(&selection.world_from_selection);
  archive->pass(&selection.radius);
  archive->pass(&selection.size);
  archive->pass(&selection.nodes);
  archive->pass(&selection.feature);
  archive->pass(&request->has_frame);
  archive->pass(&request->world_from_grasp);
  archive->pass(&request->max_force);
  archive->pass(&request->max_speed);
  archive->pass(&request->stiffness);
  archive->pass(&request->points_only);
  archive->pass(&request->follow_frame);
}

void GraspSet::pass_grasp(Archive* archive, Grasp* grasp) {
  archive->pass(&grasp->nodes);
  archive->pass(&grasp->local);
  archive->pass(&grasp->max_speed);
  archive->pass(&grasp->lever);
  grasp->motion.pass(archive);
  archive->pass_enum(&grasp->phase, GraspPhase::kWaitingForFrame);
  archive->pass(&grasp->speed_limited);
  archive->pass(&grasp->force);
  archive->pass(&grasp->torque);
  archive->pass_each(&grasp->segments, sizeof(Vec3), [&](HeldSegment* held) {
    auto a = static_cast<std::uint64_t>(held->a), b = static_cast<std::uint64_t>(held->b);
    archive->pass(&held->segment);
    archive->pass(&a);
    archive->pass(&b);
    archive->pass(&held->director);
    if (held->segment < 0 || held->segment >= model_->angle_count || std::max(a, b) >= grasp->nodes.size())
      Archive::refuse("a grasp of a segment that is not there");
    held->a = static_cast<size_t>(a);
    held->b = static_cast<size_t>(b);
  });
  double per_node = grasp->springs ? grasp->springs->stiffness() : 0.0;
  archive->pass(&per_node);
  archive->pass(&grasp->targets);
  if (!archive->reads()) return;
  const Body& body = model_->bodies[static_cast<size_t>(grasp->body)];
  const auto strange = [&body](int node) {
    return node < body.first_node || node >= body.first_node + body.node_count;
  };
  if (std::any_of(grasp->nodes.begin(), grasp->nodes.end(), strange) ||
      std::adjacent_find(grasp->nodes.begin(), grasp->nodes.end(), std::greater_equal<>()) != grasp->nodes.end() ||
      static_cast<size_t>(grasp->local.cols()) != grasp->nodes.size() || grasp->max_speed <= 0.0 || per_node < 0.0)
    Archive::refuse("grasp '" + grasp->request.name + "' holds what is not there");
  if (per_node == 0.0) return;
  if (grasp->phase != GraspPhase::kSlipped && grasp->targets.cols() != grasp->local.cols())
    Archive::refuse("grasp '" + grasp->request.name + "' holds what is not there");
  grasp->springs = std::make_unique<TargetSprings>(grasp->nodes, per_node);
  grasp->springs->set_targets(grasp->targets);
}

void GraspSet::pass(Archive* archive) {
  const size_t count = archive->pass_count(grasps_.size(), sizeof(Pose));
  if (archive->reads()) grasps_.clear();
  for (size_t k = 0; k < count; ++k) {
    GraspRequest request = archive->reads() ? GraspRequest() : grasps_[k].request;
    pass_request(archive, &request);
    if (archive->reads()) {
      check_request(request);
      grasps_.emplace_back();
      grasps_[k].request = request;
      grasps_[k].body = model_->find_body(request.body);
    }
    pass_grasp(archive, &grasps_[k]);
    if (archive->reads() && !grasps_[k].springs) check_free_of_others(k);
  }
}

/// No two rigid grasps hold one node.
void GraspSet::check_free_of_others(size_t which) const {
  for (size_t k = 0; k < which; ++k) {
    if (grasps_[k].springs) continue;
    for (const int node : grasps_[which].nodes)
      if (std::binary_search(grasps_[k].nodes.begin(), grasps_[k].nodes.end(), node))
        Archive::refuse("grasps '" + grasps_[k].request.name + "' and '" + grasps_[which].request.name +
                        "' hold one node");
  }
}

}  // namespace deformable_sim
