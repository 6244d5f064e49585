// Services that change the running scene, or a copy of it.
#include "deformable_sim/ros/commands.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/grasp_requests.h"
#include "serve.h"

namespace deformable_sim {

namespace {

bool is_given(const geometry_msgs::Quaternion& q) {
  return q.x != 0.0 || q.y != 0.0 || q.z != 0.0 || q.w != 0.0;
}

}  // namespace

void Services::advertise_changes() {
  servers_.push_back(
      serve<msg::LoadSceneRequest, msg::LoadSceneResponse>(nh_, "load_scene", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          changes_->load(q.file, q.yaml);
          return Status();
        });
        fill(status, &response->status);
      }));
  servers_.push_back(
      serve<msg::AddBodyRequest, msg::AddBodyResponse>(nh_, "add_body", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          std::optional<Pose> pose;
          if (is_given(q.pose.pose.orientation)) pose = to_world_pose(q.pose, "pose", frames_);
          response->bodies = changes_->add_bodies(q.file, q.yaml, pose);
          return Status();
        });
        fill(status, &response->status);
      }));
  servers_.push_back(
      serve<msg::RemoveBodyRequest, msg::RemoveBodyResponse>(nh_, "remove_body", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          changes_->remove_body(printable(q.body));
          return Status();
        });
        fill(status, &response->status);
      }));
  servers_.push_back(
      serve<msg::RolloutRequest, msg::RolloutResponse>(nh_, "rollout", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          rollouts_->run(q, response);
          return Status();
        });
        fill(status, &response->status);
      }));
  servers_.push_back(serve<msg::SetMaterialRequest, msg::SetMaterialResponse>(
      nh_, "set_material", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          changes_->set_material(printable(q.body), q.yaml);
          return Status();
        });
        fill(status, &response->status);
      }));
}

}  // namespace deformable_sim
