// Tests of why a saw does not follow the hand.
#include "app/window/held_saw.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace kerf {
namespace {

// The blade's plane is x-y, and bone presses against its rim from -x.
HeldSawInput MakeHeldInput() {
  HeldSawInput in;
  in.holds = true;
  in.spindle_on = true;
  in.X_wanted.p_AB = {-8, 0, 0};
  in.coupled.f_cut_W_N = {4, 0, 0};
  in.coupled.f_H_W_N = {4, 0, 0};
  in.coupled.engaged_teeth = 3;
  return in;
}

TEST(HeldSaw, NothingIsSaidWithoutAWantedMotionOrWithoutResistance) {
  HeldSawInput in = MakeHeldInput();
  ASSERT_TRUE(DiagnoseHeldSaw(in));
  in.holds = false;
  EXPECT_FALSE(DiagnoseHeldSaw(in));
  in = MakeHeldInput();
  in.X_wanted = in.X_WT;
  in.coupled.f_H_W_N = {1, 0, 0};
  EXPECT_FALSE(DiagnoseHeldSaw(in));
  in = MakeHeldInput();
  in.coupled = {};  // the saw is in air and still moves towards the hand
  EXPECT_FALSE(DiagnoseHeldSaw(in));
}

TEST(HeldSaw, FindsTheCause) {
  HeldSawInput in = MakeHeldInput();
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kFedTooFast);
  in.coupled.status = kCoupledForceLimited;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kForceLimit);
  in.coupled.status = kCoupledLeavesUsedUp;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kNoMemory);
  in.coupled.status = kCoupledTouchesMetal;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kMetal);

  in = MakeHeldInput();
  in.spindle_on = false;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kSpindleOff);
  in = MakeHeldInput();
  in.coupled.engaged_teeth = 0;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kNotCut);
}

TEST(HeldSaw, ForcesAlongTheSpindleBind) {
  HeldSawInput in = MakeHeldInput();
  in.X_wanted.p_AB = {-2, 0, 8};  // sideways
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kBinds);
  in = MakeHeldInput();
  in.coupled.f_face_W_N = {0, 0, -3};  // the walls press although the hand moves in the plane
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kBinds);
  in.spindle_on = false;  // also without a spindle
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kBinds);

  // A tilt binds; a turn about the spindle does not.
  in = MakeHeldInput();
  in.X_wanted.R_AB = glm::angleAxis(0.2, Vec3(1, 0, 0));
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kBinds);
  in.X_wanted.R_AB = glm::angleAxis(0.2, Vec3(0, 0, 1));
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kFedTooFast);

  // A ball has no walls.
  in = MakeHeldInput();
  in.tool = BallBurr{};
  in.X_wanted.p_AB = {0, 0, 8};
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kFedTooFast);
}

TEST(HeldSaw, GuideIsNamedIfItIsStrongerThanTheBone) {
  HeldSawInput in = MakeHeldInput();
  in.guide_normal_W = {0, 0, 1};
  in.guide_force_N = 1;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kFedTooFast);
  in.guide_force_N = 6;
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kGuideDepth);
  in.X_wanted.p_AB = {0, 0, 8};
  EXPECT_EQ(DiagnoseHeldSaw(in), HeldReason::kGuidePlane);
}

// The same answer in any frame: forces, leads and axes rotate together.
TEST(HeldSaw, DoesNotDependOnTheFrame) {
  const Quat R = glm::normalize(Quat{0.3, -0.5, 0.7, 0.2});
  for (HeldSawInput in : {MakeHeldInput(), [] {
                            HeldSawInput binds = MakeHeldInput();
                            binds.X_wanted.p_AB = {-2, 0, 8};
                            return binds;
                          }()}) {
    const std::optional<HeldReason> expected = DiagnoseHeldSaw(in);
    in.X_WT = {R * in.X_WT.R_AB, R * in.X_WT.p_AB};
    in.X_wanted = {R * in.X_wanted.R_AB, R * in.X_wanted.p_AB};
    in.coupled.f_cut_W_N = R * in.coupled.f_cut_W_N;
    in.coupled.f_H_W_N = R * in.coupled.f_H_W_N;
    EXPECT_EQ(DiagnoseHeldSaw(in), expected);
  }
}

TEST(HeldSaw, EachReasonHasItsOwnSentence) {
  std::set<std::string> texts;
  for (int i = 0; i <= static_cast<int>(HeldReason::kNotCut); ++i) {
    const std::string text = DescribeHeldReason(static_cast<HeldReason>(i));
    EXPECT_TRUE(text.ends_with('.')) << text;
    texts.insert(text);
  }
  EXPECT_EQ(texts.size(), static_cast<std::size_t>(HeldReason::kNotCut) + 1);
}

TEST(HeldSawWatch, ReportsAfterASecondAndUntilTheSawMovesOrIsLetGo) {
  for (const double dt_s : {0.01, 0.1}) {
    HeldSawWatch watch;
    HeldSawInput in = MakeHeldInput();
    double time_s = 0;
    for (; time_s < 0.95 * HeldSawWatch::kHeldFor_s; time_s += dt_s) watch.Update(dt_s, in);
    EXPECT_FALSE(watch.reason()) << time_s;
    for (; time_s < HeldSawWatch::kHeldFor_s + 2 * dt_s; time_s += dt_s) watch.Update(dt_s, in);
    EXPECT_EQ(watch.reason(), HeldReason::kFedTooFast);
    in.X_WT.p_AB.x -= 1.1 * HeldSawWatch::kMoved_mm;
    watch.Update(dt_s, in);
    EXPECT_FALSE(watch.reason());
    for (double t_s = 0; t_s < HeldSawWatch::kHeldFor_s + 2 * dt_s; t_s += dt_s) watch.Update(dt_s, in);
    EXPECT_TRUE(watch.reason());
    in.holds = false;
    watch.Update(dt_s, in);
    EXPECT_FALSE(watch.reason());
  }
}

// A saw that cuts at a third of a millimetre per second is not held.
TEST(HeldSawWatch, SlowCutIsNotHeld) {
  HeldSawWatch watch;
  HeldSawInput in = MakeHeldInput();
  for (int i = 0; i < 1000; ++i) {
    in.X_WT.p_AB.x -= 0.005;
    in.X_wanted.p_AB.x -= 0.005;
    watch.Update(0.01, in);
    EXPECT_FALSE(watch.reason()) << i;
  }
}

}  // namespace
}  // namespace kerf
