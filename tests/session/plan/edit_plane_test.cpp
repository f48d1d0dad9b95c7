#include "session/plan/edit_plane.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "kerf/error.h"
#include "perfect_cut.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::HasSubstr;

// Sums of a few products of coordinates up to 50 mm: rounding errors of doubles.
constexpr double kRounding = 1e-11;

PlannedPlane AnyPlane(plan_test::Draw& draw) {
  return {.name = "p",
          .plane = {{draw.In(-50, 50), draw.In(-50, 50), draw.In(-50, 50)}, draw.Direction()},
          .margin_mm = draw.In(0.1, 3),
          .width_mm = draw.In(5, 80),
          .height_mm = draw.In(5, 80),
          .up_W = draw.Direction()};
}

double Distance(const Vec3& a, const Vec3& b) {
  return glm::length(a - b);
}

TEST(PlaneAxes, AreARightHandedFrameWithTheHeightInThePlane) {
  plan_test::Draw draw(11);
  for (int i = 0; i < 200; ++i) {
    PlannedPlane plane = AnyPlane(draw);
    if (i % 4 == 0) plane.up_W = (i % 8 == 0 ? 3.0 : -3.0) * plane.plane.normal_W;  // no part of it lies in the plane
    const PlaneAxes axes = CalcPlaneAxes(plane);
    EXPECT_NEAR(glm::length(axes.up_W), 1, kRounding);
    EXPECT_NEAR(glm::dot(axes.up_W, axes.normal_W), 0, kRounding);
    EXPECT_NEAR(Distance(glm::cross(axes.across_W, axes.up_W), plane.plane.normal_W), 0, kRounding);
    if (i % 4 != 0) {
      EXPECT_GT(glm::dot(axes.up_W, plane.up_W), 0);
    }
    const auto corners = CalcPlaneCorners(plane);
    EXPECT_NEAR(Distance(corners[0], corners[1]), plane.width_mm, kRounding);
    EXPECT_NEAR(Distance(corners[1], corners[2]), plane.height_mm, kRounding);
    EXPECT_NEAR(Distance(0.5 * (corners[0] + corners[2]), plane.plane.p_W), 0, kRounding);
  }
}

TEST(MovePlane, MovesAlongItsAxesAndBack) {
  plan_test::Draw draw(12);
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const Vec3 move(draw.In(-5, 5), draw.In(-5, 5), draw.In(-5, 5));
    const PlannedPlane moved = MovePlane(plane, move);
    const Vec3 d = moved.plane.p_W - plane.plane.p_W;
    const PlaneAxes axes = CalcPlaneAxes(plane);
    EXPECT_NEAR(glm::dot(d, axes.across_W), move.x, kRounding);
    EXPECT_NEAR(glm::dot(d, axes.up_W), move.y, kRounding);
    EXPECT_NEAR(glm::dot(d, plane.plane.normal_W), move.z, kRounding);
    EXPECT_EQ(moved.plane.normal_W, plane.plane.normal_W);
    EXPECT_NEAR(Distance(MovePlane(moved, -move).plane.p_W, plane.plane.p_W), 0, kRounding);
  }
}

TEST(TiltPlane, RotatesAboutItsAxesByTheAngle) {
  plan_test::Draw draw(13);
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const PlaneAxes axes = CalcPlaneAxes(plane);
    const double angle = draw.In(-170, 170);
    const double c = std::cos(angle / kDegreesPerRad);
    const double s = std::sin(angle / kDegreesPerRad);
    // Counter-clockwise about across: up turns towards the normal, and the normal away from up.
    const PlaneAxes across = CalcPlaneAxes(TiltPlane(plane, angle, 0));
    EXPECT_NEAR(Distance(across.normal_W, c * axes.normal_W - s * axes.up_W), 0, kRounding);
    EXPECT_NEAR(Distance(across.across_W, axes.across_W), 0, kRounding);
    const PlaneAxes up = CalcPlaneAxes(TiltPlane(plane, 0, angle));
    EXPECT_NEAR(Distance(up.normal_W, c * axes.normal_W + s * axes.across_W), 0, kRounding);
    EXPECT_NEAR(Distance(up.up_W, axes.up_W), 0, kRounding);
    EXPECT_EQ(TiltPlane(plane, 20, 30).plane.p_W, plane.plane.p_W);
  }
}

