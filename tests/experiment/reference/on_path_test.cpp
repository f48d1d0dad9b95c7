// Tests that compare the tool on a path with closed forms, in a block with a known cut.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>
#include <random>
#include <string_view>

#include "experiment/reference/cuts.h"
#include "kerf/error.h"
#include "support/saw.h"

namespace kerf {
namespace {

using namespace test;

ReferenceParams Params(const char* law) {
  ReferenceParams params;
  params.law = ForceLaw(law);
  return params;
}

/// Computes the force laws independently of the code under test, in mm, N and MPa.
double ToothForceByHand(std::string_view law, double bite, double E_star) {
  if (law == "hertz_chip") return 4.0 / 3 * E_star * std::sqrt(kR) * std::pow(bite, 1.5);
  if (law == "hertz_constant_bite") return 4.0 / 3 * E_star * std::pow(0.01 * kSaw.pitch_mm(), 3) / kR;
  return (9.28 + 530 * bite) * kSaw.thickness_mm * E_star / 19140;
}

struct Form {
  double teeth, thrust, along, up;
};
/// Integrates over the rim from its lowest point (for a plunge, from the bone's surface on the other side) to the point
/// where it leaves the bone's surface.
Form CalcForm(std::string_view law, double depth, double feed, double E_star, bool plunge) {
  const double alpha = std::acos(1 - depth / kR);
  Form form{(plunge ? 2 : 1) * alpha * kR / kSaw.pitch_mm(), 0, 0, 0};
  constexpr int kIntervals = 100000;  // error of the midpoint rule: 1e-9
  const double from = plunge ? -alpha : 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = from + (alpha - from) * (i + 0.5) / kIntervals;
    const double bite = feed / (24 * 125.0) * (plunge ? std::cos(phi) : std::sin(phi));
    const double f = ToothForceByHand(law, bite, E_star) * 24 / (2 * std::numbers::pi) * (alpha - from) / kIntervals;
    form.thrust += f;
    form.along += f * std::sin(phi);
    form.up += f * std::cos(phi);
  }
  return form;
}

TEST(ReferenceOnPath, SlotMatchesTheClosedFormForEachLaw) {
  const double depth = 3;
  const double feed = 4;
  // The tool moves fast from outside the block to its middle, then at the feed rate.
  std::vector<Pose> poses = Stroke({-30, 0, 4 - depth + kR}, {-2, 0, 4 - depth + kR}, 50);
  Append(poses, Stroke({-2, 0, 4 - depth + kR}, {-1.9, 0, 4 - depth + kR}, feed));
  for (const char* law : {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"}) {
    const ReferenceRun run = RunReferenceOnPath(Block({}, {40, 4, 8}), Params(law), poses);
    ASSERT_EQ(run.ticks.size(), poses.size() - 1);
    const Form form = CalcForm(law, depth, feed, EStar(kE_MPa, kNu, kSaw), false);
    const ReferenceTick& out = run.ticks.back();
    // The look-ahead of 1e-5 mm adds at most an arc of sqrt(2 R 1e-5) = 0.015 mm to the 8.2 mm, at the rim's lowest
    // point. The start of the side that faces the feed is exact, so the error is smaller.
    EXPECT_NEAR(out.engaged_teeth / form.teeth, 1, 1e-5) << law;
    EXPECT_NEAR(out.thrust_sum_N / form.thrust, 1, 1e-5) << law;
    EXPECT_NEAR(-out.f_W_N.x / form.along, 1, 1e-5) << law;
    EXPECT_NEAR(out.f_W_N.z / form.up, 1, 1e-5) << law;
    EXPECT_NEAR(out.f_W_N.y, 0, 1e-9);
    std::printf("%s: teeth %.1e thrust %.1e along %.1e up %.1e\n", law, out.engaged_teeth / form.teeth - 1,
                out.thrust_sum_N / form.thrust - 1, -out.f_W_N.x / form.along - 1, out.f_W_N.z / form.up - 1);
  }
}

TEST(ReferenceOnPath, PlungeMatchesTheClosedFormAndRemovesTheSegment) {
  const double feed = 5;
  const double tick_s = 0.002;
  const std::vector<Pose> poses = Stroke({0, 0, 4 + kR + 0.1}, {0, 0, 4 + kR - 2.9}, feed, tick_s);
  for (const char* law : {"hertz_chip", "edge_plus_chip"}) {
    ReferenceParams params = Params(law);
    params.tick_s = tick_s;
    const ReferenceRun run = RunReferenceOnPath(Block({}, {40, 4, 8}), params, poses);
    // Except for the curvature over a tick, the mean of the last tick is the value at its middle.
    const Form form = CalcForm(law, 2.9 - 0.5 * feed * tick_s, feed, EStar(kE_MPa, kNu, kSaw), true);
    EXPECT_NEAR(run.ticks.back().engaged_teeth / form.teeth, 1, 1e-5);
    EXPECT_NEAR(run.ticks.back().thrust_sum_N / form.thrust, 1, 1e-5);
    EXPECT_NEAR(run.ticks.back().f_W_N.z / form.up, 1, 1e-5);
    EXPECT_NEAR(run.ticks.back().f_W_N.x, 0, 1e-5 * form.up);
    const double volume = SegmentArea(kR, 2.9) * kSaw.thickness_mm;
    // Near the surface the arc grows as a square root, so the midpoint rule's error there is about (feed step)^1.5.
    EXPECT_NEAR(run.ticks.back().removed_mm3 / volume, 1, 1e-5);
    std::printf("plunge: volume %.1e\n", run.ticks.back().removed_mm3 / volume - 1);
  }
}

TEST(ReferenceOnPath, SlotsVolumeIsThatOfACuboid) {
  // The slot goes through the whole block.
  const ReferenceRun run =
      RunReferenceOnPath(Block({}, {10, 4, 8}), Params("hertz_chip"), Stroke({-20, 0, 1 + kR}, {20, 0, 1 + kR}, 40));
  EXPECT_NEAR(run.ticks.back().removed_mm3 / (10 * 3 * kSaw.thickness_mm), 1, 2e-5);
  std::printf("slot: volume %.1e\n", run.ticks.back().removed_mm3 / (10 * 3 * kSaw.thickness_mm) - 1);
}

TEST(ReferenceOnPath, NothingIsCutTwice) {
  // The tool moves back through its own kerf and forward again.
  std::vector<Pose> poses = Stroke({-20, 0, 2 + kR}, {0, 0, 2 + kR}, 40);
  const std::size_t cut = poses.size() - 1;
  Append(poses, Stroke({0, 0, 2 + kR}, {-15, 0, 2 + kR}, 40));
  Append(poses, Stroke({-15, 0, 2 + kR}, {0, 0, 2 + kR}, 40));
  const ReferenceRun run = RunReferenceOnPath(Block({}, {20, 4, 8}), Params("edge_plus_chip"), poses);
  EXPECT_GT(run.ticks[cut - 1].engaged_teeth, 1);
  // The rim is within the look-ahead of the kerf's floor over an arc of sqrt(2 R 1e-5 mm) = 0.015 mm. Near the end of
  // the kerf, half a step of 5 um away, it is within it over R 1e-5 / 5e-3 = 0.022 mm.
  for (std::size_t k = cut; k < run.ticks.size(); ++k) EXPECT_LT(run.ticks[k].engaged_teeth, 0.023 / kSaw.pitch_mm());
  EXPECT_NEAR(run.ticks.back().removed_mm3, run.ticks[cut - 1].removed_mm3, 1e-4);
}

TEST(ReferenceOnPath, EachLayerGivesItsForceWithASharpBorder) {
  // Plunges a saw much wider than the plate, so that the plate's whole length is cut at nearly one depth.
  DiscSaw saw;
  saw.diameter_mm = 200;
  saw.teeth = 200;
  const double R = saw.radius_mm();
  ExactSolid solid = Block({}, {10, 1, 6});
  solid.material = [](const Vec3& p) {
    return p.z > 1 ? ExactSolid::Material{24, 19300, 0.28} : ExactSolid::Material{32, 500, 0.3};
  };
  ReferenceParams params = Params("hertz_chip");
  params.saw = saw;
  params.law.Set("contact_radius_mm", 11);
  const double feed = 5;
  const ReferenceRun run = RunReferenceOnPath(solid, params, Stroke({0, 0, 3.2 + R}, {0, 0, -2 + R}, feed));
  const double half_arc = std::asin(5 / R);
  const double tooth = 4.0 / 3 * std::sqrt(11) * std::pow(feed / (200 * 125.0), 1.5);
  for (std::size_t k = 0; k < run.ticks.size(); ++k) {
    const double lowest = 3.2 - feed * 0.001 * (static_cast<double>(k) + 0.5);  // of the rim, at the middle of the tick
    // Length of the rim that lies within the plate's 10 mm at height z: |phi| up to acos(1 - (z - lowest) / R).
    const auto arc = [&](double z) {
      return z <= lowest ? 0 : std::min(half_arc, std::acos(std::max(-1.0, 1 - (z - lowest) / R)));
    };
    const double soft = 2 * arc(1) * R / saw.pitch_mm();
    const double all = 2 * arc(3) * R / saw.pitch_mm();
    // This neglects cos^1.5 of at most 2.9 deg, 0.2 % at the ends. Ticks at the border and at the surface are skipped,
    // because there the arc grows as a square root within a tick.
    if (std::abs(lowest - 1) < 0.02 || std::abs(lowest - 3) < 0.02) continue;
    const double expected = tooth * ((all - soft) * EStar(19300, 0.28, saw) + soft * EStar(500, 0.3, saw));
    EXPECT_NEAR(run.ticks[k].thrust_sum_N, expected, 0.002 * expected + 1e-9) << lowest;
  }
}

TEST(ReferenceOnPath, VolumeAgreesWithAGridOfPoints) {
  // The tool moves down, along and tilts, so both the rim and the flats remove bone.
  std::vector<Pose> poses;
  const int ticks = 400;
  for (int i = 0; i <= ticks; ++i) {
    const double t = static_cast<double>(i) / ticks;
    Pose X = Upright({4 * t, 0.2 * t, 5.5 + kR - 3 * t});
    X.R_AB = glm::angleAxis(0.15 * t, Vec3(1, 0, 0)) * glm::angleAxis(0.1 * t, Vec3(0, 0, 1)) * X.R_AB;
    poses.push_back(X);
  }
  const ReferenceRun run = RunReferenceOnPath(Block({}, {30, 12, 10}), Params("hertz_chip"), poses);
  // Takes one random point in each cell of a grid. The error is smaller than with the same number of points without a
  // grid.
  Box3 box = run.bone.swept_bounds();
  box.upper.z = 5;
  const int cells[3] = {150, 30, 100};
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  int hits = 0;
  for (int i = 0; i < cells[0]; ++i) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int k = 0; k < cells[2]; ++k) {
        const Vec3 fraction((i + unit(random)) / cells[0], (j + unit(random)) / cells[1],
                            (k + unit(random)) / cells[2]);
        const Vec3 p = box.lower + fraction * box.size();
        hits += run.bone.solid().distance_mm(p) < 0 && !run.bone.IsBone(p) ? 1 : 0;
      }
    }
  }
  const double points = cells[0] * cells[1] * cells[2];
  const double whole = box.size().x * box.size().y * box.size().z;
  const double fraction = hits / points;
  const double sigma = whole * std::sqrt(fraction * (1 - fraction) / points);
  EXPECT_NEAR(run.ticks.back().removed_mm3, whole * fraction, 2 * sigma);
  EXPECT_LT(sigma, 0.01 * whole * fraction);
  std::printf("general: flux %.4f, points %.4f, sigma < %.4f mm3\n", run.ticks.back().removed_mm3, whole * fraction,
              sigma);
}

