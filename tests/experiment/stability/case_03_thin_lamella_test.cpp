// Hard case 3: a lamella one or two voxels thick, in contact with the disc's flat and with its edge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;
using test::Verdict;
using test::WatchedTool;

/// Lays the disc flat from +y on a plate across y of the block's frame and pushes it with 10 N.
struct LaidOn {
  LaidOn(const Pose& X_WB, double voxel_mm, double thickness_mm, double rpm) {
    CoupledParams params = test::DiscParams();
    params.coupling.torsion_Nmm_per_rad = 1e6;
    const double touch_y = 0.5 * thickness_mm + 0.5 * kSaw.thickness_mm;
    WatchedTool tool(test::MakeBox(X_WB, {24, thickness_mm, 24}, voxel_mm), params,
                     DiscPose(X_WB, {0, touch_y + 0.3, 0}));
    for (int i = 1; i <= 400; ++i) {
      const double y = std::max(touch_y + 0.3 - 0.05 * i, touch_y - 10);
      const CoupledOutput out = tool.Tick(DiscPose(X_WB, {0, y, 0}), rpm);
      force_N = glm::dot(out.f_H_W_N, X_WB.Vector({0, 1, 0}));
      max_N = std::max(max_N, glm::length(out.f_H_W_N));
      gap_mm = X_WB.InversePoint(out.X_WT.p_AB).y - touch_y;
    }
    tool.invariants.CheckBone();
  }
  double gap_mm = 0, force_N = 0, max_N = 0;
};

TEST(HardCase03, LamellaHoldsTheFlatDiscLikeThickBone) {
  Verdict verdict("holds");
  double sunk_mm = 0, off_N = 0;
  for (const double h : {0.2, 0.4}) {
    for (const double layers : {1.0, 1.5, 2.0}) {
      for (const std::size_t n : {0u, 1u, 5u}) {
        if (n == 1 && layers == 1) continue;  // there is no interior, so MakeBone() refuses
        for (const double rpm : {0.0, 7500.0}) {
          const LaidOn thin(BlockPoses(h)[n], h, layers * h, rpm);
          // The coupling's 10 N (at 1 N/mm) act on about a hundred points of 3000 N/mm. There are also 0.002 voxels of
          // play.
          EXPECT_NEAR(thin.gap_mm, 0, 0.003) << h << " " << layers << " " << n << " " << rpm;
          EXPECT_NEAR(thin.force_N, 10, 0.01) << h << " " << layers << " " << n << " " << rpm;
          EXPECT_LE(thin.max_N, 10.002);  // force of one face; both faces would give 20
          sunk_mm = std::max(sunk_mm, -thin.gap_mm);
          off_N = std::max(off_N, std::abs(thin.force_N - 10));
        }
      }
    }
  }
  verdict.AtMost("penetration of a lamella of 1 to 2 voxels under 10 N", 1000 * sunk_mm, 3, "um");
  verdict.AtMost("force difference from thick bone", 1000 * off_N, 10, "mN");
}

/// Returns the force on the hand while the handle moves down at a steady feed, edge first, in the block's frame.
std::vector<Vec3> Plunge(const Pose& X_WB, double voxel_mm, double top_mm, double thickness_mm, const char* law,
                         double feed_mm_per_s) {
  CoupledParams params = test::DiscParams();
  params.law = ForceLaw(law);
  // The strip is 2 mm wide, so the rim passes through all of it within 0.05 mm.
  Pose X_WS = X_WB;
  X_WS.p_AB = X_WB.Point({0, 0, top_mm - 0.5 * thickness_mm});
  WatchedTool tool(test::MakeBox(X_WS, {2, 5, thickness_mm}, voxel_mm), params, DiscPose(X_WB, {0, 0, kR + 0.6}));
  std::vector<Vec3> f;
  for (double z = kR + 0.6; z > kR - 6; z -= 0.001 * feed_mm_per_s) {
    const CoupledOutput out = tool.Tick(DiscPose(X_WB, {0, 0, z}));
    f.push_back(X_WB.InverseVector(out.f_H_W_N));
  }
  tool.invariants.CheckBone();
  return f;
}

