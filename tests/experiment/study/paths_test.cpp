#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "experiment/study/case.h"
#include "experiment/study/case_run.h"
#include "experiment/study/hand_path.h"
#include "experiment/study/paths.h"
#include "kerf/error.h"
#include "test_paths.h"

namespace kerf {
namespace {

/// Returns the paths that need no data.
std::vector<StudyPath> MakeOwnPaths() {
  std::vector<std::string> names = NamesOfStudyPaths();
  std::erase(names, "ct");
  return MakeStudyPaths(names, "").paths;
}

double FindPeak(const CasePass& pass) {
  double peak = 0;
  for (const Vec3& f_W_N : pass.f_W_N) peak = std::max(peak, glm::length(f_W_N));
  return peak;
}

TEST(Way, IsTheIntegralOfItsSpeed) {
  const Way way(2, {{0, 0}, {0.5, 4}, {1, 4}, {1.5, 0}});
  EXPECT_DOUBLE_EQ(way(-1), 2);
  EXPECT_DOUBLE_EQ(way(0.25), 2.25);  // 1/2 8 t^2
  EXPECT_DOUBLE_EQ(way(0.5), 3);
  EXPECT_DOUBLE_EQ(way(1), 5);
  EXPECT_DOUBLE_EQ(way(1.5), 6);
  EXPECT_DOUBLE_EQ(way(9), 6);
  EXPECT_DOUBLE_EQ(Way(-1, {{0, 3}})(2), 5);
  EXPECT_DOUBLE_EQ(Way(7)(2), 7);
}

TEST(HandPath, PassesThroughItsRowsWithoutKinks) {
  const HandPath path(
      "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
      "1,0,0,0,1,0,0,0\n1.1,1,0,2,-0.995004165,0,0,-0.099833417\n1.3,1,3,0,1,0,0,0\n1.4,0,0,0,1,0,0,0\n",
      "rows.csv");
  EXPECT_DOUBLE_EQ(path.duration_s(), 1.4 - 1);
  EXPECT_LT(glm::distance(path.CalcPose(0.1).p_AB, Vec3(1, 0, 2)), 1e-12);
  // The rotation is 0.2 rad about z; the row contains -q.
  EXPECT_NEAR(path.CalcPose(0.1).Vector({1, 0, 0}).y, std::sin(0.2), 1e-8);
  for (double t = 0.002; t < 0.398; t += 0.001) {
    const Vec3 before = path.CalcPose(t).p_AB - path.CalcPose(t - 0.001).p_AB;
    const Vec3 after = path.CalcPose(t + 0.001).p_AB - path.CalcPose(t).p_AB;
    // A kink of the polygon would be a jump of 20 mm/s; the acceleration of a cubic is below 3000 mm/s2 here.
    EXPECT_LT(glm::length(after - before), 3000 * 1e-6) << t;
  }
}

TEST(Paths, AllNamesExist) {
  EXPECT_GE(NamesOfStudyPaths().size(), 12U);
  const StudyPathList list = MakeStudyPaths({}, "");
  EXPECT_EQ(list.paths.size() + list.left_out.size(), NamesOfStudyPaths().size());
  ASSERT_EQ(list.left_out.size(), 1U);
  EXPECT_EQ(list.left_out.front().first, "ct");
  EXPECT_THAT(list.left_out.front().second, testing::HasSubstr("Visible Human"));
}

TEST(Paths, UnknownPathIsReportedWithTheMostSimilarOne) {
  try {
    MakeStudyPaths({"slott"}, "");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("\"slot\"")) << error.what();
  }
}

TEST(Paths, AreSmoothAndAsFastAsAHand) {
  for (const StudyPath& path : MakeOwnPaths()) {
    SCOPED_TRACE(path.name);
    EXPECT_GE(path.duration_s, 1);
    EXPECT_LE(path.duration_s, 2.5);
    for (const Holding holding : path.holdings) {
      SCOPED_TRACE(ToString(holding));
      const std::vector<CaseInput> inputs = MakeCaseInputs(path, holding, 1000);
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        ASSERT_TRUE(IsValid(inputs[i].X_W));
        // The fastest motion is lifting the saw out, at 40 mm/s with a handle; cutting is slower.
        ASSERT_LE(glm::length(inputs[i].v_W_mm_per_s), holding == Holding::kHand ? 45 : 13) << i;
        ASSERT_LE(glm::length(inputs[i].w_W_rad_per_s), 0.5) << i;
        if (i == 0) continue;
        // The speed is reached from rest in at least 0.1 s, so the acceleration is at most 0.6 m/s2, plus 0.2 of the
        // tremor.
        ASSERT_LE(glm::length(inputs[i].v_W_mm_per_s - inputs[i - 1].v_W_mm_per_s), 0.8) << i;
      }
    }
  }
}

