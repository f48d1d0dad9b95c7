// Tests of how keys and mouse set the wanted pose of the saw.
#include "app/window/saw_controls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {
namespace {

using Kind = WindowEvent::Kind;

// In the front view, x is right, z is up, and y points into the picture. A pixel is 0.2 mm.
const ViewBasis kFront{.right_W = {1, 0, 0}, .up_W = {0, 0, 1}, .forward_W = {0, 1, 0}, .mm_per_pixel = 0.2};

WindowEvent KeyEvent(Key key, bool down = true, bool shift = false) {
  WindowEvent event;
  event.kind = down ? WindowEvent::Kind::kKeyDown : WindowEvent::Kind::kKeyUp;
  event.key = key;
  event.shift = shift;
  return event;
}

WindowEvent MouseEvent(WindowEvent::Kind kind, double x, double y, bool shift = false, bool control = false) {
  WindowEvent event;
  event.kind = kind;
  event.x = x;
  event.y = y;
  event.shift = shift;
  event.control = control;
  return event;
}

double AngleBetween(const Quat& a, const Quat& b) {
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b))));
}

TEST(SawControls, HeldKeyMovesAtTheFeedRateAtAnyFrameRate) {
  for (const int frames : {10, 100, 1000}) {
    SawControls controls(Pose{});
    controls.set_feed_mm_per_s(3);
    ASSERT_TRUE(controls.Take(KeyEvent(Key::kDown), kFront));
    for (int i = 0; i < frames; ++i) controls.Advance(1.0 / frames, kFront, controls.wanted());
    ASSERT_TRUE(controls.Take(KeyEvent(Key::kDown, false), kFront));
    controls.Advance(1, kFront, controls.wanted());
    EXPECT_NEAR(glm::length(controls.wanted().p_AB - Vec3(0, 0, -3)), 0, 1e-9) << frames;
  }
}

// What holds the saw lets the wanted pose run ahead of it; the other key lifts it at once, not after the way back.
TEST(SawControls, OppositeKeyBeginsAtTheSawThatIsHeld) {
  SawControls controls(Pose{});
  controls.set_feed_mm_per_s(4);
  controls.Take(KeyEvent(Key::kDown), kFront);
  for (int i = 0; i < 200; ++i) controls.Advance(0.01, kFront, Pose{});
  EXPECT_NEAR(controls.wanted().p_AB.z, -8, 1e-9);
  controls.Take(KeyEvent(Key::kUp), kFront);
  controls.Take(KeyEvent(Key::kDown, false), kFront);
  controls.Advance(0.01, kFront, Pose{});
  EXPECT_NEAR(controls.wanted().p_AB.z, 0.04, 1e-9);
  // Across the pressure, it stays.
  controls.Release();
  controls.Continue(Pose{});
  controls.Take(KeyEvent(Key::kDown), kFront);
  for (int i = 0; i < 100; ++i) controls.Advance(0.01, kFront, Pose{});
  controls.Take(KeyEvent(Key::kRight), kFront);
  controls.Take(KeyEvent(Key::kDown, false), kFront);
  controls.Advance(0.01, kFront, Pose{});
  EXPECT_NEAR(controls.wanted().p_AB.z, -4, 1e-9);
}

TEST(SawControls, ShiftIsFastInTheAirOnly) {
  for (const bool touches : {false, true}) {
    SawControls controls(Pose{});
    controls.set_feed_mm_per_s(1);
    controls.Take(KeyEvent(Key::kDown, true, true), kFront);
    for (int i = 0; i < 100; ++i) controls.Advance(0.01, kFront, controls.wanted(), touches);
    EXPECT_NEAR(controls.wanted().p_AB.z, touches ? -1 : -6, 1e-9);
  }
}

