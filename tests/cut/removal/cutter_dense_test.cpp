// The cutter compared with brute force, in which every step is applied to every voxel of a plain array, in double
// precision.
#include <gtest/gtest.h>

#include "cut/removal/carve.h"
#include "cut/tool/shape.h"
#include "experiment/bench/dense_bone.h"
#include "strokes.h"
#include "support/seeded_check.h"

namespace kerf {
namespace {

using test::CheckSeeded;
using test::Step;
using test::StrokeKind;

/// Returns the error of float arithmetic for a tool of this radius: a coordinate is off by up to 2^-24 of it in each of
/// about six operations, and phi is stored to 2^-24 of the band.
double Rounding(const Tool& tool) {
  return 6 * 6e-8 * (CalcReach(tool) + 2) + 1e-7;
}

struct Difference {
  DenseDifference phi;
  double removed_mm3 = 0;        // by the cutter
  double dense_removed_mm3 = 0;  // by brute force
};

double CutBone(Bone& bone, const Tool& tool, const std::vector<Step>& steps) {
  BoneField field(bone, 4096);
  Cutter cutter(field, tool, CutWith::kWholeTool);
  const double removed_mm3 = test::CutAll(cutter, steps);
  field.Settle();
  return removed_mm3;
}

Difference Compare(const Pose& X_WB, double voxel_mm, const Tool& tool, const std::vector<Step>& steps,
                   CutWith with = CutWith::kWholeTool) {
  Bone bone = test::MakeBox(X_WB, {5, 4, 4.5}, voxel_mm);
  DenseBone dense(bone, Box3{X_WB.p_AB - Vec3(5), X_WB.p_AB + Vec3(5)});
  const double before = dense.CalcOccupancy_mm3();
  BoneField field(bone, 4096);
  Cutter cutter(field, tool, with);
  Difference difference;
  difference.removed_mm3 = test::CutAll(cutter, steps);
  for (const Step& step : steps) dense.Cut(tool, step.X_from, step.X_to);
  difference.phi = dense.Compare(bone);
  difference.dense_removed_mm3 = before - dense.CalcOccupancy_mm3();
  return difference;
}

TEST(CutterAgainstBruteForce, MatchesToRoundingForBallsAndDiscsInTheirPlaneAndToTheToleranceForBurs) {
  EXPECT_TRUE(CheckSeeded(1, 20, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = *rc::gen::element(0.1, 0.2, 0.3);
    const Tool tool = test::DrawTool(random);
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    const auto steps = test::DrawSteps(random, tool, StrokeKind::kInPlane, h, 3, h < 0.15 ? 15 : 30);
    const Difference d = Compare(X_WB, h, tool, steps);
    const double curved_mm = CalcRoundSolid(tool) ? Cutter::kFlankTolerance * h : 0;
    RC_ASSERT(d.phi.max_phi_mm <= curved_mm + Rounding(tool));
    // In each voxel that differs, the removed fraction is off by at most rounding / h.
    const double rounding_mm3 = static_cast<double>(d.phi.voxels) * h * h * (curved_mm + Rounding(tool));
    RC_ASSERT(std::abs(d.removed_mm3 - d.dense_removed_mm3) <= rounding_mm3 + 1e-6 * d.dense_removed_mm3);
    RC_CLASSIFY(d.dense_removed_mm3 > 1);
  }));
}

TEST(CutterAgainstBruteForce, MatchesToTheFlankToleranceWhenADiscTiltsAndSlides) {
  EXPECT_TRUE(CheckSeeded(2, 12, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = *rc::gen::element(0.2, 0.3);
    const Tool tool = test::DrawTool(random);
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    const auto steps = test::DrawSteps(random, tool, StrokeKind::kFree, h, 2, 25);
    const Difference d = Compare(X_WB, h, tool, steps);
    RC_ASSERT(d.phi.max_phi_mm <= Cutter::kFlankTolerance * h + Rounding(tool));
    RC_CLASSIFY(d.dense_removed_mm3 > 1);
  }));
}

TEST(CutterAgainstBruteForce, ABurThatContinuesCutsAllThatOneThatVisitsEverythingCuts) {
  // A cut that continues leaves out leaves and bricks from which the tool moves away. A step at a time, nothing is left
  // out. Both use the same arithmetic, so they differ only by its rounding where a step cuts at the same place again.
  EXPECT_TRUE(CheckSeeded(3, 40, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = *rc::gen::element(0.1, 0.2);
    const Tool tool = test::DrawBur(random);
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    std::vector<Step> steps = test::DrawSteps(random, tool, StrokeKind::kInPlane, h, 2, 40);
    Bone continued = test::MakeBox(X_WB, {5, 4, 4.5}, h);
    Bone stepped = continued;
    const double removed_mm3 = CutBone(continued, tool, steps);
    for (Step& step : steps) step.lifted = true;
    CutBone(stepped, tool, steps);
    const DenseBone all(stepped, Box3{X_WB.p_AB - Vec3(5), X_WB.p_AB + Vec3(5)});
    RC_ASSERT(all.Compare(continued).max_phi_mm <= 2 * Rounding(tool));
    RC_CLASSIFY(removed_mm3 > 1);
  }));
}

