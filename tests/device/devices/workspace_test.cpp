#include "device/devices/workspace.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "kerf/error.h"

namespace kerf {
namespace {

// For positions up to 200 mm and a few consecutive rotations; 1e-12 mm is a few rounding errors of 2^-52 * 200.
constexpr double kRounding_mm = 1e-12;

class WorkspaceDraw {
 public:
  explicit WorkspaceDraw(std::uint64_t seed) : random_(seed) {}
  double Number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  Vec3 Place() { return {Number(-100, 100), Number(-100, 100), Number(-100, 100)}; }
  Quat Turn() { return glm::normalize(Quat{Number(-1, 1), Number(-1, 1), Number(-1, 1), Number(-1, 1) + 1e-3}); }
  Pose Pose_() { return {Turn(), Place()}; }

 private:
  std::mt19937_64 random_;
};

double CalcAngle(const Quat& a, const Quat& b) {
  const Quat turn = glm::conjugate(a) * b;
  return 2 * std::atan2(std::hypot(turn.x, turn.y, turn.z), std::abs(turn.w));
}

TEST(Workspace, DefaultOrientationFacesThePatient) {
  const Workspace workspace({});
  EXPECT_LT(glm::length(workspace.ToWorld({1, 0, 0}) - Vec3(1, 0, 0)), 1e-15);   // right is the patient's left
  EXPECT_LT(glm::length(workspace.ToWorld({0, 1, 0}) - Vec3(0, 0, 1)), 1e-15);   // up is towards the head
  EXPECT_LT(glm::length(workspace.ToWorld({0, 0, 1}) - Vec3(0, -1, 0)), 1e-15);  // towards the user is to the front
}

RC_GTEST_PROP(Workspace, SettingTheAnchorMovesNothing, (std::uint64_t seed)) {
  WorkspaceDraw draw(seed);
  Workspace workspace({draw.Number(0.02, 20), draw.Turn(), draw.Place(), draw.Number(0, 1) < 0.5});
  const Pose X_WT = draw.Pose_();
  const Pose X_DH = draw.Pose_();
  workspace.Anchor(X_DH, X_WT, draw.Turn());
  const Pose X = workspace.CalcToolPose(X_DH);
  RC_ASSERT(glm::length(X.p_AB - X_WT.p_AB) < kRounding_mm);
  RC_ASSERT(CalcAngle(X.R_AB, X_WT.R_AB) < 1e-15 * 100);
}

RC_GTEST_PROP(Workspace, RoundTripIsExact, (std::uint64_t seed)) {
  WorkspaceDraw draw(seed);
  Workspace workspace({draw.Number(0.1, 5), draw.Turn(), draw.Place(), true});
  workspace.Anchor(draw.Pose_(), draw.Pose_());
  const Pose X_DH = draw.Pose_();
  const Pose back = workspace.CalcHandlePose(workspace.CalcToolPose(X_DH));
  RC_ASSERT(glm::length(back.p_AB - X_DH.p_AB) < 1e2 * kRounding_mm);  // the error is divided by a scale of 0.1
  RC_ASSERT(CalcAngle(back.R_AB, X_DH.R_AB) < 1e-13);
}

/// Compares the work at the handle and at the tool. With a scale s, the tool's point moves s times as far, so the same
/// force does s times the work. With s = 1 the mapping neither creates nor dissipates energy.
RC_GTEST_PROP(Workspace, WorkScalesWithTheMotionScale, (std::uint64_t seed)) {
  WorkspaceDraw draw(seed);
  const double scale = draw.Number(0.1, 5);
  Workspace workspace({scale, draw.Turn(), draw.Place(), false});
  workspace.Anchor(draw.Pose_(), draw.Pose_());
  const Vec3 f_W = draw.Place();
  const Pose X_DH = draw.Pose_();
  Pose X_DH_later = X_DH;
  X_DH_later.p_AB += draw.Place();
  const Vec3 p_TC = workspace.params().p_TC_mm;
  const Vec3 motion_W = workspace.CalcToolPose(X_DH_later).Point(p_TC) - workspace.CalcToolPose(X_DH).Point(p_TC);
  const double at_tool = glm::dot(f_W, motion_W);
  const double at_handle = glm::dot(workspace.ToDevice(f_W), X_DH_later.p_AB - X_DH.p_AB);
  RC_ASSERT(std::abs(at_tool - scale * at_handle) < 1e-9);  // rounding errors: a few times 100 N * 1000 mm * 2^-52
}

TEST(Workspace, RotatesTheToolOnlyIfOrientationIsSensed) {
  const Pose X_WT{Quat{1, 0, 0, 0}, {10, 20, 30}};
  const Vec3 p_TC{0, 0, 50};
  const Pose turned{glm::angleAxis(0.3, Vec3{0, 1, 0}), {0, 0, 0}};  // about the up axis
  Workspace senses({1, kFacingPatient, p_TC, true});
  senses.Anchor({}, X_WT);
  const Pose X = senses.CalcToolPose(turned);
  EXPECT_LT(glm::length(X.Point(p_TC) - X_WT.Point(p_TC)), kRounding_mm);
  EXPECT_LT(CalcAngle(X.R_AB, glm::angleAxis(0.3, Vec3{0, 0, 1})), 1e-14);  // up is towards the head
  Workspace does_not({1, kFacingPatient, p_TC, false});
  does_not.Anchor({}, X_WT);
  EXPECT_LT(glm::length(does_not.CalcToolPose(turned).p_AB - X_WT.p_AB), kRounding_mm);
}

TEST(Workspace, ScaledProfileKeepsTheStiffnessAtTheHandle) {
  DeviceProfile profile;
  profile.max_stiffness_N_per_mm = 3;
  profile.resolution_mm = 0.04;
  profile.workspace_radius_mm = 40;
  // The tool moves 2 mm for each 1 mm of the handle, so a spring of 1.5 N/mm at the tool is one of 3 N/mm in the hand.
  const DeviceProfile scaled = ScaleProfile(profile, 2);
  EXPECT_DOUBLE_EQ(scaled.max_stiffness_N_per_mm, 1.5);
  EXPECT_DOUBLE_EQ(scaled.resolution_mm, 0.08);
  EXPECT_DOUBLE_EQ(scaled.workspace_radius_mm, 80);
  EXPECT_DOUBLE_EQ(scaled.peak_force_N, profile.peak_force_N);
}

TEST(Workspace, LeftHandIsMirrored) {
  // A rotation of 20 degrees to the right about the up axis becomes 20 degrees to the left.
  const Quat right = kFacingPatient * glm::angleAxis(0.35, Vec3{0, 1, 0});
  const Quat left = kFacingPatient * glm::angleAxis(-0.35, Vec3{0, 1, 0});
  EXPECT_LT(CalcAngle(MirrorForLeftHand(right), left), 1e-14);
  // An upward tilt does not change.
  const Quat tilted = kFacingPatient * glm::angleAxis(0.35, Vec3{1, 0, 0});
  EXPECT_LT(CalcAngle(MirrorForLeftHand(tilted), tilted), 1e-14);
  EXPECT_EQ(SwapButtons(0b0001u, 0, 3), 0b1000u);
  EXPECT_EQ(SwapButtons(0b1110u, 0, 3), 0b0111u);
  EXPECT_EQ(SwapButtons(SwapButtons(0b1010u, 0, 3), 0, 3), 0b1010u);
}

TEST(Workspace, RefusesInvalidParameters) {
  EXPECT_THROW(Workspace({0, kFacingPatient, Vec3{0}, false}), Error);
  EXPECT_THROW(Workspace({std::nan(""), kFacingPatient, Vec3{0}, false}), Error);
  EXPECT_THROW(Workspace({1, Quat{0, 0, 0, 0}, Vec3{0}, false}), Error);
}

}  // namespace
}  // namespace kerf