TEST(SawControls, MouseDragsTheSawByItsMotion) {
  SawControls controls(Pose{});
  EXPECT_FALSE(controls.Take(MouseEvent(Kind::kMouseMove, 5, 5), kFront));  // no button is pressed
  EXPECT_TRUE(controls.Take(MouseEvent(Kind::kMouseDown, 100, 100), kFront));
  EXPECT_TRUE(controls.Take(MouseEvent(Kind::kMouseMove, 110, 95), kFront));
  EXPECT_NEAR(glm::length(controls.wanted().p_AB - Vec3(2, 0, 1)), 0, 1e-12);
  EXPECT_TRUE(controls.Take(MouseEvent(Kind::kMouseMove, 110, 90, true), kFront));  // Shift: into the picture
  EXPECT_NEAR(glm::length(controls.wanted().p_AB - Vec3(2, 1, 1)), 0, 1e-12);
  EXPECT_TRUE(controls.Take(MouseEvent(Kind::kMouseUp, 110, 90), kFront));
  EXPECT_FALSE(controls.Take(MouseEvent(Kind::kMouseMove, 200, 90), kFront));
}

TEST(SawControls, RestrictedMotionStaysInTheBladesPlane) {
  // The spindle is along (1, 1, 0), so the blade's plane contains z and (1, -1, 0).
  const Vec3 spindle = glm::normalize(Vec3(1, 1, 0));
  const Pose X{glm::angleAxis(std::acos(-1.0) / 2, glm::normalize(glm::cross(Vec3(0, 0, 1), spindle))), {0, 0, 0}};
  ASSERT_NEAR(glm::length(X.Vector({0, 0, 1}) - spindle), 0, 1e-12);
  SawControls controls(X);
  controls.set_in_blade_plane(true);
  for (const Key key : {Key::kRight, Key::kUp, Key::kPageUp, Key::kW, Key::kA, Key::kQ}) {
    controls.Take(KeyEvent(key), kFront);
    for (int i = 0; i < 50; ++i) controls.Advance(0.01, kFront, controls.wanted());
    controls.Take(KeyEvent(key, false), kFront);
  }
  EXPECT_NEAR(glm::dot(controls.wanted().p_AB, spindle), 0, 1e-9);
  EXPECT_NEAR(glm::length(controls.wanted().Vector({0, 0, 1}) - spindle), 0, 1e-9);
  EXPECT_GT(glm::length(controls.wanted().p_AB), 1);              // it moved
  EXPECT_GT(AngleBetween(controls.wanted().R_AB, X.R_AB), 0.05);  // and turned about its spindle
}

TEST(SawControls, WantedPoseWaitsForASawThatIsHeldBack) {
  SawControls controls(Pose{});
  controls.Take(KeyEvent(Key::kRight, true, true), kFront);  // with Shift: fast
  controls.Take(KeyEvent(Key::kQ), kFront);
  for (int i = 0; i < 2000; ++i) controls.Advance(0.01, kFront, Pose{});  // the saw does not move
  EXPECT_NEAR(glm::length(controls.wanted().p_AB), SawControls::kLead_mm, 0.5);
  EXPECT_NEAR(AngleBetween(controls.wanted().R_AB, Quat{1, 0, 0, 0}), SawControls::kLead_rad, 0.05);
  EXPECT_TRUE(controls.holds());
  controls.Release();
  EXPECT_FALSE(controls.holds());
  controls.Advance(0.01, kFront, Pose{});
  EXPECT_EQ(controls.wanted().p_AB, Vec3(0));
  EXPECT_EQ(controls.wanted().R_AB, (Quat{1, 0, 0, 0}));
}

// With keys and the mouse together, the last release counts, in all modes.
TEST(SawControls, LetsGoWithTheLastKeyOrButton) {
  for (const bool in_plane : {false, true}) {
    const Pose X_saw{Quat{1, 0, 0, 0}, {1, 2, 3}};
    SawControls controls(X_saw);
    controls.set_in_blade_plane(in_plane);
    EXPECT_FALSE(controls.holds());
    controls.Take(KeyEvent(Key::kDown), kFront);
    controls.Take(KeyEvent(Key::kQ), kFront);
    controls.Take(MouseEvent(Kind::kMouseDown, 0, 0), kFront);
    controls.Take(MouseEvent(Kind::kMouseMove, 30, 0, false, true), kFront);  // Control: turns
    for (int i = 0; i < 100; ++i) controls.Advance(0.01, kFront, X_saw);
    controls.Take(KeyEvent(Key::kDown, false), kFront);
    EXPECT_TRUE(controls.holds());
    controls.Take(MouseEvent(Kind::kMouseUp, 30, 0), kFront);
    EXPECT_TRUE(controls.holds());
    controls.Take(KeyEvent(Key::kQ, false), kFront);
    EXPECT_FALSE(controls.holds());
    controls.Advance(0.01, kFront, X_saw);
    EXPECT_EQ(controls.wanted().p_AB, X_saw.p_AB);
    EXPECT_EQ(controls.wanted().R_AB, X_saw.R_AB);
  }
}

