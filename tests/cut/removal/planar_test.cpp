// The cutter with blades that have a stroke, compared with brute force in double precision: every step is applied to
// every voxel of a plain array, with a hull found from all pairs of corners.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "cut/tool/drive.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "experiment/bench/dense_bone.h"
#include "strokes.h"
#include "support/seeded_check.h"

namespace kerf {
namespace {

using test::CheckSeeded;

constexpr double kAll = std::numeric_limits<double>::infinity();

struct Flat {
  double x, y;
};

struct SlidingStep {
  Pose X_from, X_to;
  SlideRange slide;
};

/// Points of the blade at both poses and at displacements from one end of the slide to the other, in the frame of the
/// last pose. Those of an arc are so close that they stand for the arc.
std::vector<Flat> FindCorners(const PlanarBlade& blade, const SlidingStep& step) {
  const bool swings = blade.swing_radius_mm > 0;
  const int displacements = swings ? 4 : 2, teeth = swings ? 8 : 2;
  std::vector<Flat> corners;
  for (int k = 0; k < displacements; ++k) {
    const double slide = step.slide.least_mm + step.slide.size_mm() * k / (displacements - 1);
    std::vector<Vec3> points{{blade.back_low.x, blade.back_low.y, 0}, {blade.back_high.x, blade.back_high.y, 0}};
    for (int i = 0; i < teeth; ++i) {
      const double along_mm = blade.edge_mm * (static_cast<double>(i) / (teeth - 1) - 0.5);
      const double rad = swings ? along_mm / blade.swing_radius_mm : 0;
      points.push_back(swings
                           ? Vec3(blade.swing_radius_mm * (std::cos(rad) - 1), blade.swing_radius_mm * std::sin(rad), 0)
                           : Vec3(0, along_mm, 0));
    }
    const double rad = swings ? slide / blade.swing_radius_mm : 0;
    for (const Vec3& p : points) {
      const double x = p.x + blade.swing_radius_mm;
      const Vec3 moved = swings ? Vec3(std::cos(rad) * x - std::sin(rad) * p.y - blade.swing_radius_mm,
                                       std::sin(rad) * x + std::cos(rad) * p.y, 0)
                                : p + Vec3(0, slide, 0);
      for (const Pose* X : {&step.X_from, &step.X_to}) {
        const Vec3 at = step.X_to.InversePoint(X->Point(moved));
        corners.push_back({at.x, at.y});
      }
    }
  }
  return corners;
}

/// Side of the hull.
struct Side {
  Flat a, normal, along;
  double length;
};

std::vector<Side> FindSides(const std::vector<Flat>& corners) {
  std::vector<Side> sides;
  for (const Flat& a : corners) {
    for (const Flat& b : corners) {
      const double length = std::hypot(b.x - a.x, b.y - a.y);
      if (length < 1e-9) continue;
      const Flat n{(b.y - a.y) / length, (a.x - b.x) / length};
      bool outermost = true;
      for (const Flat& c : corners) outermost = outermost && (c.x - a.x) * n.x + (c.y - a.y) * n.y < 1e-9;
      if (outermost) sides.push_back({a, n, {-n.y, n.x}, length});
    }
  }
  return sides;
}

/// Distance to the swept prism; far outside where the step does not cut.
double CalcDistance(const std::vector<Side>& sides, const ConvexOutline::Cutting& cutting, double kerf_mm,
                    double edge_depth_mm, const Vec3& p_T) {
  double out = -kAll, edge = -kAll, nearest2 = kAll;
  for (const Side& s : sides) {
    const double d = (p_T.x - s.a.x) * s.normal.x + (p_T.y - s.a.y) * s.normal.y;
    out = std::max(out, d);
    if (s.normal.x > cutting.least_x || s.normal.y > cutting.least_y) edge = std::max(edge, d);
    const double t = std::clamp((p_T.x - s.a.x) * s.along.x + (p_T.y - s.a.y) * s.along.y, 0.0, s.length);
    const double x = p_T.x - s.a.x - t * s.along.x, y = p_T.y - s.a.y - t * s.along.y;
    nearest2 = std::min(nearest2, x * x + y * y);
  }
  if (edge < -edge_depth_mm) return kAll;
  const double radial = out > 0 ? std::sqrt(nearest2) : out;
  const double axial = std::abs(p_T.z) - 0.5 * kerf_mm;
  return radial > 0 && axial > 0 ? std::sqrt(radial * radial + axial * axial) : std::max(radial, axial);
}

/// Random blade whose edge is near the origin, in short steps with a stroke. `forward`: towards its teeth, as where the
/// rest of the blade does not cut and bone would stay inside it.
std::vector<SlidingStep> DrawSteps(std::mt19937& random, const Tool& tool, bool in_plane, bool forward, double voxel_mm,
                                   int ticks) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const Drive drive(tool);
  Pose X;
  X.R_AB = test::DrawRotation(random);
  X.p_AB = test::DrawVector(random) - X.Vector({0, FindPlanarBlade(tool)->edge_mm * (uniform(random) - 0.5), 0});
  double phase = 6 * uniform(random);
  std::vector<SlidingStep> steps;
  Vec3 v_T(0);
  for (int i = 0; i < ticks; ++i) {
    if (i == 0 || uniform(random) < 0.1) v_T = glm::normalize(test::DrawVector(random)) * 0.8 * voxel_mm;
    if (forward) v_T.x = std::max(std::abs(v_T.x), std::abs(v_T.y));
    v_T.z *= in_plane ? 0 : 0.1;
    Pose X_next = X;
    X_next.p_AB += X.Vector(v_T);
    const Vec3 axis = in_plane ? Vec3(0, 0, 1) : glm::normalize(test::DrawVector(random));
    X_next.R_AB = glm::normalize(X.R_AB * glm::angleAxis(0.002 * uniform(random), axis));
    const double count = CountSubsteps(X, X_next, tool, voxel_mm);
    Pose X_a = X;
    for (double k = 1; k <= count; ++k) {
      const Pose X_b = k == count ? X_next : Interpolate(X, X_next, k / count);
      const double advance = uniform(random);
      steps.push_back({X_a, X_b, drive.CalcRange(phase, advance)});
      phase += advance;
      X_a = X_b;
    }
    X = X_next;
  }
  return steps;
}

Tool DrawReciprocating(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  ReciprocatingBlade blade;
  blade.length_mm = 4 + 20 * uniform(random);
  blade.width_mm = 2 + 5 * uniform(random);
  blade.taper = 0.4 + 0.6 * uniform(random);
  blade.thickness_mm = 0.1 + uniform(random);
  blade.set_mm = 0.1 * uniform(random);
  blade.stroke_mm = 0.5 + 4 * uniform(random);
  return blade;
}

Tool DrawOscillating(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  OscillatingBlade blade;
  blade.radius_mm = 8 + 20 * uniform(random);
  blade.width_mm = 3 + 5 * uniform(random);
  blade.taper = 0.4 + 0.6 * uniform(random);
  blade.thickness_mm = 0.1 + uniform(random);
  blade.set_mm = 0.1 * uniform(random);
  blade.swing_deg = 1 + 8 * uniform(random);
  return blade;
}

Tool DrawPiezo(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  PiezoInsert insert;
  insert.length_mm = 3 + 7 * uniform(random);
  insert.width_mm = 2 + 4 * uniform(random);
  insert.taper = 0.4 + 0.6 * uniform(random);
  insert.thickness_mm = 0.1 + uniform(random);
  insert.stroke_mm = 0.05 + 0.4 * uniform(random);
  return insert;
}

struct Match {
  double phi_mm;       // largest difference, less the sagitta of the chords that stand for an arc
  double removed_mm3;  // difference of the removed volumes
};

/// Compares the results, and adds what was removed.
using DrawTool = Tool (*)(std::mt19937& random);
Match Compare(std::mt19937& random, DrawTool draw, bool in_plane, CutWith with, double voxel_mm, double& removed_mm3) {
  const Tool tool = draw(random);
  const PlanarBlade blade = *FindPlanarBlade(tool);
  const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
  Bone bone = test::MakeBox(X_WB, {4, 3, 3.5}, voxel_mm);
  const Box3 all{X_WB.p_AB - Vec3(4), X_WB.p_AB + Vec3(4)};
  DenseBone dense(bone, all);
  const double before_mm3 = dense.CalcOccupancy_mm3();
  BoneField field(bone, 4096);
  Cutter cutter(field, tool, with);
  double sum_mm3 = 0;
  const double depth_mm = with == CutWith::kEdge ? CalcToothSide(CalcReach(tool), voxel_mm) : kAll;
  const std::vector<SlidingStep> steps = DrawSteps(random, tool, in_plane, with == CutWith::kEdge, voxel_mm, 8);
  if (with == CutWith::kEdge) {
    // As in a hand, no bone is inside the blade at the start.
    const SlidingStep first{steps[0].X_from, steps[0].X_from, steps[0].slide};
    sum_mm3 += cutter.CutAround(first.X_to, first.slide).removed_mm3;
    const std::vector<Side> sides = FindSides(FindCorners(blade, first));
    dense.Cut(all, [&](const Vec3& p_W) {
      return CalcDistance(sides, {}, CalcKerfWidth(blade.kerf_mm, voxel_mm), kAll, first.X_to.InversePoint(p_W));
    });
  }
  const ConvexOutline::Cutting cutting = blade.SweepOutline({}).cutting();
  const double kerf_mm = CalcKerfWidth(blade.kerf_mm, voxel_mm);
  for (const SlidingStep& step : steps) {
    sum_mm3 += cutter.Cut(step.X_from, step.X_to, step.slide).removed_mm3;
    const std::vector<Side> sides = FindSides(FindCorners(blade, step));
    dense.Cut(all, [&](const Vec3& p_W) {
      return CalcDistance(sides, cutting, kerf_mm, depth_mm, step.X_to.InversePoint(p_W));
    });
  }
  removed_mm3 += sum_mm3;
  return {dense.Compare(bone).max_phi_mm - blade.CalcSagitta(),
          std::abs(sum_mm3 - (before_mm3 - dense.CalcOccupancy_mm3()))};
}

constexpr DrawTool kDraw[] = {DrawReciprocating, DrawOscillating, DrawPiezo};
constexpr int kCases = 8;
constexpr double kRounding_mm = 2e-5;  // float arithmetic at 20 mm from the origin

/// Kinds of blades: indices of kDraw.
class PlanarSweep : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PlanarSweep, testing::Range<std::size_t>(0, 3));

