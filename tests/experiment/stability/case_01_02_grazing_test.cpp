// Hard cases 1 and 2: the rim grazes a flat face, from just above it to one voxel deep, and touches it exactly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;
using test::Verdict;
using test::WatchedTool;

constexpr double kGrazingDt_s = 0.001;
constexpr double kRounding_N = 1e-6;  // rounding error of the solver with bone near but not in contact
const Vec3 kSize(16, 4, 6);

/// Returns a block with its top at z = 0 of X_WB and the disc above it.
WatchedTool MakeOver(const Pose& X_WB, double voxel_mm, double x, double above_mm,
                     const CoupledParams& params = test::DiscParams()) {
  Pose X_WC = X_WB;
  X_WC.p_AB = X_WB.Point({0, 0, -0.5 * kSize.z});
  return {test::MakeBox(X_WC, kSize, voxel_mm), params, DiscPose(X_WB, {x, 0, kR + above_mm})};
}

struct Sweep {
  std::vector<Vec3> f;     // on the hand, in the block's frame
  std::vector<double> up;  // along z
  double removed_mm3 = 0;
  double max_N = 0;
};

constexpr int kLowering = 40;  // ticks

/// The handle comes down to `depth_mm` below the face, moves 8 mm along it at 20 mm/s and is lifted again.
Sweep Graze(const Pose& X_WB, double voxel_mm, double depth_mm, double rpm) {
  constexpr double kFeed_mm_per_s = 20;
  const double above_mm = 0.5 * voxel_mm;
  WatchedTool tool = MakeOver(X_WB, voxel_mm, -4, above_mm);
  Sweep sweep;
  const auto go = [&](double x, double z) {
    const CoupledOutput out = tool.Tick(DiscPose(X_WB, {x, 0, kR + z}), rpm);
    const double force_N = glm::length(out.f_H_W_N);
    sweep.f.push_back(X_WB.InverseVector(out.f_H_W_N));
    sweep.up.push_back(force_N < kRounding_N ? 0 : sweep.f.back().z);
    sweep.max_N = std::max(sweep.max_N, force_N);
    sweep.removed_mm3 += out.removed_mm3;
  };
  for (int i = 1; i <= kLowering; ++i) go(-4, above_mm - (above_mm + depth_mm) * i / kLowering);
  for (double x = -4; x < 4; x += kFeed_mm_per_s * kGrazingDt_s) go(x, -depth_mm);
  for (int i = 1; i <= kLowering; ++i) go(4, above_mm - (above_mm + depth_mm) * (kLowering - i) / kLowering);
  tool.invariants.CheckBone();
  return sweep;
}

