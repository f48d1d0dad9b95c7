// The volume that a bur or a drill on a path removes, and its force, compared with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

constexpr double kRoundRpm = 30000;
constexpr double kRoundFeed = 10;  // mm/s

struct RoundCut {
  double removed_mm3 = 0;  // lost by the bone
  Vec3 force_B_N{0};       // mean over the middle part
  Bone bone;               // that is left
};

/// Moves a tool with its axis along the block's z from one place to another; the top of the block is z = 0. The force
/// is the mean from `from` to `to`, as fractions of the way.
RoundCut MoveRound(const Tool& tool, const Pose& X_WB, Bone bone, const Vec3& start_B, const Vec3& end_B, double from,
                   double to) {
  const double before = bone.CalcVolume();
  SimulationParams params;
  params.tool = tool;
  params.law = ForceLaw("hertz_chip");
  const auto pose = [&](double t) { return Pose{X_WB.R_AB, X_WB.Point(start_B + t * (end_B - start_B))}; };
  Simulation simulation(std::move(bone), params, pose(0));
  const int ticks = static_cast<int>(glm::distance(start_B, end_B) / 0.01);
  RoundCut cut;
  int count = 0;
  for (int i = 1; i <= ticks; ++i) {
    const double t = static_cast<double>(i) / ticks;
    const TickOutput out = simulation.Tick({pose(t), 0.01 / kRoundFeed, kRoundRpm});
    if (t < from || t > to) continue;
    cut.force_B_N += X_WB.InverseVector(out.f_T_W_N);
    ++count;
  }
  cut.force_B_N /= count;
  cut.bone = simulation.UpdateBone();
  cut.removed_mm3 = before - cut.bone.CalcVolume();
  return cut;
}
RoundCut MoveRound(const Tool& tool, const Pose& X_WB, double voxel_mm, const Vec3& start_B, const Vec3& end_B,
                   double from, double to) {
  return MoveRound(tool, X_WB, test::MakeBox({X_WB.R_AB, X_WB.Point({0, 0, -4})}, {14, 6, 8}, voxel_mm), start_B, end_B,
                   from, to);
}

/// Returns the force of one tooth at a bite.
double ToothForceOf(const Tool& tool, double bite_mm) {
  const double E_star = CalcReducedModulus(CalcModulus(tool), CalcPoissonRatio(tool), 19300, 0.28);
  return MakeToothForce(ForceLaw("hertz_chip"), tool)(bite_mm, Cortical(E_star));
}

TEST(RoundClosedForm, ForceOnABurInAGrooveIsTheIntegralOverItsLeadingHalf) {
  // A cylinder of radius r, `depth` deep in bone, moves across its axis. Between the angles phi and phi + dphi from the
  // feed there are flutes depth / (2 pi w) dphi teeth with the bite (v / f) cos(phi) and the force C bite^(3/2), along
  // -e. The sum along the feed is the integral of cos^(5/2).
  FissureBur bur;
  bur.diameter_mm = 2;
  const double depth = 3;
  const double tooth = ToothForceOf(bur, kRoundFeed / (bur.flutes * kRoundRpm / 60));
  const double power = std::beta(1.75, 0.5);
  const double exact = bur.flutes * depth / (2 * std::numbers::pi * bur.tooth_width_mm) * tooth * power;
  double error[2];
  for (const int level : {0, 1}) {
    const double h = level == 0 ? 0.2 : 0.1;
    const RoundCut cut = MoveRound(bur, test::BlockPoses(h)[5], h, {-8.2, 0, -depth}, {8.2, 0, -depth}, 0.35, 0.65);
    // The rings of points are 0.38 mm apart, so the depth is known to a quarter of that; look-ahead at the floor adds
    // teeth of the flat end, which do not bite.
    EXPECT_NEAR(cut.force_B_N.x, -exact, 0.04 * exact) << h;
    EXPECT_NEAR(cut.force_B_N.y, 0, 0.01 * exact);
    EXPECT_NEAR(cut.force_B_N.z, 0, 0.01 * exact);
    error[level] = std::abs(cut.removed_mm3 / (14 * depth * 2) - 1);
    EXPECT_LT(error[level], 0.01);
  }
}

