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

TEST(TurnPlane, TurnsAboutOneAxisAndBack) {
  plan_test::Draw draw(14);
  for (int i = 0; i < 300; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    const PlaneAxes axes = CalcPlaneAxes(plane);
    const double angle_deg = draw.In(-360, 360);
    for (const PlaneAxis axis : {PlaneAxis::kAcross, PlaneAxis::kUp, PlaneAxis::kNormal}) {
      const PlannedPlane turned = TurnPlane(plane, axis, angle_deg);
      const PlaneAxes now = CalcPlaneAxes(turned);
      const auto own = [axis](const PlaneAxes& a) {
        return axis == PlaneAxis::kAcross ? a.across_W : axis == PlaneAxis::kUp ? a.up_W : a.normal_W;
      };
      EXPECT_NEAR(Distance(own(now), own(axes)), 0, kRounding);
      EXPECT_EQ(turned.plane.p_W, plane.plane.p_W);
      EXPECT_EQ(turned.width_mm, plane.width_mm);
      // The others have turned by the angle.
      const double cosine = std::cos(angle_deg / kDegreesPerRad);
      if (axis != PlaneAxis::kNormal) {
        EXPECT_NEAR(glm::dot(now.normal_W, axes.normal_W), cosine, kRounding);
      }
      if (axis != PlaneAxis::kUp) {
        EXPECT_NEAR(glm::dot(now.up_W, axes.up_W), cosine, kRounding);
      }
      const PlaneAxes back = CalcPlaneAxes(TurnPlane(turned, axis, -angle_deg));
      EXPECT_NEAR(Distance(back.normal_W, axes.normal_W), 0, kRounding);
      EXPECT_NEAR(Distance(back.up_W, axes.up_W), 0, kRounding);
    }
  }
}

TEST(PatientAngles, AreThoseBetweenThePlanes) {
  plan_test::Draw draw(15);
  for (int i = 0; i < 300; ++i) {
    // In the way of its creation, a plane may have any height direction and either normal.
    PlannedPlane plane = AnyPlane(draw);
    const PatientAngles angles = CalcPatientAngles(plane);
    const Vec3& n = plane.plane.normal_W;
    EXPECT_NEAR(std::cos(angles.sagittal_deg / kDegreesPerRad), std::abs(n.x), kRounding);
    EXPECT_NEAR(std::cos(angles.coronal_deg / kDegreesPerRad), std::abs(n.y), kRounding);
    EXPECT_NEAR(std::cos(angles.axial_deg / kDegreesPerRad), std::abs(n.z), kRounding);
    plane.up_W = draw.Direction();
    plane.plane.normal_W = -n;
    const PatientAngles same = CalcPatientAngles(plane);
    EXPECT_EQ(same.sagittal_deg, angles.sagittal_deg);
    EXPECT_EQ(same.coronal_deg, angles.coronal_deg);
    EXPECT_EQ(same.axial_deg, angles.axial_deg);
  }
}

TEST(PatientAngles, FollowATurnThroughAllAngles) {
  // An axial plane that is turned about its width, which lies across the patient, becomes coronal and goes on.
  const PlannedPlane axial = AlignPlane({.name = "p", .plane = {{20, -70, 35}, {0, 0.1, 0.9}}}, PatientPlane::kAxial);
  for (double turn_deg = -180; turn_deg <= 180; turn_deg += 7.5) {
    const PatientAngles angles = CalcPatientAngles(TurnPlane(axial, PlaneAxis::kAcross, turn_deg));
    const double to_axial_deg = std::min(std::abs(turn_deg), 180 - std::abs(turn_deg));
    EXPECT_NEAR(angles.axial_deg, to_axial_deg, 1e-9) << turn_deg;  // degrees; rounding only
    EXPECT_NEAR(angles.coronal_deg, 90 - to_axial_deg, 1e-9) << turn_deg;
    EXPECT_NEAR(angles.sagittal_deg, 90, 1e-9) << turn_deg;
  }
}

TEST(AlignPlane, IsParallelToThePatientsPlane) {
  plan_test::Draw draw(16);
  for (int i = 0; i < 100; ++i) {
    const PlannedPlane plane = AnyPlane(draw);
    for (int r = 0; r < 3; ++r) {
      const PlannedPlane aligned = AlignPlane(plane, static_cast<PatientPlane>(r));
      const Vec3& n = aligned.plane.normal_W;
      EXPECT_EQ(std::abs(n[r]), 1);
      EXPECT_EQ(glm::length(n), 1);
      EXPECT_GE(glm::dot(n, plane.plane.normal_W), 0);
      EXPECT_EQ(glm::dot(n, aligned.up_W), 0);
      EXPECT_EQ(aligned.plane.p_W, plane.plane.p_W);
      EXPECT_EQ(aligned.height_mm, plane.height_mm);
      // A plane that is parallel already keeps its rectangle.
      const PlannedPlane again = AlignPlane(aligned, static_cast<PatientPlane>(r));
      EXPECT_EQ(again.plane.normal_W, n);
      EXPECT_EQ(again.up_W, aligned.up_W);
    }
  }
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