TEST_P(PlanarSweep, MatchesBruteForceToRoundingInThePlane) {
  double removed_mm3 = 0, off_mm3 = 0;
  EXPECT_TRUE(CheckSeeded(11, kCases, [&] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double before_mm3 = removed_mm3;
    const Match match =
        Compare(random, kDraw[GetParam()], true, CutWith::kWholeTool, *rc::gen::element(0.2, 0.3), removed_mm3);
    RC_ASSERT(match.phi_mm <= kRounding_mm);
    // The chords of an arc leave a little more than it.
    RC_ASSERT(match.removed_mm3 < 1e-3 + (GetParam() == 1 ? 0.02 * (removed_mm3 - before_mm3) : 0));
    off_mm3 += match.removed_mm3;
  }));
  EXPECT_GT(removed_mm3, 2);
  EXPECT_LT(off_mm3, 1e-2 + (GetParam() == 1 ? 0.005 * removed_mm3 : 0));
}

TEST_P(PlanarSweep, MatchesBruteForceToTheFlankToleranceWhenItTiltsAndSlides) {
  double removed_mm3 = 0;
  EXPECT_TRUE(CheckSeeded(12, kCases, [&] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = *rc::gen::element(0.2, 0.3);
    RC_ASSERT(Compare(random, kDraw[GetParam()], false, CutWith::kWholeTool, h, removed_mm3).phi_mm <=
              Cutter::kFlankTolerance * h + kRounding_mm);
  }));
  EXPECT_GT(removed_mm3, 2);
}

