// Pacing by a ROS clock that the test sets by hand.
#include "deformable_sim/ros/pacer.h"

#include <gtest/gtest.h>

namespace deformable_sim {
namespace {

constexpr double kStart = 1000.0;  // s
constexpr double kExact = 1e-6;    // s: ROS times are nanoseconds, doubles at 1000 s hold 1e-13

void set_clock(double seconds) {
  ros::Time::init();
  ros::Time::setNow(ros::Time(seconds));
}

TEST(Pacer, AStepIsDueWhenRosTimeHasComeToIt) {
  // The step that begins at t is due at epoch + t.
  set_clock(kStart);
  Pacer pacer(ClockMode::kRealTime, false);
  pacer.restart(0.0);
  EXPECT_LE(pacer.seconds_until_due(0.0), 0.0);
  EXPECT_GT(pacer.seconds_until_due(0.01), 0.0);
  set_clock(kStart + 0.01);
  EXPECT_LE(pacer.seconds_until_due(0.01), kExact);
  EXPECT_NEAR(pacer.stamp(0.01).toSec(), kStart + 0.01, kExact);
}

TEST(Pacer, GivesUpWhatItIsBehindByMoreThanATenthOfASecond) {
  // After a stall of 3 s at most 0.1 s is caught up; 2.9 s are given up and stamps move on by them.
  set_clock(kStart);
  Pacer pacer(ClockMode::kRealTime, false);
  pacer.restart(0.0);
  set_clock(kStart + 3.0);
  EXPECT_LE(pacer.seconds_until_due(0.0), 0.0);
  EXPECT_NEAR(pacer.given_up(), 2.9, kExact);
  EXPECT_NEAR(pacer.stamp(0.0).toSec(), kStart + 2.9, kExact);
  EXPECT_LE(pacer.seconds_until_due(0.09), 0.0);
  EXPECT_GT(pacer.seconds_until_due(0.11), 0.0);
}

TEST(Pacer, GoesOnFromAClockThatJumpedBack) {
  set_clock(kStart);
  Pacer pacer(ClockMode::kRealTime, false);
  pacer.restart(0.0);
  set_clock(kStart - 500.0);
  EXPECT_LE(pacer.seconds_until_due(2.0), kExact);
  EXPECT_NEAR(pacer.stamp(2.0).toSec(), kStart - 500.0, kExact);
  EXPECT_EQ(pacer.given_up(), 0.0);
}

TEST(Pacer, StampsAreSimulatedTimeWhenNobodyElseHasAClock) {
  set_clock(kStart);
  for (const ClockMode mode : {ClockMode::kAsFastAsPossible, ClockMode::kOnDemand}) {
    Pacer pacer(mode, false);
    pacer.restart(0.0);
    EXPECT_EQ(pacer.seconds_until_due(7.0), 0.0);
    EXPECT_NEAR(pacer.stamp(7.0).toSec(), 7.0, kExact);
  }
  Pacer own_clock(ClockMode::kRealTime, true);
  own_clock.restart(0.0);
  EXPECT_NEAR(own_clock.stamp(7.0).toSec(), 7.0, kExact);
}

}  // namespace
}  // namespace deformable_sim
