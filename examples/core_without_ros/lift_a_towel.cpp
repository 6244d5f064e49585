// Lifts a towel by a corner and says what the hand feels: physics and scenes without ROS.
#include <cstdio>

#include <deformable_sim/core/error.h>
#include <deformable_sim/scene/build.h>
#include <deformable_sim/scene/load.h>

namespace sim = deformable_sim;

const char kScene[] = R"(
bodies:
  - cloth: {name: towel, size: [0.4, 0.4], cells: [16, 16], material: denim_11oz_black, pose: {position: [0, 0, 0.01]}}
colliders:
  - plane: {name: table}
)";

int main() {
  try {
    const std::unique_ptr<sim::World> world = sim::build_world(sim::load_scene_text(kScene, "towel"));
    sim::GraspRequest hand;
    hand.name = "hand";
    hand.body = "towel";
    hand.selection.method = sim::SelectionMethod::kFeature;
    hand.selection.feature = "corner_0";
    sim::Reply reply = world->apply(sim::command::Grasp{hand});
    if (reply.status.ok()) {
      reply = world->apply(sim::command::MoveGrasp{"hand", sim::Pose(Eigen::Translation3d(-0.2, -0.2, 0.7)), 2.0});
    }
    if (!reply.status.ok()) {
      std::fprintf(stderr, "%s\n", reply.status.message.c_str());
      return 1;
    }
    while (world->time() < 5.0) {
      const sim::StepOutcome step = world->step();
      if (!step.ok) {
        std::fprintf(stderr, "%s\n", step.message.c_str());
        return 1;
      }
    }
    const sim::Snapshot now = world->snapshot(sim::SnapshotDetail::kReports);
    const double weight = 9.81 * world->model().mass.sum();
    std::printf("after %.1f s the hand at %.2f m holds %.3f N of a towel that weighs %.3f N\n", now.time,
                now.grasps[0].world_from_grasp.translation().z(), -now.grasps[0].force.z(), weight);
    return 0;
  } catch (const sim::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