TEST(RoundClosedForm, ThrustOfADrillIsThatOfItsLipsAndTheHoleIsItsOwn) {
  // Each lip is slant / w teeth with the bite (v / f) sin(half the point angle), along the lip's normal; the sum along
  // the feed takes the sine again. The chisel edge bears its share of the whole thrust.
  for (const double point_deg : {90.0, 118.0, 180.0}) {
    TwistDrill drill;
    drill.diameter_mm = 2;
    drill.length_mm = 12;
    drill.point_angle_deg = point_deg;
    drill.chisel_share = point_deg / 400;
    const double sine = std::sin(0.5 * point_deg * std::numbers::pi / 180);
    const double lip_mm = 1 / sine;
    const double exact = 2 * lip_mm / drill.tooth_width_mm *
                         ToothForceOf(drill, kRoundFeed * sine / (2 * kRoundRpm / 60)) * sine /
                         (1 - drill.chisel_share);
    const double tip_mm = point_deg < 180 ? 1 / std::tan(0.5 * point_deg * std::numbers::pi / 180) : 0;
    for (const std::size_t n : {0u, 5u, 7u}) {
      const RoundCut cut = MoveRound(drill, test::BlockPoses(0.1)[n], 0.1, {0.03, 0.02, 0.5}, {0.03, 0.02, -5}, 0.5, 1);
      // All points of the tip are in bone, and none of another face.
      EXPECT_NEAR(cut.force_B_N.z, exact, 0.005 * exact) << point_deg;
      EXPECT_NEAR(std::hypot(cut.force_B_N.x, cut.force_B_N.y), 0, 0.005 * exact);
      const double hole_mm3 = std::numbers::pi * (5 - tip_mm + tip_mm / 3);
      EXPECT_NEAR(cut.removed_mm3 / hole_mm3, 1, 0.01) << point_deg << " " << n;
    }
  }
}

TEST(RoundClosedForm, APilotHoleTakesTheChiselEdgesThrustAway) {
  // The lips cut from the radius of the pilot hole, half of their own, outwards; the chisel edge is over the hole.
  for (const double share : {0.0, 0.45, 0.8}) {
    TwistDrill drill{.diameter_mm = 2, .length_mm = 12, .point_angle_deg = 180, .chisel_share = share};
    const double exact = 1 / drill.tooth_width_mm * ToothForceOf(drill, kRoundFeed / (2 * kRoundRpm / 60));
    const Pose X_WB = test::BlockPoses(0.05)[5];
    const TwistDrill pilot{.diameter_mm = 1, .length_mm = 12};
    RoundCut hole = MoveRound(pilot, X_WB, 0.05, {0, 0, 0.5}, {0, 0, -6}, 0.5, 1);
    const RoundCut cut = MoveRound(drill, X_WB, std::move(hole.bone), {0, 0, 0.5}, {0, 0, -5}, 0.5, 1);
    // The hole ends between two rings of points, as far from each.
    EXPECT_NEAR(cut.force_B_N.z / exact, 1, 0.005) << share;
  }
}

TEST(RoundClosedForm, ADrillThroughAPlateRemovesACylinder) {
  TwistDrill drill;
  drill.diameter_mm = 1.5;
  for (const std::size_t n : {0u, 4u, 6u}) {
    const RoundCut cut = MoveRound(drill, test::BlockPoses(0.1)[n], 0.1, {0.03, 0.02, 0.5}, {0.03, 0.02, -9}, 0.97, 1);
    EXPECT_NEAR(cut.removed_mm3 / (std::numbers::pi * 0.5625 * 8), 1, 0.01) << n;
    EXPECT_EQ(cut.force_B_N, Vec3(0));  // beyond the far side nothing is left to cut
  }
}

}  // namespace
}  // namespace kerf