TEST(Paths, BeginInTheAirAndGoIntoTheBone) {
  for (const StudyPath& path : MakeOwnPaths()) {
    SCOPED_TRACE(path.name);
    const auto depth = [&](const Pose& X_WT) {
      double deepest = 1e9;
      for (int i = 0; i < 720; ++i) {
        const double angle = std::numbers::pi * i / 360;
        const Vec3 p_T = path.saw.radius_mm() * Vec3(std::cos(angle), std::sin(angle), 0);
        deepest = std::min(deepest, path.solid.distance_mm(X_WT.Point(p_T)));
      }
      return deepest;
    };
    for (const Holding holding : path.holdings) {
      SCOPED_TRACE(ToString(holding));
      double deepest = 1e9;
      for (double t = 0; t <= path.duration_s; t += 0.05) deepest = std::min(deepest, depth(path.pose(holding, t)));
      if (path.name != "worst") {
        EXPECT_GT(depth(path.pose(holding, 0)), 0.1);
      }
      if (path.name == "idle") {
        EXPECT_GT(deepest, 0.2);
        EXPECT_LT(deepest, 0.4);
      } else {
        EXPECT_LT(deepest, path.name == "lamella" || path.name == "skim" ? -0.09 : -0.2);
      }
    }
  }
}

double LeastPeak_N(const std::string& path) {
  if (path == "skim") return 0.05;
  if (path == "graze") return 0.1;
  return path == "wedge" ? 0.5 : 2;
}

TEST(Paths, ForcesAreRealisticAndReproducible) {
  StudySettings coarse;
  coarse.voxel_mm = 0.2;
  coarse.law = "hertz_chip";  // the bounds below are of its forces
  for (const StudyPath& path : MakeOwnPaths()) {
    SCOPED_TRACE(path.name);
    for (const Holding holding : path.holdings) {
      SCOPED_TRACE(ToString(holding));
      const CasePass pass = RunCasePass(path, holding, coarse);
      EXPECT_EQ(pass.f_W_N.size(), static_cast<std::size_t>(std::lround(1000 * path.duration_s)));
      if (path.name == "idle") {
        EXPECT_EQ(FindPeak(pass), 0);
        EXPECT_NEAR(pass.removed_mm3, 0,
                    1e-9);  // where the kerf in the air meets a cell with bone, its parts are summed
        continue;
      }
      // The shallow path has a small force; the others have those of saw strokes, from a few newtons to 20.
      EXPECT_GT(FindPeak(pass), LeastPeak_N(path.name));
      EXPECT_LT(FindPeak(pass), 20);
      EXPECT_GT(pass.removed_mm3, path.name == "skim" ? 0.1 : 0.3);
      if (path.name != "entry" && path.name != "tilt") continue;
      const CasePass again = RunCasePass(path, holding, coarse);
      EXPECT_EQ(again.force_hash, pass.force_hash);
      EXPECT_EQ(again.bone_hash, pass.bone_hash);
    }
  }
}

TEST(Paths, BoneMatchesTheSolidAtAnyVoxelSize) {
  for (const char* name : {"border", "mandible"}) {
    SCOPED_TRACE(name);
    const StudyPath path = MakeStudyPaths({name}, "").paths.front();
    const Bone bone = path.make_bone(0.2, 3);
    EXPECT_DOUBLE_EQ(bone.voxel_mm(), 0.2);
    const Bone again = path.make_bone(0.2, 3);
    EXPECT_EQ(bone.CalcHash(), again.CalcHash());
    const Box3 box = bone.CalcBounds();
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 fraction(std::fmod(0.7548777 * i, 1), std::fmod(0.5698403 * i, 1), std::fmod(0.8191725 * i, 1));
      const Vec3 p_W = box.lower + fraction * box.size();
      const double d = path.solid.distance_mm(p_W);
      if (std::abs(d) < 0.2) continue;  // the grid blurs edges by less than a voxel
      EXPECT_EQ(bone.SignedDistance(p_W) < 0, d < 0);
      inside += d < 0 ? 1 : 0;
      if (d < 0) {
        EXPECT_GT(path.solid.material(p_W).E_MPa, 0);
      }
    }
    EXPECT_GT(inside, 400);
  }
}

TEST(ScenePath, HasTheBoneThePathAndTheToolOfItsScene) {
  const StudyPath path = MakeScenePath("hand", KERF_SOURCE_DIR "/scenes/hand_held_cut.toml");
  EXPECT_EQ(path.name, "hand");
  EXPECT_DOUBLE_EQ(path.coupling.stiffness_N_per_mm, 1);
  // Each of its 20 strokes is 27.01 mm long, at 2 mm/s, in a block with its top at z = 0. They are 2 mm apart.
  const double stroke_s = std::hypot(27, 0.8) / 2;
  EXPECT_NEAR(path.duration_s, 20 * stroke_s, 1e-9);
  EXPECT_EQ(path.lifts_s.size(), 19u);
  EXPECT_LT(glm::distance(path.pose(Holding::kPath, 0).p_AB, Vec3(-19, 0, 12)), 1e-12);
  EXPECT_LT(glm::distance(path.pose(Holding::kPath, 5.5 * stroke_s).p_AB, Vec3(-8.6, 0, -1.5)), 1e-9);
  EXPECT_NEAR(path.solid.distance_mm({0, 0, -1}), -1, 1e-12);
  EXPECT_NEAR(path.solid.distance_mm({0, 0, 1}), 1, 1e-12);
  EXPECT_EQ(path.solid.material({0, 0, -2}).region, 24);
  EXPECT_EQ(path.solid.material({0, 0, -3}).region, 32);
  EXPECT_NEAR(path.make_bone(0.4, 3).CalcVolume(), 44 * 12 * 20, 0.01 * 44 * 12 * 20);
}

}  // namespace
}  // namespace kerf