TEST(HardCase03, LamellaResistsTheEdgeNoMoreThanThickBoneAndReleasesItAtOnce) {
  Verdict verdict("holds");
  double over_N = 0, slow_fraction = 0, pull_N = 0, rise_N = 0, side_fraction = 0, min_peak_N = 1e9;
  for (const double h : {0.2, 0.4}) {
    for (const std::size_t n : {0u, 5u}) {  // the plate's middle on a layer of voxels; oblique to them
      for (const char* law : {"hertz_chip", "edge_plus_chip"}) {
        for (const double feed : {5.0, 20.0}) {
          const Pose X_WB = BlockPoses(h)[n];
          for (const double layers : {1.0, 2.0}) {
            const double top_mm = 0.5 * layers * h;
            SCOPED_TRACE(testing::Message() << h << " " << n << " " << law << " " << feed << " " << layers);
            const std::vector<Vec3> thick = Plunge(X_WB, h, top_mm, 6, law, feed);
            const std::vector<Vec3> f = Plunge(X_WB, h, top_mm, layers * h, law, feed);
            std::size_t peak = 0;
            double side_N = 0;
            for (std::size_t i = 0; i < f.size(); ++i) {
              if (f[i].z > f[peak].z) peak = i;
              over_N = std::max(over_N, f[i].z - thick[i].z);
              pull_N = std::max(pull_N, -f[i].z);
              side_N = std::max(side_N, std::hypot(f[i].x, f[i].y));
            }
            side_fraction = std::max(side_fraction, side_N / f[peak].z);
            min_peak_N = std::min(min_peak_N, f[peak].z);
            // At breakthrough the force falls from its peak to zero within the time in which the tool passes a voxel.
            std::size_t gone = peak;
            while (gone < f.size() && f[gone].z > 0.05 * f[peak].z) {
              if (gone > peak) rise_N = std::max(rise_N, f[gone].z - f[gone - 1].z);
              ++gone;
            }
            ASSERT_LT(gone, f.size());
            slow_fraction = std::max(slow_fraction, 0.001 * static_cast<double>(gone - peak) / (h / feed));
            for (std::size_t i = gone; i < f.size(); ++i) EXPECT_LE(glm::length(f[i]), 0.05 * f[peak].z);
            EXPECT_EQ(f.back(), Vec3(0));
          }
        }
      }
    }
  }
  EXPECT_GT(min_peak_N, 0.1);  // there was bone to break through
  verdict.AtMost("force in excess of that of thick bone", 1000 * over_N, 5, "mN");
  verdict.AtMost("time from peak to below 5 % relative to h/v", slow_fraction, 1);
  verdict.AtMost("kick: pull along the feed", 1000 * pull_N, 0.01, "mN");
  verdict.AtMost("kick: rise against the feed after the peak", 1000 * rise_N, 5, "mN");
  verdict.AtMost("force across the feed relative to the peak", side_fraction, 0.1);
}

TEST(HardCase03, HandIsNotKickedWhenALamellaBreaks) {
  // This is the complete loop: a hand pushes on a strip with 5 N and falls through it.
  Verdict verdict("holds");
  double kick_N = 0, back_mm = 0, slow_ms = 0, step_fraction = 0;
  for (const char* hand : {"H2", "H3", "H4"}) {
    for (const double h : {0.2, 0.4}) {
      SCOPED_TRACE(testing::Message() << hand << " " << h);
      test::HeldSawOptions options;
      options.profile = FindDeviceProfile("omega_6");
      options.hand = hand;
      options.stiffness_N_per_mm = 2;
      options.voxel_mm = h;
      options.block_mm = {2, 6, 2 * h};
      options.above_mm = 0.1;
      test::HeldSaw saw(options);
      test::Invariants invariants(saw.simulation, saw.start);
      invariants.WatchDevice(options.profile, options.force_map);
      saw.device.SetScript(
          IntentionScript(saw.start, {{.seconds = 1e5, .X_WH = saw.start, .push_W_N = {0, 0, -5}, .yield_s = 0.05}}));
      const double scale = saw.step.force_map().force_scale();
      double max_N = 0, lowest_mm = 1e9;
      int broke = -1, gone = -1;
      Vec3 last_N(0);
      for (int i = 0; i < 3000 && (broke < 0 || i < broke + 150); ++i) {
        const HapticTick out = saw.Step();
        invariants.Step(out);
        const Vec3 f_N = out.force.f_H_W_N;
        step_fraction = std::max(step_fraction, glm::length(f_N - last_N) / (0.2 * options.profile.peak_force_N));
        last_N = f_N;
        const double z = saw.device.p_WC_mm().z;
        if (broke < 0) max_N = std::max(max_N, f_N.z);
        if (broke < 0 && out.coupled.X_WT.p_AB.z < kR - 2 * h - 0.1) broke = i;
        if (broke < 0) continue;
        // While the slew rate limits the force, the motors still push in the same direction, but never with more force
        // and never in reverse.
        EXPECT_LE(f_N.z, max_N);
        kick_N = std::max(kick_N, -f_N.z);
        if (gone < 0 && f_N.z <= 0.05 * max_N) gone = i;
        lowest_mm = std::min(lowest_mm, z);
        back_mm = std::max(back_mm, z - lowest_mm);
      }
      ASSERT_GE(gone, 0);
      EXPECT_GT(max_N, 0.1 * scale);
      slow_ms = std::max(slow_ms, static_cast<double>(gone - broke));
      invariants.CheckBone();
    }
  }
  verdict.AtMost("pull on the hand after breakthrough", 1000 * kick_N, 1, "mN");
  verdict.AtMost("rebound of the handle", 1000 * back_mm, 10, "um");
  // At the slew rate, the device's force falls from its peak to zero in 5 ms.
  verdict.AtMost("time until the force is gone", slow_ms, 6, "ms");
  verdict.AtMost("force step relative to the slew limit", step_fraction, 1 + 1e-9);
}

}  // namespace
}  // namespace kerf