TEST(PlaneFields, RoundTrip) {
  plan_test::Draw draw(14);
  for (int i = 0; i < 300; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const PlaneFields fields = CalcPlaneFields(plane);
    // The nearest of the patient's planes is at most acos(1 / sqrt(3)) away, so that no tangent exceeds sqrt(2)...
    EXPECT_LE(std::abs(fields.pitch_deg), 45 + 1e-9);
    EXPECT_LE(std::abs(fields.roll_deg), 45 + 1e-9);
    const PlannedPlane again = SetPlaneFields(plane, fields);
    EXPECT_NEAR(Distance(again.plane.normal_W, plane.plane.normal_W), 0, kRounding);
    EXPECT_EQ(again.plane.p_W, plane.plane.p_W);
    EXPECT_NEAR(Distance(CalcPlaneAxes(again).up_W, CalcPlaneAxes(plane).up_W), 0, 1e-7);
    // From another plane, also one with the opposite normal, the same fields give the same plane.
    PlannedPlane other = AnyPlane(draw);
    if (i % 3 == 0) other.plane.normal_W = -plane.plane.normal_W;
    other = SetPlaneFields(other, fields);
    EXPECT_NEAR(Distance(other.plane.normal_W, plane.plane.normal_W), 0, kRounding);
    EXPECT_NEAR(glm::dot(CalcPlaneAxes(other).up_W, other.plane.normal_W), 0, kRounding);
    for (int r = 0; r < 3; ++r) {
      const PlaneFields seen = CalcPlaneFields(plane, static_cast<PatientPlane>(r));
      if (std::max(std::abs(seen.pitch_deg), std::abs(seen.roll_deg)) > 88) continue;
      EXPECT_NEAR(Distance(SetPlaneFields(other, seen).plane.normal_W, plane.plane.normal_W), 0, 1e-10);
    }
  }
}

TEST(PlaneFields, KeepTheirReferenceWhileThePlaneIsEdited) {
  PlannedPlane plane{.name = "p", .plane = {{20, -70, 35}, {0, 0, 1}}};
  plane.reference = ChooseReference(plane);
  EXPECT_EQ(plane.reference, PatientPlane::kAxial);
  PlaneFields fields = CalcPlaneFields(plane);
  fields.pitch_deg = 60;
  plane = SetPlaneFields(plane, fields);
  // The sagittal plane is nearer now: 30 degrees.
  const auto expect_60 = [&](const PlannedPlane& p, double sign) {
    const PlaneFields seen = CalcPlaneFields(p);
    EXPECT_EQ(seen.reference, PatientPlane::kAxial);
    EXPECT_NEAR(seen.pitch_deg, sign * 60, 1e-9);  // degrees; rounding only
    EXPECT_NEAR(seen.roll_deg, 0, 1e-9);
  };
  expect_60(plane, 1);
  expect_60(MovePlane(plane, {3, -2, 1}), 1);
  expect_60(MirrorPlane({}, plane, 0), -1);
  // A plane that is perpendicular to its reference has no angles to it: another reference is chosen.
  plane.plane.normal_W = {1, 0, 0};
  EXPECT_EQ(CalcPlaneFields(plane).reference, PatientPlane::kSagittal);
}

TEST(PlaneFields, AreThePatientsAngles) {
  PlannedPlane plane{.name = "p", .plane = {{1, 2, 3}, {1, 0, 0}}};
  EXPECT_EQ(CalcPlaneFields(plane).reference, PatientPlane::kSagittal);
  // Pitch turns the normal from the left towards the back, roll towards the head.
  const double t = std::tan(20 / kDegreesPerRad);
  const PlannedPlane pitched = SetPlaneFields(plane, {.p_W_mm = {1, 2, 3}, .pitch_deg = 20});
  EXPECT_NEAR(Distance(pitched.plane.normal_W, glm::normalize(Vec3(1, t, 0))), 0, kRounding);
  const PlannedPlane rolled = SetPlaneFields(plane, {.p_W_mm = {1, 2, 3}, .roll_deg = 20});
  EXPECT_NEAR(Distance(rolled.plane.normal_W, glm::normalize(Vec3(1, 0, t))), 0, kRounding);
  plane.plane.normal_W = {0, 0, -1};
  EXPECT_EQ(CalcPlaneFields(plane).reference, PatientPlane::kAxial);
  EXPECT_TRUE(CalcPlaneFields(plane).reversed);
  EXPECT_THAT(MessageOf([&] { SetPlaneFields(plane, {.pitch_deg = 89.5}); }),
              HasSubstr("pitch_deg = 89.5 is above 89"));
  EXPECT_THAT(MessageOf([&] { SetPlaneFields(plane, {.p_W_mm = {0, 2e6, 0}}); }), HasSubstr("point_mm"));
}