TEST(CutterAgainstBruteForce, ABurThatTurnsHasCutAllThatItHasReached) {
  // What a rotation sweeps between two poses may be left out, within the tolerance of the flanks; the poses may not.
  EXPECT_TRUE(CheckSeeded(5, 8, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = *rc::gen::element(0.1, 0.2);
    const Tool tool = test::DrawBur(random);
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    const std::vector<Step> steps = test::DrawSteps(random, tool, StrokeKind::kFree, h, 2, 40);
    Bone bone = test::MakeBox(X_WB, {5, 4, 4.5}, h);
    const double removed_mm3 = CutBone(bone, tool, steps);
    DenseBone reached(bone, Box3{X_WB.p_AB - Vec3(5), X_WB.p_AB + Vec3(5)});
    for (const Step& step : steps) reached.Cut(tool, step.X_to, step.X_to);
    RC_ASSERT(reached.Compare(bone).max_phi_mm <= 2 * Rounding(tool));
    RC_CLASSIFY(removed_mm3 > 1);
  }));
}

TEST(CutterAgainstBruteForce, RandomBursAreTheSameBitForBitAtEveryVectorWidth) {
  EXPECT_TRUE(CheckSeeded(4, 15, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const Tool tool = test::DrawBur(random);
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    const std::vector<Step> steps = test::DrawSteps(random, tool, StrokeKind::kFree, 0.2, 2, 40);
    const Bone initial = test::MakeBox(X_WB, {5, 4, 4.5}, 0.2);
    Bone best = initial;
    const double removed_mm3 = CutBone(best, tool, steps);
    for (const std::string& target : VectorTargets()) {
      SetVectorTarget(target);
      Bone other = initial;
      CutBone(other, tool, steps);
      SetVectorTarget("");
      RC_ASSERT(other.CalcHash() == best.CalcHash());
    }
    RC_CLASSIFY(removed_mm3 > 1);
  }));
}

/// A slow stroke of a tool that turns back and moves aside again and again. A step is at most 0.05 voxels long.
std::vector<Step> DrawTremblingSteps(std::mt19937& random, const Tool& tool, double h, double tilt_rad) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const bool is_disc = std::holds_alternative<DiscSaw>(tool);
  const Vec3 edge_T = is_disc ? Vec3(1, 0, 0) : glm::normalize(test::DrawVector(random));
  const bool is_bur = GetForm(tool) == ToolForm::kRound;
  Pose X{test::DrawRotation(random), Vec3(0)};
  X.p_AB = test::DrawVector(random) - X.Vector(is_bur ? FindDeepest(tool, edge_T) : CalcReach(tool) * edge_T);
  std::vector<Pose> poses{X};
  Vec3 way_T(0);
  for (int i = 0; i < 300; ++i) {
    if (i % 4 == 0) way_T = 0.03 * h * uniform(random) * glm::normalize(test::DrawVector(random));
    if (is_disc) way_T.z = 0;
    X.p_AB += X.Vector(way_T + 0.02 * h * (is_disc ? edge_T : Vec3(0, 0, -1)));
    X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(tilt_rad * std::sin(0.3 * i), Vec3(1, 0, 0)));
    poses.push_back(X);
  }
  std::vector<Step> steps = test::MakeSteps(poses, tool, h);
  for (std::size_t i = 0; i < steps.size(); i += 50) steps[i].lifted = true;
  return steps;
}

TEST(CutterAgainstBruteForce, ASlowToolThatTremblesMissesNothing) {
  // The bricks near the edge are kept for many steps.
  EXPECT_TRUE(CheckSeeded(6, 4, [] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const double h = 0.2;
    const Tool tool = test::DrawTool(random);
    const double tilt_rad = std::holds_alternative<DiscSaw>(tool) ? 1e-4 * h : 0;
    const Pose X_WB{test::DrawRotation(random), 0.1 * test::DrawVector(random)};
    Bone bone = test::MakeBox(X_WB, {5, 4, 4.5}, h);
    DenseBone dense(bone, Box3{X_WB.p_AB - Vec3(5), X_WB.p_AB + Vec3(5)});
    BoneField field(bone, 4096);
    Cutter cutter(field, tool, CutWith::kWholeTool);
    int visited = 0;
    int searched = 0;
    for (const Step& step : DrawTremblingSteps(random, tool, h, tilt_rad)) {
      if (step.lifted) cutter.Lift();
      cutter.Cut(step.X_from, step.X_to);
      visited += cutter.effort().leaves;
      searched += cutter.effort().searched_leaves;
      dense.Cut(tool, step.X_from, step.X_to);
    }
    // A blade's flats cut again only when they have moved by the tolerance; a bur's sweep has it too.
    const double tolerance_mm = std::holds_alternative<BallBurr>(tool) ? 0 : Cutter::kFlankTolerance * h;
    RC_ASSERT(dense.Compare(bone).max_phi_mm <= tolerance_mm + Rounding(tool));
    // Bricks are kept for at least 9/16 of 0.25 voxels, less the first step; those of a solid of revolution are not.
    if (CalcRoundSolid(tool)) {
      RC_ASSERT(searched == visited);
    } else {
      RC_ASSERT(2 * searched < visited + 100);
    }
    RC_CLASSIFY(visited > 1000);
  }));
}