TEST(SawControls, SetPoseIsWantedUntilTheUserInterferes) {
  SawControls controls(Pose{});
  controls.Set({Quat{1, 0, 0, 0}, {0, 0, 10}});
  EXPECT_TRUE(controls.holds());
  controls.Advance(0.01, kFront, Pose{});
  EXPECT_EQ(controls.wanted().p_AB, Vec3(0, 0, 10));
  controls.Take(KeyEvent(Key::kDown), kFront);
  controls.Take(KeyEvent(Key::kDown, false), kFront);
  EXPECT_FALSE(controls.holds());
}

TEST(SawControls, SetPoseIsReachedFromAnyDistance) {
  SawControls controls(Pose{});
  // Further than the lead, in position and angle: 60 mm and 90 degrees.
  const Pose X_far{glm::angleAxis(0.5 * std::numbers::pi, Vec3(0, 1, 0)), {0, 0, 60}};
  controls.Set(X_far);
  Pose X_WT;
  for (int i = 0; i < 20; ++i) {
    controls.Advance(0.01, kFront, X_WT);
    EXPECT_LE(glm::distance(controls.wanted().p_AB, X_WT.p_AB), SawControls::kLead_mm + 1e-9);
    X_WT = controls.wanted();
    if (i != 2) continue;
    // Another session continues on the way, although a key is held.
    controls.Take(KeyEvent(Key::kDown), kFront);
    controls.Continue(X_WT);
    EXPECT_TRUE(controls.holds());
  }
  EXPECT_NEAR(glm::distance(X_WT.p_AB, X_far.p_AB), 0, 1e-9);
  EXPECT_NEAR(std::abs(glm::dot(X_WT.R_AB, X_far.R_AB)), 1, 1e-9);
  // Without a pose that was set, the saw is let go of.
  controls.Take(KeyEvent(Key::kDown), kFront);
  controls.Advance(0.01, kFront, X_WT);
  controls.Continue(X_WT);
  EXPECT_FALSE(controls.holds());
  EXPECT_EQ(controls.wanted().p_AB, X_WT.p_AB);
}

// In air, presses that are too short to overcome the handle's friction add up.
TEST(SawControls, ShortPressesAddUpInAir) {
  SawControls controls(Pose{});
  controls.set_feed_mm_per_s(4);
  for (int i = 0; i < 5; ++i) {
    controls.Take(KeyEvent(Key::kRight), kFront);
    controls.Advance(0.025, kFront, Pose{}, false);
    controls.Take(KeyEvent(Key::kRight, false), kFront);
    controls.Advance(0.1, kFront, Pose{}, false);
  }
  EXPECT_NEAR(controls.wanted().p_AB.x, 0.5, 1e-9);
  controls.Advance(0.1, kFront, Pose{}, true);  // the saw touches bone
  EXPECT_EQ(controls.wanted().p_AB.x, 0);
}

// From any side, the arrow Down leads into the bone, and the other keys move along and across the cut.
TEST(AlignWithCut, KeysFollowTheAxesOfTheCut) {
  const Vec3 along{1, 0, 0}, into{0, 0, -1};
  // Seen from above at an angle, so that the picture's down has a component towards the viewer.
  for (const double around : {0.0, 0.4, 1.2, 2.0, 3.1, 4.4, 5.5}) {
    const Quat turn = glm::angleAxis(around, Vec3(0, 0, 1)) * glm::angleAxis(-0.6, Vec3(1, 0, 0));
    const ViewBasis view{turn * kFront.right_W, turn * kFront.up_W, turn * kFront.forward_W, 0.2};
    const ViewBasis keys = AlignWithCut(view, along, into);
    EXPECT_EQ(keys.up_W, -into);
    EXPECT_GT(glm::dot(keys.right_W, view.right_W), std::cos(std::numbers::pi / 4) - 1e-9) << around;
    EXPECT_GT(glm::dot(keys.forward_W, view.forward_W), 0.5) << around;
    EXPECT_NEAR(std::max(std::abs(keys.right_W.x), std::abs(keys.right_W.y)), 1, 1e-9);
    for (const bool lock : {false, true}) {
      SawControls controls(Pose{});
      controls.set_in_blade_plane(lock);
      controls.set_lock_plane(CutPlane{.p_W = {0, 0, 0}, .normal_W = {0, 1, 0}});
      controls.Take(KeyEvent(Key::kDown), keys);
      for (int i = 0; i < 100; ++i) controls.Advance(0.01, keys, controls.wanted());
      EXPECT_NEAR(glm::length(controls.wanted().p_AB - controls.feed_mm_per_s() * into), 0, 1e-9) << around;
    }
  }
}

