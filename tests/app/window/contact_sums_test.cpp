#include "app/window/contact_sums.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

LoopTick MakeTick(double time_s, double rpm, double hand_N, double bone_N) {
  LoopTick tick;
  tick.time_s = time_s;
  tick.in.rpm = rpm;
  tick.coupled.f_H_W_N = {hand_N, 0, 0};
  tick.coupled.f_face_W_N = {0, bone_N, 0};
  return tick;
}

TEST(ContactSums, PullOfAGuideInTheAirIsNoCutting) {
  ContactSums sums;
  sums.Take(MakeTick(1, 20000, 8, 0), 0);
  sums.Take(MakeTick(2, 0, 8, 0), 1);
  EXPECT_EQ(sums.in_bone_s, 0);
  EXPECT_EQ(sums.turning_force_N, 0);
  EXPECT_EQ(sums.stopped_force_N, 0);
  EXPECT_FALSE(sums.bone_touch_s);
}

TEST(ContactSums, TimeAndForceOfASawThatTouchesBone) {
  ContactSums sums;
  sums.Take(MakeTick(1.5, 20000, 3, 2), 1);
  sums.Take(MakeTick(2, 20000, 2, 1), 1.5);
  sums.Take(MakeTick(2.25, 0, 4, 1), 2);
  sums.Take(MakeTick(9, 0, 8, 0), 2.25);
  EXPECT_DOUBLE_EQ(sums.in_bone_s, 1.25);
  EXPECT_DOUBLE_EQ(sums.turning_force_N, 3);
  EXPECT_DOUBLE_EQ(sums.stopped_force_N, 4);
  EXPECT_EQ(sums.bone_touch_s, 2.25);
}

TEST(ContactSums, AStoppedSawThatRestsInItsKerfTakesNoTime) {
  ContactSums sums;
  for (const bool held : {true, false}) {
    for (const double rpm : {0.0, 20000.0}) {
      LoopTick tick = MakeTick(1, rpm, 3, 2);
      tick.held = held;
      sums.Take(tick, 0);
    }
  }
  EXPECT_DOUBLE_EQ(sums.in_bone_s, 3);
}

}  // namespace
}  // namespace kerf
