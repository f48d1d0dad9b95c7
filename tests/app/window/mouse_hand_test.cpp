// Tests of the hand that follows the mouse.
#include "loop/haptics/mouse_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "device/devices/profiles.h"

namespace kerf {
namespace {

struct Rig {
  HandTarget target;
  SimulatedDevice device{FindDeviceProfile("omega_6"), FindHandModel("H4"), Pose{}};
  MouseHand hand{device, target, Pose{}, Vec3{0}};

  void Run(double seconds, const Vec3& f_N = Vec3{0}) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
      hand.Advance(0.001);
      device.Elapse(0.001);
      device.Write(f_N, Vec3{0});
    }
  }
};

// The device's friction may hold the handle slightly off the target, by friction / stiffness of the hand.
TEST(MouseHand, HandleReachesTheTargetAtALimitedSpeed) {
  Rig rig;
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {40, 0, 0}}});
  double fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    rig.Run(0.001);
    fastest = std::max(fastest, glm::length(rig.device.v_WC_mm_per_s()));
  }
  const double short_mm = rig.device.profile().friction_N / MouseHandParams{}.stiffness_N_per_mm;
  EXPECT_NEAR(glm::length(rig.device.p_WC_mm() - Vec3(40, 0, 0)), 0, short_mm + 0.05);
  // The handle follows, on a spring, a target that moves at that speed, so it never reaches twice the speed.
  EXPECT_LT(fastest, 2 * MouseHandParams{}.speed_mm_per_s);
}

// The spring's extension is limited to its reach. It pulls with at most k x reach, however far the mouse moved, and the
// released handle does not fly to the target.
TEST(MouseHand, ForceOnAHeldHandleIsLimited) {
  Rig rig;
  const MouseHandParams params;
  const double max_N = params.stiffness_N_per_mm * params.reach_mm;
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {500, 0, 0}}});
  // If a wall pushes back with slightly more than that force, the handle moves back.
  rig.Run(3, {-(max_N + 1), 0, 0});
  const double at_mm = rig.device.p_WC_mm().x;
  rig.Run(0.5, {-(max_N + 1), 0, 0});
  EXPECT_LT(rig.device.p_WC_mm().x, at_mm);
  // With slightly less than that force, the handle moves forward.
  const double then_mm = rig.device.p_WC_mm().x;
  rig.Run(0.5, {-(max_N - 1), 0, 0});
  EXPECT_GT(rig.device.p_WC_mm().x, then_mm);
}

TEST(MouseHand, InvalidTargetIsIgnored) {
  Rig rig;
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}}});
  rig.Run(0.5);
  EXPECT_NEAR(glm::length(rig.device.p_WC_mm()), 0, 1e-9);
  for (const double dt_s : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), 1e9}) rig.hand.Advance(dt_s);
  EXPECT_TRUE(std::isfinite(rig.device.p_WC_mm().x));
}

// A tool that is stuck at the origin, with a coupling of 2 N/mm to the handle.
TEST(MouseHand, PullsNothingAfterTheUserHasLetGo) {
  Rig rig;
  const Pose X_tool{};
  const auto run = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
      const Vec3 f_N = -2.0 * rig.device.p_WC_mm();
      rig.hand.Follow(X_tool, glm::length(f_N) > 0.02, true);
      rig.hand.Advance(0.001);
      rig.device.Elapse(0.001);
      rig.device.Write(f_N, Vec3{0});
    }
  };
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {10, 0, 0}}});
  run(2);
  // Springs of 0.6 and 2 N/mm in series, with an extension of 10 mm together.
  ASSERT_NEAR(rig.device.p_WC_mm().x, 10 * 0.6 / 2.6, 0.1);
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {10, 0, 0}}, .holds = false});
  run(1);
  // Only the device's friction is left, which the springs do not overcome.
  EXPECT_LT(glm::length(rig.device.p_WC_mm()), rig.device.profile().friction_N / 2.6 + 0.01);
  // Later targets without a hand change nothing.
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {30, 0, 0}}, .holds = false});
  run(1);
  EXPECT_LT(glm::length(rig.device.p_WC_mm()), rig.device.profile().friction_N / 2.6 + 0.01);
}

// A blade that was wedged goes on to spring out of its kerf after the hand has let go, and friction holds it there.
// While the spindle turns, friction drives the blade, so the hand holds it; the rest of the force is let go after that.
TEST(MouseHand, LetsGoOfABladeThatFrictionHoldsOnceTheSpindleStops) {
  constexpr double kCoupling_N_per_mm = 2;
  Rig rig;
  double tool_mm = 0;
  const auto run = [&](double seconds, bool turns) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
      const Vec3 f_N = kCoupling_N_per_mm * (Vec3(tool_mm, 0, 0) - rig.device.p_WC_mm());
      rig.hand.Follow({Quat{1, 0, 0, 0}, {tool_mm, 0, 0}}, glm::length(f_N) > 0.02, turns);
      rig.hand.Advance(0.001);
      rig.device.Elapse(0.001);
      rig.device.Write(f_N, Vec3{0});
    }
    return kCoupling_N_per_mm * glm::distance(Vec3(tool_mm, 0, 0), rig.device.p_WC_mm());
  };
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {10, 0, 0}}});
  run(1, true);
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {10, 0, 0}}, .holds = false});
  run(0.1, true);
  tool_mm = -3;
  // The hand's spring of 0.6 N/mm and the coupling in series hold it.
  const double held_N = 3 * 0.6 * kCoupling_N_per_mm / (0.6 + kCoupling_N_per_mm);
  const double friction_N = rig.device.profile().friction_N;
  EXPECT_NEAR(run(2, true), held_N, friction_N);
  EXPECT_LT(run(2, false), 0.02);
  // It is not followed while it moves: the springs take the handle along by 2 / 2.6 of the way.
  const double at_mm = rig.device.p_WC_mm().x;
  for (int i = 0; i < 200; ++i) {
    tool_mm -= 0.005;
    run(0.001, false);
  }
  EXPECT_GT(rig.device.p_WC_mm().x, at_mm - 0.85);
}

// Targets that were published before Place() do not pull the hand away from its new place.
TEST(MouseHand, StaysWhereItIsPlacedUntilTheUserTakesTheToolAgain) {
  Rig rig;
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {5, 0, 0}}});
  rig.Run(1);
  const Pose X_placed{Quat{1, 0, 0, 0}, {0, 20, 0}};
  rig.hand.Place(X_placed);
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {6, 0, 0}}});
  rig.Run(1);
  EXPECT_LT(glm::distance(rig.device.p_WC_mm(), X_placed.p_AB), 1e-6);
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {6, 0, 0}}, .holds = false});
  rig.Run(0.1);
  rig.target.Publish({.X_WH = {Quat{1, 0, 0, 0}, {0, 25, 0}}});
  rig.Run(2);
  EXPECT_NEAR(rig.device.p_WC_mm().y, 25,
              rig.device.profile().friction_N / MouseHandParams{}.stiffness_N_per_mm + 0.05);
}

}  // namespace
}  // namespace kerf