TEST(SawControls, LockLeadsToItsPlaneAndHoldsTheSawThere) {
  SawControls controls(Pose{Quat{1, 0, 0, 0}, {0, 2, 0}});
  controls.set_in_blade_plane(true);
  controls.set_lock_plane(CutPlane{.p_W = {0, 0, 0}, .normal_W = {0, 1, 0}});
  const auto hold = [&](Key key) {
    controls.Take(KeyEvent(key), kFront);
    for (int i = 0; i < 100; ++i) controls.Advance(0.01, kFront, controls.wanted(), false);
    controls.Take(KeyEvent(key, false), kFront);
    return controls.wanted().p_AB.y;
  };
  EXPECT_EQ(hold(Key::kPageUp), 2);            // not further away
  EXPECT_NEAR(hold(Key::kPageDown), 0, 1e-9);  // 4 mm: to the plane, and no further
  EXPECT_NEAR(hold(Key::kPageDown), 0, 1e-9);
  EXPECT_NEAR(hold(Key::kPageUp), 0, 1e-9);
}

TEST(SawControls, LockSaysOnceThatItHoldsAKey) {
  SawControls controls(Pose{Quat{1, 0, 0, 0}, {0, 2, 0}});
  controls.set_lock_plane(CutPlane{.p_W = {0, 0, 0}, .normal_W = {0, 1, 0}});
  const auto press = [&](Key key) {
    controls.Take(KeyEvent(key), kFront);
    controls.Take(KeyEvent(key), kFront);  // the keyboard repeats it
    const bool held = controls.TakeHeldByLock();
    EXPECT_FALSE(controls.TakeHeldByLock());
    controls.Take(KeyEvent(key, false), kFront);
    return held;
  };
  EXPECT_FALSE(press(Key::kPageUp)) << "free";
  controls.set_in_blade_plane(true);
  EXPECT_TRUE(press(Key::kPageUp)) << "away from the plane";
  EXPECT_FALSE(press(Key::kPageDown)) << "towards it";
  EXPECT_FALSE(press(Key::kDown));
  EXPECT_TRUE(press(Key::kW)) << "tilt";
}

// A saw that is pressed with the greatest force still moves along at the speed of the keys.
TEST(SawControls, PressureInOneDirectionLeavesTheOtherOneItsLead) {
  SawControls controls(Pose{});
  controls.set_feed_mm_per_s(3);
  controls.Take(KeyEvent(Key::kDown), kFront);
  for (int i = 0; i < 1000; ++i) controls.Advance(0.01, kFront, Pose{});
  EXPECT_NEAR(controls.wanted().p_AB.z, -SawControls::kLead_mm, 1e-9);
  controls.Take(KeyEvent(Key::kRight), kFront);
  for (int i = 0; i < 100; ++i) controls.Advance(0.01, kFront, Pose{});
  EXPECT_NEAR(controls.wanted().p_AB.x, 3, 1e-9);
  EXPECT_NEAR(glm::length(controls.wanted().p_AB), SawControls::kLead_mm, 1e-9);
}

TEST(SawControls, IgnoresLettersWithControl) {
  SawControls controls(Pose{});
  WindowEvent undo = KeyEvent(Key::kQ);
  undo.control = true;
  EXPECT_FALSE(controls.Take(undo, kFront));
  EXPECT_FALSE(controls.Take(KeyEvent(Key::kZ), kFront));
}

}  // namespace
}  // namespace kerf
