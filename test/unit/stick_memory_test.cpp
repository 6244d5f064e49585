// What friction remembers from step to step.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/stick.h"
#include "deformable_sim/core/contact/stick_memory.h"

namespace deformable_sim {
namespace {

const Vec3 kA(1e-6, 0, 0), kB(0, 2e-6, 0), kC(0, 0, 3e-6);

TEST(StickMemory, KeepsOfADisplacementWhatFrictionHolds) {
  // In the plane, at most kStickGive long, in the direction it had.
  ContactConstraint c;
  c.normal = Vec3(0, 0.6, 0.8);
  const Vec3 tangent(0, 0.8, -0.6);
  EXPECT_LT((stick_remainder(c, 2e-6 * tangent + 0.5 * c.normal) - 2e-6 * tangent).norm(), 1e-15);
  EXPECT_LT((stick_remainder(c, 0.3 * tangent) - kStickGive * tangent).norm(), 1e-15);
}

TEST(StickMemory, RecallsByAscendingKey) {
  StickMemory memory;
  memory.store(3, kA);
  memory.store(7, Vec3::Zero());
  memory.store(9, kB);
  memory.end_part();
  for (int again = 0; again < 2; ++again) {
    memory.rewind();
    EXPECT_EQ(memory.recall(1), Vec3::Zero());
    EXPECT_EQ(memory.recall(3), kA);
    EXPECT_EQ(memory.recall(7), Vec3::Zero());
    EXPECT_EQ(memory.recall(9), kB);
    EXPECT_EQ(memory.recall(12), Vec3::Zero());
  }
}

TEST(StickMemory, ARepeatedStepBeginsWithWhatTheFirstOneBeganWith) {
  StickMemory memory;
  const auto recall = [&] {
    memory.rewind();
    return memory.recall(1);
  };
  memory.store(1, kA);
  memory.end_part();
  memory.begin_step();
  memory.store(1, kB);  // first part
  memory.end_part();
  EXPECT_EQ(recall(), kB);
  memory.store(1, kC);  // second part
  memory.end_part();
  EXPECT_EQ(recall(), kC);
  memory.store(1, kB);  // a third one that is not accepted
  memory.restart();
  EXPECT_EQ(recall(), kA);
  memory.begin_step();  // a step that failed for good: nothing was stored
  EXPECT_EQ(recall(), kA);
  memory.store(1, kC);
  memory.end_part();
  memory.begin_step();
  EXPECT_EQ(recall(), kC);
  memory.forget();
  EXPECT_EQ(recall(), Vec3::Zero());
}

}  // namespace
}  // namespace deformable_sim