TEST(HardCase01, GrazingForceFallsToZeroWithTheDepth) {
  // The catalogue's depth^1.5 is Hertz's law against a fixed wall. Here the coupling's spring is in series, so the
  // force is at most the spring's stiffness times the handle's depth. A tooth detects the face where
  // it reaches it, or a floor that it has cut a twentieth of a voxel before (kLookAheadVoxels; this test allows a
  // quarter). At greater distances the force is zero, and it rises from there continuously.
  Verdict verdict("holds, but the force follows the spring, not depth^1.5");
  double over_fraction = 0, before_N = 0, slope = 0;
  double toggles = 0, turns = 0, kick = 0;
  for (const double h : {0.2, 0.4}) {
    for (const std::size_t n : {0u, 1u, 5u}) {
      for (const double rpm : {7500.0, 0.0}) {
        double last_N = 0, last_depth = -1;
        for (const double depth : {-0.3 * h, -0.1 * h, -1e-9, 0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1 * h, 0.3 * h, h}) {
          SCOPED_TRACE(testing::Message() << h << " " << n << " " << rpm << " " << depth);
          const Sweep s = Graze(BlockPoses(h)[n], h, depth, rpm);
          const double seen_mm = std::max(0.0, depth + 0.25 * h);
          // A stopped edge has no look-ahead.
          if (seen_mm == 0 || (rpm == 0 && depth < 0)) {
            EXPECT_LT(s.max_N, kRounding_N);
          }
          if (seen_mm > 0) over_fraction = std::max(over_fraction, s.max_N / seen_mm);  // 1 N/mm
          if (depth <= 0) before_N = std::max(before_N, s.max_N);
          // The force is Lipschitz in the depth, with at most the coupling's stiffness.
          if (last_depth > -1 && depth - last_depth > 1e-4) {
            slope = std::max(slope, (s.max_N - last_N) / (depth - last_depth));
          }
          if (depth - last_depth < 1e-4) {
            EXPECT_NEAR(s.max_N, last_N, 2e-4);
          }
          last_N = s.max_N;
          last_depth = depth;
          // Contact must begin once and end once.
          const double time_s = kGrazingDt_s * static_cast<double>(s.up.size() - 1);
          toggles = std::max(toggles, CountToggles(s.up, kGrazingDt_s, 0).contact_per_s * time_s);
          turns = std::max(turns, CountToggles(s.up, kGrazingDt_s, 0.035).turns_per_s * time_s);
          kick = std::max(kick, CalcTickSteps(s.f).max);
          for (const Vec3& f : s.f) EXPECT_GE(f.z, -kRounding_N);
          if (rpm == 0) {
            EXPECT_EQ(s.removed_mm3, 0);
          }
        }
      }
    }
  }
  verdict.AtMost("force relative to the spring force at that depth", over_fraction, 1.05);
  verdict.AtMost("force before contact with the face, 0.4 mm voxels", 1000 * before_N, 100, "mN");
  verdict.AtMost("largest dF / d(depth)", slope, 1.05, "N/mm");
  verdict.AtMost("contact changes in a sweep", toggles, 2);
  verdict.AtMost("force reversals of more than 35 mN in a sweep", turns, 1);
  verdict.AtMost("largest force step in JND", kick, 1);
}

TEST(HardCase01, GrazingCutConvergesWithTheVoxelSize) {
  // Grazes the face by 0.2 mm with voxels of 0.4, 0.2 and 0.1 mm. The floor that a pass has cut is detected a
  // twentieth of a voxel early, so the errors of force and depth decrease with the voxel size. The mean is that of the
  // motion along the face: how long the tool is in the air before and after depends on the voxels.
  Verdict verdict("holds");
  std::vector<double> mean_N;
  for (const double h : {0.4, 0.2, 0.1}) {
    const Sweep s = Graze(BlockPoses(h)[5], h, 0.2, 7500);
    double sum = 0;
    for (std::size_t i = kLowering; i < s.up.size() - kLowering; ++i) sum += s.up[i];
    mean_N.push_back(sum / static_cast<double>(s.up.size() - 2 * kLowering));
  }
  const double coarse_N = std::abs(mean_N[0] - mean_N[1]);
  const double fine_N = std::abs(mean_N[1] - mean_N[2]);
  EXPECT_GT(mean_N[2], 0.02);
  verdict.AtMost("change of the mean force from 0.2 to 0.1 mm voxels relative to that from 0.4 to 0.2 mm",
                 fine_N / coarse_N, 0.6);
  verdict.AtMost("change of the mean force from 0.2 to 0.1 mm voxels relative to the force", fine_N / mean_N[2], 0.25);
}

// ---- case 2

double Step(double x, int ulps) {
  for (; ulps > 0; --ulps) x = std::nextafter(x, 1e9);
  for (; ulps < 0; ++ulps) x = std::nextafter(x, -1e9);
  return x;
}

