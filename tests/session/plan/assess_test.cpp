#include "session/plan/assess.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kerf/simulation.h"
#include "perfect_cut.h"

namespace kerf {
namespace {

using namespace plan_test;

/// A cut in the block's frame, where the plan is x = 0. The cut is moved by `offset`, rolled about y by `roll_deg`, and
/// pitched by `pitch_deg`. The kerf is `depth` deep from the top face.
struct Case {
  double offset;
  double roll_deg;
  double pitch_deg;
  double depth;
};

Assessment AssessCase(const Pose& X, const Case& c, double margin_mm = 1) {
  const Bone before = MakeBlock(BlockAt(X, 0.2), test::OneRegionTable());
  Bone after = before;
  // The cut is x = offset - tan(roll) z - tan(pitch) y, relative to the face's middle at half depth. The depth is along
  // -z, so the offset grows with it by tan(roll); normal x depth = x cross -z = y, so it grows along y by tan(pitch).
  const double roll = std::tan(c.roll_deg / kDegrees);
  const double pitch = std::tan(c.pitch_deg / kDegrees);
  const Vec3 n = glm::normalize(Vec3(1, -pitch, roll));
  const Vec3 p(c.offset, 0, -0.5 * c.depth);
  Subtract(after, [&](const Vec3& p_W) {
    const Vec3 q = X.InversePoint(p_W);
    return std::max(std::abs(glm::dot(n, q - p)) - 0.2, -q.z - c.depth);
  });
  Plan plan;
  plan.planes.push_back({.name = "cut", .plane = {X.Point({0, 0, 0}), X.Vector({1, 0, 0})}, .margin_mm = margin_mm});
  plan.stops.push_back(
      {.name = "stop", .p_W_mm = X.Point({0, 0, 0}), .direction_W = X.Vector({0, 0, -1}), .depth_mm = 4});
  return AssessCut(plan, before, after, 0.4);
}

TEST(AssessCut, MeasuresInjectedErrors) {
  Draw draw(1);
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE(i);
    const Pose X = draw.AnyPose();
    const Case c{draw.In(-1.5, 1.5), draw.In(-8, 8), draw.In(-8, 8), draw.In(3, 6)};
    const Assessment out = AssessCase(X, c);
    ASSERT_EQ(out.planes.size(), 1u);
    const PlaneResult& plane = out.planes[0];
    ASSERT_TRUE(plane.cut);
    // The centres are found starting 1.25 voxels inside the bone, so the kerf's centre is slightly deeper than half the
    // depth.
    const double shift = std::abs(std::tan(c.roll_deg / kDegrees)) * 0.2;
    EXPECT_NEAR(plane.offset_mm, c.offset, 0.1 + shift);
    EXPECT_NEAR(plane.angles.roll_deg, c.roll_deg, 0.2);
    EXPECT_NEAR(plane.angles.pitch_deg, c.pitch_deg, 0.2);
    EXPECT_GE(std::abs(plane.furthest_mm), std::abs(plane.offset_mm) - 1e-9);
    EXPECT_EQ(plane.within_margin, std::abs(plane.furthest_mm) <= 1);
    ASSERT_TRUE(out.stops[0].depth_mm);
    EXPECT_NEAR(*out.stops[0].depth_mm, c.depth, 0.05);
    EXPECT_NEAR(out.stops[0].over_mm, c.depth - 4, 0.05);
    EXPECT_NEAR(out.removed_mm3, out.before_mm3 - out.after_mm3, 1e-9);
    EXPECT_NEAR(out.removed_mm3, 0.4 * 10 * c.depth / std::cos(plane.angles.angle_deg / kDegrees), 0.5);
    // Cells are counted by their centres, so the result is accurate to half a voxel at the stop's face.
    EXPECT_NEAR(*out.too_deep_mm3, 0.4 * 10 * std::max(0.0, c.depth - 4), 0.5 * 0.2 * 0.4 * 10 * 1.2);
  }
}

TEST(AssessCut, CountsVolumeBeyondTheMargin) {
  // With an offset of 2 mm, all of the cut is outside a margin of 1 mm plus half a blade. With a margin of 3 mm nothing
  // is outside.
  const Assessment off = AssessCase({}, {2, 0, 0, 4});
  EXPECT_NEAR(*off.outside_mm3, off.removed_mm3, 1e-6);
  EXPECT_FALSE(off.planes[0].within_margin);
  const Assessment wide = AssessCase({}, {2, 0, 0, 4}, 3);
  EXPECT_EQ(*wide.outside_mm3, 0);
  EXPECT_TRUE(wide.planes[0].within_margin);
}

TEST(AssessCut, NoCutOrNoPlanGivesNoResults) {
  const Bone bone = MakeBlock(BlockAt({}, 0.25), test::OneRegionTable());
  Plan plan;
  Assessment out = AssessCut(plan, bone, bone, 0.4);
  EXPECT_EQ(out.removed_mm3, 0);
  EXPECT_FALSE(out.outside_mm3);
  EXPECT_FALSE(out.too_deep_mm3);
  plan.planes.push_back({.name = "cut", .plane = {{0, 0, 0}, {1, 0, 0}}, .margin_mm = 1});
  plan.stops.push_back({.name = "stop", .p_W_mm = {0, 0, 0}, .direction_W = {0, 0, -1}, .depth_mm = 4});
  out = AssessCut(plan, bone, bone, 0.4);
  EXPECT_FALSE(out.planes[0].cut);
  EXPECT_FALSE(out.stops[0].depth_mm);
  EXPECT_TRUE(MakeCutMarkups(out).empty());
}

TEST(AssessCut, ThroughCutIsAsDeepAsTheBone) {
  const Pose X{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {3, 2, 1}};
  const Bone before = MakeBlock(BlockAt(X, 0.2), test::OneRegionTable());
  Bone after = before;
  CutKerf(after, {X.Point({0, 0, -4}), X.Vector({1, 0, 0})}, 0.4);
  Plan plan;
  plan.stops.push_back({.name = "s", .p_W_mm = X.p_AB, .direction_W = X.Vector({0, 0, -1}), .depth_mm = 9});
  const Assessment out = AssessCut(plan, before, after, 0.4);
  ASSERT_TRUE(out.stops[0].depth_mm);
  EXPECT_NEAR(*out.stops[0].depth_mm, 8, 0.05);
}

/// With two planes and two cuts, each cut is measured against its own plane.
TEST(AssessCut, DistinguishesTwoPlanes) {
  const Bone before = MakeBlock(BlockAt({}, 0.2), test::OneRegionTable());
  Bone after = before;
  CutKerf(after, {{-3.7, 0, 0}, {1, 0, 0}}, 0.4);
  CutKerf(after, {{4.2, 0, 0}, {1, 0, 0}}, 0.4);
  Plan plan;
  plan.planes.push_back({.name = "a", .plane = {{-4, 0, -4}, {1, 0, 0}}, .margin_mm = 1});
  plan.planes.push_back({.name = "b", .plane = {{4, 0, -4}, {-1, 0, 0}}, .margin_mm = 1});
  const Assessment out = AssessCut(plan, before, after, 0.4);
  EXPECT_NEAR(out.planes[0].offset_mm, 0.3, 0.02);
  EXPECT_NEAR(out.planes[1].offset_mm, -0.2, 0.02);
  EXPECT_LT(out.planes[1].cut->normal_W.x, 0);
  EXPECT_EQ(MakeCutMarkups(out)[1].name, "b, as cut");
}

/// A planned plane and the kerf that was cut for it, both exact, in the frame of the block.
struct CornerCut {
  PlannedPlane planned;
  CutPlane cut;
  Vec3 along;      // direction in the cut from where the two planes meet
  double from_mm;  // the kerf begins at this distance along it
};

/// Returns a cut that begins at `from_mm` along a direction that is `angle_deg` above x, and its plan, which differs by
/// `off_mm` and a rotation about y by `tilt_deg`. The planes meet at the line x = 0, z = -6, which is parallel to y.
CornerCut MakeCornerCut(double angle_deg, double from_mm, double to_mm, double off_mm, double tilt_deg) {
  const auto direction = [](double deg) { return Vec3(std::cos(deg / kDegrees), 0, std::sin(deg / kDegrees)); };
  const Vec3 meeting(0, 0, -6);
  CornerCut corner;
  corner.along = direction(angle_deg);
  corner.from_mm = from_mm;
  corner.cut = {meeting, glm::cross(corner.along, Vec3(0, 1, 0))};
  const Vec3 planned_along = direction(angle_deg - tilt_deg);
  const Vec3 planned_normal = glm::cross(planned_along, Vec3(0, 1, 0));
  const Vec3 middle = meeting + 0.5 * (from_mm + to_mm) * corner.along;
  corner.planned = {.name = "",
                    .plane = {middle - off_mm * planned_normal, planned_normal},
                    .margin_mm = 1,
                    .width_mm = to_mm - from_mm,
                    .height_mm = 10,
                    .up_W = {0, 1, 0}};
  return corner;
}

/// Cuts two kerfs of a block, and compares them with their plans. `round_ends`: as a bur leaves them.
Assessment AssessCorner(const Pose& X, double voxel_mm, const CornerCut (&cuts)[2], double width_mm, bool round_ends) {
  BlockParams block = BlockAt(X, voxel_mm);
  block.size_mm = {24, 10, 12};
  const Bone before = MakeBlock(block, test::OneRegionTable());
  Bone after = before;
  Plan plan;
  for (const CornerCut& cut : cuts) {
    Subtract(after, [&](const Vec3& p_W) {
      const Vec3 d = X.InversePoint(p_W) - cut.cut.p_W;
      const double off_mm = std::abs(glm::dot(cut.cut.normal_W, d));
      const double before_mm = cut.from_mm - glm::dot(cut.along, d);
      return round_ends ? std::hypot(off_mm, std::max(before_mm, 0.0)) - 0.5 * width_mm
                        : std::max(off_mm - 0.5 * width_mm, before_mm);
    });
    PlannedPlane planned = cut.planned;
    planned.name = MakePlaneName(plan);
    planned.plane = {X.Point(planned.plane.p_W), X.Vector(planned.plane.normal_W)};
    planned.up_W = X.Vector(planned.up_W);
    plan.planes.push_back(planned);
  }
  return AssessCut(plan, before, after, width_mm);
}

// Two exact cuts that end where they meet, or cross there. The least-squares plane of exact midpoints is that of the
// cut. Where the kerfs join, up to a few voxels of bone between them are missing, which moves a few of the hundreds of
// midpoints by less than half a voxel.
TEST(AssessCut, MeasuresPlanesThatMeetAtAnyAngle) {
  Draw draw(3);
  for (const double angle_deg : {15.0, 20.0, 90.0}) {
    for (const bool crosses : {false, true}) {
      for (int i = 0; i < 2; ++i) {
        SCOPED_TRACE(fmt::format("{} degrees, {}, pose {}", angle_deg, crosses ? "crossing" : "ending there", i));
        const Pose X = draw.AnyPose();
        const double from_mm = crosses ? -12 : 0;
        const double to_mm = angle_deg == 90 ? 6 : 12;
        const double tilt_deg[2] = {draw.In(-1.5, 1.5), draw.In(-1.5, 1.5)};
        const double off_mm[2] = {draw.In(-0.3, 0.3), draw.In(-0.3, 0.3)};
        const CornerCut cuts[2] = {
            MakeCornerCut(180, from_mm, 12, off_mm[0], tilt_deg[0]),
            MakeCornerCut(angle_deg, crosses && angle_deg == 90 ? -6 : from_mm, to_mm, off_mm[1], tilt_deg[1])};
        const Assessment out = AssessCorner(X, 0.2, cuts, 0.4, false);
        for (std::size_t k = 0; k < 2; ++k) {
          SCOPED_TRACE(k);
          const PlaneResult& plane = out.planes[k];
          ASSERT_TRUE(plane.cut);
          EXPECT_LT(CalcAngle(plane.cut->normal_W, X.Vector(cuts[k].cut.normal_W)), 0.2);
          EXPECT_NEAR(plane.angles.angle_deg, std::abs(tilt_deg[k]), 0.2);
          // Distance of the kerf's own centre from the plan.
          const double along_mm = glm::dot(cuts[k].along, X.InversePoint(plane.cut->p_W_mm) - cuts[k].cut.p_W) -
                                  0.5 * (cuts[k].from_mm + (k == 0 ? 12 : to_mm));
          EXPECT_NEAR(plane.offset_mm, off_mm[k] + along_mm * std::sin(tilt_deg[k] / kDegrees), 0.05);
          EXPECT_NEAR(along_mm, 0, 1.5);
        }
      }
    }
  }
}

// Slots of a bur, wide compared with the voxels, that meet at an end. `angle_deg` is from the first slot's continuation
// to the second slot: between the slots, 120, 90, 60 and 30 degrees of bone are left.
TEST(AssessCut, MeasuresSlotsOfABurThatMeet) {
  Draw draw(5);
  for (const auto& [width_mm, voxel_mm] : {std::pair(2.1, 0.2), std::pair(1.6, 0.3)}) {
    for (const double angle_deg : {60.0, 90.0, 120.0, 150.0}) {
      for (int i = 0; i < 3; ++i) {
        SCOPED_TRACE(fmt::format("{} mm in voxels of {} mm, {} degrees, pose {}", width_mm, voxel_mm, angle_deg, i));
        const double tilt_deg[2] = {draw.In(-1.5, 1.5), draw.In(-1.5, 1.5)};
        const CornerCut cuts[2] = {
            MakeCornerCut(180, 0, 12, draw.In(-0.3, 0.3), tilt_deg[0]),
            MakeCornerCut(angle_deg, 0, 6 / std::sin(angle_deg / kDegrees), draw.In(-0.3, 0.3), tilt_deg[1])};
        const Pose X = draw.AnyPose();
        const Assessment out = AssessCorner(X, voxel_mm, cuts, width_mm, true);
        for (std::size_t k = 0; k < 2; ++k) {
          SCOPED_TRACE(k);
          ASSERT_TRUE(out.planes[k].cut);
          EXPECT_LT(CalcAngle(out.planes[k].cut->normal_W, X.Vector(cuts[k].cut.normal_W)), 0.2);
          EXPECT_NEAR(out.planes[k].angles.angle_deg, std::abs(tilt_deg[k]), 0.2);
          const Vec3 centre = X.InversePoint(out.planes[k].cut->p_W_mm);
          EXPECT_NEAR(glm::dot(cuts[k].cut.normal_W, centre - cuts[k].cut.p_W), 0, 0.05);
        }
      }
    }
  }
}

}  // namespace
}  // namespace kerf