TEST(CutterAgainstBruteForce, AnEdgeCutsAsMuchWhetherItsBricksAreKeptOrSearchedInEachStep) {
  // With CutWith::kEdge only a part of the tool cuts, so the reference is a cutter that is lifted before each step. It
  // keeps nothing, and visits all of the zone.
  for (const Tool& tool : {Tool(DiscSaw{.diameter_mm = 12}), Tool(TwistDrill{.diameter_mm = 2}), Tool(FissureBur{})}) {
    std::mt19937 random(3);
    const double h = 0.2;
    const Bone initial = test::MakeBox({}, {5, 4, 4.5}, h);
    const std::vector<Step> steps = DrawTremblingSteps(random, tool, h, 0);
    const auto cut = [&](bool lifts) {
      Bone bone = initial;
      BoneField field(bone, 4096);
      Cutter cutter(field, tool, CutWith::kEdge);
      for (const Step& step : steps) {
        if (lifts) cutter.Lift();
        cutter.Cut(step.X_from, step.X_to);
      }
      field.Settle();
      return bone;
    };
    const Bone continued = cut(false);
    const Bone stepped = cut(true);
    const DenseBone all(stepped, Box3{Vec3(-5), Vec3(5)});
    EXPECT_LE(all.Compare(continued).max_phi_mm, 2 * Rounding(tool)) << tool.index();
    EXPECT_GT(initial.CalcVolume() - continued.CalcVolume(), 0.5) << tool.index();
  }
}

TEST(CutterAgainstBruteForce, AfterALiftNothingIsKept) {
  // Otherwise the last bits of a cut would depend on earlier ones nearby.
  const DiscSaw disc{.diameter_mm = 12};
  std::mt19937 random(5);
  Bone bone = test::MakeBox({}, {5, 4, 4.5}, 0.2);
  BoneField field(bone, 4096);
  Cutter cutter(field, disc, CutWith::kEdge);
  int continued = 0;
  for (const Step& step : DrawTremblingSteps(random, disc, 0.2, 0)) {
    if (step.lifted) cutter.Lift();
    cutter.Cut(step.X_from, step.X_to);
    const Cutter::Effort& effort = cutter.effort();
    if (step.lifted) {
      cutter.Lift();
      cutter.Cut(step.X_to, step.X_to);
      EXPECT_EQ(effort.searched_leaves, effort.leaves);
      EXPECT_GT(effort.leaves, 0);
    } else if (effort.searched_leaves < effort.leaves) {
      ++continued;
    }
  }
  EXPECT_GT(continued, 100);
}

TEST(CutterAgainstBruteForce, ALongStrokeThroughTheBlockMissesNothing) {
  // The tool moves far beyond the slack of the leaf lists, with a rotated thick disc.
  DiscSaw disc;
  disc.thickness_mm = 0.5;
  const Pose X_WB = test::BlockPoses(0.2)[5];
  std::vector<Pose> poses;
  for (int i = 0; i <= 130; ++i) poses.push_back(test::DiscPose(X_WB, {-13 + 0.2 * i, 0.3, 11}));
  const Difference d = Compare(X_WB, 0.2, disc, test::MakeSteps(poses, disc, 0.2));
  EXPECT_LE(d.phi.max_phi_mm, Rounding(disc));
  EXPECT_GT(d.removed_mm3, 3);
}

TEST(CutterAgainstBruteForce, TheLipsOfADrillMakeTheHoleOfTheWholeDrill) {
  // Along its axis, all that the side passes has been passed by the lips before. Most leaves along the drill are above
  // them.
  const TwistDrill drill{.diameter_mm = 1.6};
  for (const int i : {1, 3, 5}) {
    const Pose X_WB = test::BlockPoses(0.2)[static_cast<std::size_t>(i)];
    std::vector<Pose> poses;
    for (int k = 0; k <= 40; ++k) poses.push_back({X_WB.R_AB, X_WB.Point({0.2, -0.1, 2.4 - 0.1 * k})});
    const Difference d = Compare(X_WB, 0.2, drill, test::MakeSteps(poses, drill, 0.2), CutWith::kEdge);
    EXPECT_LE(d.phi.max_phi_mm, Rounding(drill));
    EXPECT_GT(d.removed_mm3, 6);  // 3.2 mm below the corner of the tip: 6.4 mm3 with it
  }
}

}  // namespace
}  // namespace kerf