TEST_P(PlanarSweep, OnlyTheEdgeCutsInAHand) {
  // Where the zone of the edge ends, a voxel may be on either side of it by rounding: two of them at most. The chords
  // of an arc move that end by their sagitta.
  double removed_mm3 = 0;
  EXPECT_TRUE(CheckSeeded(13, kCases, [&] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const Match match =
        Compare(random, kDraw[GetParam()], true, CutWith::kEdge, *rc::gen::element(0.2, 0.3), removed_mm3);
    RC_ASSERT(match.removed_mm3 < (GetParam() == 1 ? 0.1 : 0.02));
  }));
  EXPECT_GT(removed_mm3, 1);
}

TEST(PlanarBlade, SetOfTheTeethWidensTheKerf) {
  ReciprocatingBlade blade;
  blade.thickness_mm = 0.4;
  blade.set_mm = 0.1;
  Bone bone = test::MakeBox({}, {6, 6, 6}, 0.1);
  const double before_mm3 = bone.CalcVolume();
  BoneField field(bone, 4096);
  Cutter cutter(field, blade, CutWith::kWholeTool);
  cutter.CutAround({});  // x from -3 to 0, y from -3 to 3
  field.Settle();
  EXPECT_NEAR((before_mm3 - bone.CalcVolume()) / (0.6 * 3 * 6), 1, 0.01);
}

}  // namespace
}  // namespace kerf
