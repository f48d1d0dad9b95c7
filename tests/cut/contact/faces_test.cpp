// Gaps between the flats and the walls of the disc's own kerf.
#include "cut/contact/faces.h"

#include <gtest/gtest.h>

#include "cut/removal/cutter.h"
#include "support/cuts.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;

TEST(Faces, DiscFitsItsOwnKerfWithTheExpectedPlay) {
  // Holds for any position of the kerf among the voxels, also where a voxel is as wide as the kerf.
  for (const double h : {0.1, 0.15, 0.2, 0.25}) {
    for (const Pose& X_WB : BlockPoses(h)) {
      Bone bone = test::MakeBox(X_WB, {30, 3, 8}, h);
      BoneField field(bone, 20000);
      Cutter cutter(field, kSaw, CutWith::kEdge);
      Pose X = DiscPose(X_WB, {-27, 0, 4 + kR - 3});
      for (int i = 1; i * 0.4 * h < 24; ++i) {
        const Pose X_next = DiscPose(X_WB, {-27 + i * 0.4 * h, 0, 4 + kR - 3});
        cutter.Cut(X, X_next);
        X = X_next;
      }
      const ToolShape shape =
          MakeToolShape(kSaw, {8, 1.4, Faces::CalcRimMargin(kSaw.radius_mm(), h), Faces::CalcStoppedMargin(h)});
      Faces faces(field, shape, Vec3(0));
      StepProblem problem;
      problem.tau_s = 0.001;
      faces.Find(Probe(field, X), 0.025, false, problem);
      EXPECT_GT(problem.flats.size(), 20u);
      // The play is 0.2 % of a voxel plus half of the amount by which the kerf is wider than the disc. The corner of
      // the kerf's floor reduces the former by up to half. Near the wall's free edge there is less bone; the gap there
      // is not compared.
      const double play_mm = 0.002 * h + 0.5 * (CalcKerfWidth(kSaw.thickness_mm, h) - kSaw.thickness_mm);
      int deep = 0;
      for (const FlatPoint& p : problem.flats) {
        EXPECT_LT(p.depth_mm, 0) << h << " " << p.x << " " << p.y;
        const Vec3 p_B = X_WB.InversePoint(X.Point({p.x, p.y, 0}));
        if (p_B.z > 4 - 4 * h || std::abs(p_B.x) > 15 - 4 * h) continue;
        EXPECT_NEAR(p.depth_mm, -play_mm, 0.0012 * h) << h << " " << p.x << " " << p.y;
        ++deep;
      }
      EXPECT_GT(deep, 10);
    }
  }
}

TEST(Faces, FlatsWithinReachAreFoundBeforeContact) {
  Bone bone = test::MakeBox(Pose{}, {30, 30, 4}, 0.2);
  BoneField field(bone, 100);
  const ToolShape shape =
      MakeToolShape(kSaw, {8, 1.4, Faces::CalcRimMargin(kSaw.radius_mm(), 0.2), Faces::CalcStoppedMargin(0.2)});
  Faces faces(field, shape, Vec3(0));
  // The disc is lowered flat onto a face in small steps; pairs that were far apart must be tested again in time.
  for (double height = 3; height > 0.01; height -= 0.013) {
    Pose X;
    X.p_AB = {0.3, 0.1, 2 + 0.125 + height};
    StepProblem problem;
    faces.Find(Probe(field, X), 0.05, false, problem);
    if (height > 0.051) {
      EXPECT_TRUE(problem.flats.empty()) << height;
    } else if (height < 0.049) {
      EXPECT_EQ(problem.flats.size(), faces.size() / 2) << height;
      for (const FlatPoint& p : problem.flats) EXPECT_NEAR(p.depth_mm, -height, 0.001);
    }
  }
}

}  // namespace
}  // namespace kerf
