// The shipped scenes of contact, played to their end.
#include <gtest/gtest.h>

#include <algorithm>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/script.h"
#include "support/crossings.h"
#include "support/folded_towel.h"

namespace deformable_sim::test {
namespace {

/// A shipped scene and its script.
class Show {
 public:
  explicit Show(const std::string& name, const std::vector<Override>& overrides = {})
      : spec_(load_scene_file(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/config/scenes/" + name + ".yaml", overrides)),
        world(build_world(spec_)),
        script_(spec_.script) {}

  /// Plays to `time`; nothing crosses, looked at every `look` steps.
  void run_to(double time, int look = 20) {
    while (world->time() < time - 1e-9) {
      const Reply reply = play(&script_, world.get());
      ASSERT_TRUE(reply.status.ok()) << reply.status.message;
      ASSERT_EQ(reply.note, "");
      const StepOutcome outcome = world->step();
      ASSERT_TRUE(outcome.ok) << outcome.message;
      if (world->step_count() % look == 0) {
        ASSERT_EQ(count_crossings(world->model(), world->state().x), 0) << world->time();
      }
    }
  }
  double fastest() const { return world->state().v.colwise().norm().maxCoeff(); }

 private:
  SceneSpec spec_;

 public:
  std::unique_ptr<World> world;

 private:
  Script script_;
};

TEST(ContactScenes, FoldTwiceLeavesFourLayersInOrderAtRest) {
  // The quarters lie on one another as they were laid down; nothing moves by a millimetre a second.
  Show show("fold_twice");
  ASSERT_NO_FATAL_FAILURE(show.run_to(6.5));
  int whole = 0;
  for (double px = -0.25; px < 0.1; px += 0.013) {
    for (double py = -0.3; py < 0.1; py += 0.013) {
      const std::vector<int> quarters = quarters_at(show.world->model(), show.world->state().x, px, py);
      EXPECT_TRUE(std::is_sorted(quarters.begin(), quarters.end())) << px << ", " << py;
      whole += quarters == std::vector<int>{0, 1, 2, 3} ? 1 : 0;
    }
  }
  EXPECT_GE(whole, 20);  // points 13 mm apart: 34 cm^2 or more of four layers
  EXPECT_LT(show.fastest(), 1e-3);
  // At rest the table carries what the towel weighs: 0.3 kg/m^2 x 0.16 m^2 x 9.81 m/s^2.
  Vec3 carried = Vec3::Zero();
  for (const ContactReport& contact : show.world->contact_reports()) {
    if (contact.collider >= 0) carried += contact.force;
  }
  EXPECT_NEAR(carried.norm(), 0.3 * 0.16 * 9.81, 0.01 * 0.3 * 0.16 * 9.81);
}

}  // namespace
}  // namespace deformable_sim::test