TEST(ReferenceOnPath, DoesNotDependOnTheFrame) {
  const Pose X_WB{glm::angleAxis(1.1, glm::normalize(Vec3(1, -2, 0.5))), {120, -35, 7}};
  std::vector<Pose> poses = Stroke({0, 0, 4 + kR + 0.1}, {1, 0, 4 + kR - 1}, 20);
  const ReferenceRun at_home = RunReferenceOnPath(Block({}, {20, 4, 8}), Params("hertz_chip"), poses);
  for (Pose& X : poses) X = Times(X_WB, X);
  const ReferenceRun moved = RunReferenceOnPath(Block(X_WB, {20, 4, 8}), Params("hertz_chip"), poses);
  for (std::size_t k = 0; k < at_home.ticks.size(); ++k) {
    // Coordinates of 120 mm are rounded to 3e-14 mm. This may shift the end of an arc, found by bisection, by 1e-8 rad.
    EXPECT_NEAR(glm::length(X_WB.Vector(at_home.ticks[k].f_W_N) - moved.ticks[k].f_W_N), 0, 1e-6);
  }
  // The cells used for the volume stay aligned with the world. Their error for a rotated plunge is 5e-4.
  EXPECT_NEAR(moved.ticks.back().removed_mm3 / at_home.ticks.back().removed_mm3, 1, 5e-4);
}

TEST(ReferenceOnPath, StoppedSpindleCutsNothingAndInvalidParametersAreRefused) {
  ReferenceParams params = Params("hertz_chip");
  params.rpm = 0;
  const auto poses = Stroke({0, 0, 4 + kR}, {0, 0, 3 + kR}, 100);
  const ReferenceRun run = RunReferenceOnPath(Block({}, {20, 4, 8}), params, poses);
  EXPECT_EQ(run.ticks.back().f_W_N, Vec3(0));
  EXPECT_EQ(run.ticks.back().removed_mm3, 0);
  EXPECT_TRUE(run.bone.swept_bounds().empty());
  params.fineness.rim_points = 3;
  EXPECT_THROW(RunReferenceOnPath(Block({}, {20, 4, 8}), params, poses), Error);
  EXPECT_THROW(RunReferenceOnPath(Block({}, {20, 4, 8}), Params("hertz_chip"), {}), Error);
}

}  // namespace
}  // namespace kerf