TEST(MirrorPlane, IsAReflection) {
  plan_test::Draw draw(15);
  Plan plan;
  for (int i = 0; i < 50; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const double mid = draw.In(-5, 5);
    const PlannedPlane mirrored = MirrorPlane(plan, plane, mid);
    const auto corners = CalcPlaneCorners(plane);
    const auto opposite = CalcPlaneCorners(mirrored);
    // The reflection exchanges left and right of the rectangle.
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 0}, {2, 3}, {3, 2}}) {
      const Vec3 p = corners[static_cast<std::size_t>(a)];
      EXPECT_NEAR(Distance(opposite[static_cast<std::size_t>(b)], {2 * mid - p.x, p.y, p.z}), 0, kRounding);
    }
    const PlannedPlane back = MirrorPlane(plan, mirrored, mid);
    EXPECT_NEAR(Distance(back.plane.p_W, plane.plane.p_W), 0, kRounding);
    EXPECT_EQ(back.plane.normal_W, plane.plane.normal_W);
  }
  plan.planes.push_back({.name = "plane 1", .state = PlaneState::kDone});
  plan.planes.push_back(MirrorPlane(plan, plan.planes[0], 0));
  EXPECT_EQ(plan.planes[1].name, "plane 1 mirrored");
  EXPECT_EQ(plan.planes[1].state, PlaneState::kPlanned);
  EXPECT_EQ(MirrorPlane(plan, plan.planes[0], 0).name, "plane 1 mirrored 2");
}

TEST(PlaneNames, StayUniqueAndShort) {
  Plan plan;
  plan.planes = {{.name = "a"}, {.name = "b"}};
  RenamePlane(plan, 0, "c");
  EXPECT_EQ(plan.planes[0].name, "c");
  RenamePlane(plan, 0, "c");
  EXPECT_THAT(MessageOf([&] { RenamePlane(plan, 0, "b"); }), HasSubstr("another plane of the plan is named 'b'"));
  EXPECT_THAT(MessageOf([&] { RenamePlane(plan, 0, ""); }), HasSubstr("must not be empty"));
  EXPECT_THAT(MessageOf([&] { RenamePlane(plan, 2, "d"); }), HasSubstr("has no plane 3"));
  // 60 characters of two bytes each are allowed, 61 are not.
  std::string wide;
  for (int i = 0; i < 60; ++i) wide += "ä";
  RenamePlane(plan, 0, wide);
  EXPECT_THAT(MessageOf([&] { RenamePlane(plan, 0, wide + "a"); }), HasSubstr("at most 60 characters"));
  EXPECT_EQ(MakeUniquePlaneName(plan, wide + "more"), wide.substr(0, 116) + " 2");
}

TEST(ReorderPlane, KeepsTheOrderOfTheOthers) {
  const auto names = [](const Plan& plan) {
    std::string all;
    for (const PlannedPlane& p : plan.planes) all += p.name;
    return all;
  };
  for (std::size_t from = 0; from < 5; ++from) {
    for (std::size_t to = 0; to < 5; ++to) {
      Plan plan;
      for (const char* name : {"a", "b", "c", "d", "e"}) plan.planes.push_back({.name = name});
      std::string expected = "abcde";
      const std::string moved(1, expected[from]);
      expected.erase(from, 1);
      expected.insert(to, moved);
      ReorderPlane(plan, from, to);
      EXPECT_EQ(names(plan), expected);
    }
  }
  Plan plan;
  EXPECT_THAT(MessageOf([&] { ReorderPlane(plan, 0, 0); }), HasSubstr("has 0 planes"));
}

/// Returns a line of sight through p.
SightLine Through(const Vec3& p, const Vec3& direction) {
  return {.p_W = p - 100.0 * direction, .direction_W = 2.0 * direction};
}

/// Draws a direction that is inclined to the plane and to its normal.
Vec3 DrawSight(plan_test::Draw& draw, const Vec3& normal) {
  while (true) {
    const Vec3 d = draw.Direction();
    const double sine = std::abs(glm::dot(d, normal));
    if (sine > 0.2 && sine < 0.95) return d;
  }
}