TEST(HardCase02, ExactTangencyDoesNotDifferFromAnUlpBesideIt) {
  // The rim touches the face in one point, or lies a few ulps above or below it; the disc's flat lies in the plane of
  // the block's side; the spindle is along an axis, or turned from it by an ulp.
  Verdict verdict("holds");
  double max_N = 0, spread_N = 0, moved_mm = 0;
  for (const double h : {0.2, 0.4}) {
    for (const double rpm : {7500.0, 0.0}) {
      for (const double side_y : {0.0, 2.125}) {  // at 2.125 a flat is in the plane of the block's side
        double min_N = 1e9, largest_N = 0;
        for (const int ulps : {0, -1, 1, 7}) {
          for (const int turn_ulps : {0, 1}) {
            SCOPED_TRACE(testing::Message() << h << " " << rpm << " " << side_y << " " << ulps << " " << turn_ulps);
            WatchedTool tool = MakeOver(Pose{}, h, 0, 0.3 * h);
            Pose X = DiscPose(Pose{}, {0, Step(side_y, ulps), Step(kR, ulps)});
            X.R_AB.x = Step(X.R_AB.x, turn_ulps);
            X.R_AB.y = turn_ulps * 1e-300;  // a denormal, on the way to a normal number
            CoupledOutput out;
            for (int i = 0; i < 30; ++i) out = tool.Tick(X, rpm);
            const double force_N = glm::length(out.f_H_W_N);
            min_N = std::min(min_N, force_N);
            largest_N = std::max(largest_N, force_N);
            moved_mm = std::max(moved_mm, glm::length(out.X_WT.p_AB - X.p_AB));
            tool.invariants.CheckBone();
          }
        }
        max_N = std::max(max_N, largest_N);
        spread_N = std::max(spread_N, largest_N - min_N);
      }
    }
  }
  // The tool is held at most by the look-ahead of the edge above the face (case 1).
  verdict.AtMost("force at exact contact, 0.4 mm voxels", 1000 * max_N, 1, "mN");
  verdict.AtMost("force spread over -1 to +7 ulps", spread_N, 1e-6, "N");
  verdict.AtMost("distance of the tool from the handle", 1000 * moved_mm, 1, "um");
}

TEST(HardCase02, OutputsAreFiniteAtEveryUlpAroundTangency) {
  // The poses are those in which the rim just touches the face, with each of their seven numbers varied by ulps.
  Verdict verdict("holds");
  std::uint64_t state = 20261120;
  const auto roll = [&state](int sides) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<int>((state >> 33) % static_cast<std::uint64_t>(sides));
  };
  double max_N = 0;
  int poses = 0;
  for (std::size_t n = 0; n < 8; ++n) {
    const Pose X_WB = BlockPoses(0.4)[n];
    WatchedTool watched = MakeOver(X_WB, 0.4, 0, 1);
    CoupledSimulation& simulation = watched.simulation;  // it is set down so often that energy cannot be accounted for
    const int rounds = static_cast<int>(100 * test::Effort());
    for (int round = 0; round < rounds; ++round) {
      Pose X = DiscPose(X_WB, {0.001 * (roll(2001) - 1000), 0, kR});
      for (int axis = 0; axis < 3; ++axis) X.p_AB[axis] = Step(X.p_AB[axis], roll(5) - 2);
      for (int k = 0; k < 4; ++k) X.R_AB[k] = Step(X.R_AB[k], roll(5) - 2);
      ASSERT_TRUE(simulation.SetDown(X));
      const double rpm = 7500.0 * (roll(3) - 1);
      Pose X_WH = X;
      X_WH.p_AB -= X_WB.Vector({0, 0, 0.01});
      const CoupledOutput out = simulation.Tick(test::Handle(X_WH, rpm));
      EXPECT_EQ(out.status & kCoupledBadPose, 0u);
      ASSERT_TRUE(IsValid(out.X_WT));
      for (const double v :
           {out.cut_mJ, out.friction_mJ, out.numerical_mJ, out.hand_mJ, out.removed_mm3, out.mean_E_MPa,
            out.mean_bite_mm, out.engaged_teeth, out.thrust_sum_N, glm::length(out.f_face_W_N),
            glm::length(out.tau_H_W_Nmm), glm::length(out.f_friction_W_N)}) {
        ASSERT_TRUE(std::isfinite(v));
      }
      max_N = std::max(max_N, glm::length(out.f_H_W_N));
      EXPECT_GE(glm::dot(out.f_H_W_N, X_WB.Vector({0, 0, 1})), -1e-9);
      ++poses;
    }
  }
  verdict.AtLeast("poses within 2 ulps of tangency, all with finite outputs", poses, 70);
  verdict.AtMost("largest force with the handle 0.01 mm below the face", 1000 * max_N, 10.001, "mN");
  EXPECT_GT(max_N, 0.005);
}

}  // namespace
}  // namespace kerf
