// The hand on an emulated handle, compared with its spring's law and its path.
#include "device/emulation/scripted_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kStep_s = 0.0005;

const DeviceProfile& Falcon() {
  return FindDeviceProfile("falcon");
}

void MoveFor(ScriptedHand& hand, double seconds, const Vec3& f_D_N = Vec3{0}) {
  for (int i = 0; i < static_cast<int>(seconds / kStep_s); ++i) hand.Move(kStep_s, f_D_N, Vec3{0});
}

TEST(ScriptedHand, RestsUntilItBegins) {
  ScriptedHand hand(Falcon(), FindHandModel("H3"), {.path = ScriptedPath::kCircle});
  MoveFor(hand, 1);
  EXPECT_EQ(hand.handle().p_AB, Vec3(0));
  EXPECT_EQ(hand.path_s(), 0);
}

// At rest the spring balances the force, up to the device's own friction.
TEST(ScriptedHand, YieldsToTheForceByItsStiffness) {
  const HandModel& model = FindHandModel("H3");
  ScriptedHand hand(Falcon(), model, {});
  hand.Begin();
  const Vec3 f_D_N(0, -2, 1);
  MoveFor(hand, 3, f_D_N);
  const double tolerance_mm = Falcon().friction_N / model.stiffness_N_per_mm;
  EXPECT_LE(glm::length(hand.handle().p_AB - f_D_N / model.stiffness_N_per_mm), tolerance_mm);
  EXPECT_EQ(hand.f_D_N(), f_D_N);
}

// The lag behind the intended position, due to friction / stiffness and to mass and damping at half a turn per second,
// is 2 mm.
TEST(ScriptedHand, FollowsTheRequestedCircle) {
  ScriptedHand hand(Falcon(), FindHandModel("H3"), {.path = ScriptedPath::kCircle, .radius_mm = 15});
  hand.Begin();
  MoveFor(hand, 2);
  Vec3 low{0};
  Vec3 high{0};
  for (int i = 0; i < 4000; ++i) {
    hand.Move(kStep_s, Vec3{0}, Vec3{0});
    const Vec3 p = hand.handle().p_AB;
    EXPECT_NEAR(glm::length(p), 15, 2);
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  EXPECT_NEAR(high.x - low.x, 30, 4);
  EXPECT_NEAR(high.y - low.y, 30, 4);
  EXPECT_NEAR(high.z - low.z, 0, 0.1);
}

TEST(ScriptedHand, HomesOutThenInAndReturnsToItsPath) {
  ScriptedHand hand(Falcon(), FindHandModel("H3"), {.path = ScriptedPath::kLine});
  hand.Begin();
  MoveFor(hand, 1.5);
  const double path_s = hand.path_s();
  hand.Home();
  double out_mm = 0;
  double in_mm = 0;
  double out_at_s = 0;
  double in_at_s = 0;
  for (double t_s = 0; hand.homing(); t_s += kStep_s) {
    hand.Move(kStep_s, Vec3{0}, Vec3{0});
    const double z_mm = hand.handle().p_AB.z;
    if (z_mm > out_mm) out_at_s = t_s;
    if (z_mm < in_mm) in_at_s = t_s;
    out_mm = std::max(out_mm, z_mm);
    in_mm = std::min(in_mm, z_mm);
    ASSERT_LT(t_s, 4);
  }
  EXPECT_GT(out_mm, 40);
  EXPECT_LT(in_mm, -36);
  EXPECT_LT(out_at_s, in_at_s);
  EXPECT_NEAR(hand.path_s(), path_s, kStep_s);
  MoveFor(hand, 1);
  EXPECT_NEAR(hand.handle().p_AB.z, 0, 1);
  EXPECT_NEAR(hand.path_s(), path_s + 1, 2 * kStep_s);
}

TEST(ScriptedHand, PressesButtonsAtTheirTimes) {
  ScriptedHand hand(Falcon(), FindHandModel("H3"), {.presses = {{0.5, 1.0, 4}, {0.8, 1.2, 1}}});
  hand.Begin();
  MoveFor(hand, 0.25);
  EXPECT_EQ(hand.buttons(), 0U);
  MoveFor(hand, 0.35);
  EXPECT_EQ(hand.buttons(), 4U);
  MoveFor(hand, 0.3);
  EXPECT_EQ(hand.buttons(), 5U);
  MoveFor(hand, 0.2);
  EXPECT_EQ(hand.buttons(), 1U);
  MoveFor(hand, 0.2);
  EXPECT_EQ(hand.buttons(), 0U);
}

TEST(ScriptedHand, RefusesInvalidPaths) {
  const HandModel& model = FindHandModel("H3");
  EXPECT_THROW(ScriptedHand(Falcon(), model, {.radius_mm = 0}), Error);
  EXPECT_THROW(ScriptedHand(Falcon(), model, {.radius_mm = std::nan("")}), Error);
  EXPECT_THROW(ScriptedHand(Falcon(), model, {.period_s = -1}), Error);
}

}  // namespace
}  // namespace kerf