TEST(DragHandle, FollowsTheMouseInTheAllowedDirections) {
  plan_test::Draw draw(16);
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const PlaneAxes axes = CalcPlaneAxes(plane);
    const Vec3 sight = DrawSight(draw, axes.normal_W);
    const std::vector<PlaneHandle> handles = PlaneHandles(plane);
    ASSERT_EQ(handles.size(), 8u);
    for (const PlaneHandle& handle : handles) {
      const SightLine from = Through(handle.p_W, sight);
      // No motion of the mouse, no motion of the plane.
      EXPECT_NEAR(Distance(DragHandle(plane, handle, from, from).plane.p_W, plane.plane.p_W), 0, 1e-10);
      EXPECT_NEAR(Distance(DragHandle(plane, handle, from, from).plane.normal_W, plane.plane.normal_W), 0, kRounding);
      const double a = draw.In(-2, 2);
      const double b = draw.In(-2, 2);
      const bool in_plane = handle.kind == PlaneHandleKind::kCentre || handle.kind == PlaneHandleKind::kCorner;
      const Vec3 wanted = handle.p_W + (in_plane ? a * axes.across_W + b * axes.up_W : a * axes.normal_W);
      const PlannedPlane dragged = DragHandle(plane, handle, from, Through(wanted, sight));
      switch (handle.kind) {
        case PlaneHandleKind::kCentre:
        case PlaneHandleKind::kNormal:
          // The handle is under the mouse again, and nothing else has changed.
          EXPECT_NEAR(Distance(dragged.plane.p_W - plane.plane.p_W, wanted - handle.p_W), 0, 1e-9);
          EXPECT_EQ(dragged.plane.normal_W, plane.plane.normal_W);
          break;
        case PlaneHandleKind::kCorner: {
          const auto corners = CalcPlaneCorners(dragged);
          EXPECT_NEAR(Distance(corners[static_cast<std::size_t>(handle.corner)], wanted), 0, 1e-9);
          const std::size_t opposite = static_cast<std::size_t>(handle.corner + 2) % 4;
          EXPECT_NEAR(Distance(corners[opposite], CalcPlaneCorners(plane)[opposite]), 0, 1e-9);
          break;
        }
        default: {
          // The edge points to where the mouse is; its own length does not change.
          const Vec3 arm = wanted - plane.plane.p_W;
          const bool upper = handle.kind == PlaneHandleKind::kTiltAcross;
          const PlaneAxes now = CalcPlaneAxes(dragged);
          EXPECT_NEAR(Distance(upper ? now.up_W : now.across_W, glm::normalize(arm)), 0, 1e-9);
          EXPECT_NEAR(Distance(upper ? now.across_W : now.up_W, upper ? axes.across_W : axes.up_W), 0, 1e-9);
          EXPECT_EQ(dragged.plane.p_W, plane.plane.p_W);
        }
      }
    }
  }
}

TEST(DragHandle, DoesNothingIfTheSightDoesNotTellTheMotion) {
  const PlannedPlane plane{
      .name = "p", .plane = {{0, 0, 0}, {0, 0, 1}}, .width_mm = 20, .height_mm = 20, .up_W = {0, 1, 0}};
  const std::vector<PlaneHandle> handles = PlaneHandles(plane);
  // Along the plane, the centre and the corners; along the normal, the others.
  for (const PlaneHandle& handle : handles) {
    const bool in_plane = handle.kind == PlaneHandleKind::kCentre || handle.kind == PlaneHandleKind::kCorner;
    const Vec3 sight = in_plane ? Vec3(0.99, 0, 0.01) : Vec3(0.01, 0, -0.99);
    const PlannedPlane dragged =
        DragHandle(plane, handle, Through(handle.p_W, sight), Through(handle.p_W + Vec3(1, 2, 3), sight));
    EXPECT_EQ(dragged.plane.p_W, plane.plane.p_W);
    EXPECT_EQ(dragged.plane.normal_W, plane.plane.normal_W);
    EXPECT_EQ(dragged.width_mm, 20);
  }
  // A corner that is dragged beyond the opposite one stops at the smallest size.
  const PlaneHandle corner = handles[6];
  const PlannedPlane small =
      DragHandle(plane, corner, Through(corner.p_W, {0, 0, -1}), Through({-50, -50, 0}, {0, 0, -1}));
  EXPECT_EQ(small.width_mm, kPlaneSizeRange_mm.lower);
  EXPECT_NEAR(Distance(CalcPlaneCorners(small)[0], CalcPlaneCorners(plane)[0]), 0, kRounding);
}

}  // namespace
}  // namespace kerf
