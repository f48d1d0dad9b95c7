// Hard case 5: the tool starts inside the bone. It is constructed there, set down there (undo, load), or held by a
// device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cut/removal/cutter.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::Verdict;
using test::WatchedTool;

const Vec3 kStartInsideSize(25, 4, 25);  // its top at z = 12.5

CoupledParams MakeParams() {
  CoupledParams params = test::DiscParams();
  params.spare_leaves = 20000;
  return params;
}
void CheckAll(test::Invariants& invariants) {
  invariants.CheckBone();
  for (const auto& [name, what] : invariants.violations()) ADD_FAILURE() << name << " " << what;
}
constexpr test::Invariants::Options kQuiet{.watch_bone = true, .report = false};

/// Returns a pose `depth_mm` below the top, upright or rotated.
Pose Inside(double depth_mm, bool askew) {
  Pose X = DiscPose(Pose{}, {0.03, 0.02, 0.5 * kStartInsideSize.z + kR - depth_mm});
  if (askew) X.R_AB = X.R_AB * glm::angleAxis(0.1, glm::normalize(Vec3(1, 1, 0.3)));
  return X;
}

TEST(HardCase05, ToolCreatedOrSetDownInBoneRestsWithoutForce) {
  Verdict verdict("holds; bone that overlaps the tool is removed in the first tick with a turning spindle");
  double force_N = 0, moved_mm = 0, later_mm3 = 0;
  for (const double h : {0.2, 0.4}) {
    const Bone bone = test::MakeBox(Pose{}, kStartInsideSize, h);
    for (const double depth : {0.5, 3.0, 11.0, 23.5}) {  // in the last one, the disc is entirely buried
      for (const bool askew : {false, true}) {
        for (const bool set_down : {false, true}) {
          SCOPED_TRACE(testing::Message() << h << " " << depth << " " << askew << set_down);
          const Pose X = Inside(depth, askew);
          const Pose X_away = DiscPose(Pose{}, {0, 0, 60});
          CoupledSimulation simulation(bone, MakeParams(), set_down ? X_away : X);
          if (set_down) {
            for (int i = 0; i < 50; ++i)
              simulation.Tick(Handle(X, 0));  // the handle is there, but the tool is held outside
            ASSERT_TRUE(simulation.SetDown(X));
          }
          test::Invariants invariants(simulation, X, kQuiet);
          for (const double rpm : {0.0, 7500.0, 0.0}) {
            for (int i = 0; i < 60; ++i) {
              const CoupledInput in = Handle(X, rpm);
              const CoupledOutput out = simulation.Tick(in);
              invariants.Tick(in, out);
              force_N = std::max(force_N, glm::length(out.f_H_W_N) + 0.01 * glm::length(out.tau_H_W_Nmm));
              moved_mm = std::max(moved_mm, glm::length(out.X_WT.p_AB - X.p_AB));
              // The bone that overlaps the tool is removed in the first tick in which the spindle turns, and none after
              // that.
              if (i > 0 || rpm == 0) later_mm3 += out.removed_mm3;
            }
          }
          EXPECT_GT(invariants.removed_mm3(), 0.01 * depth);
          CheckAll(invariants);
        }
      }
    }
  }
  verdict.AtMost("force at rest from the first tick on", force_N, 1e-9, "N");
  verdict.AtMost("spontaneous motion", 1000 * moved_mm, 1e-3, "um");
  verdict.Equal("volume removed after the first turning tick", later_mm3, 0, "mm3");
}

TEST(HardCase05, ToolSetDownFarFromTheHandNeverExceedsTheCouplingAndComesOut) {
  // This is an undo with the hand elsewhere: the tool is in the bone, the handle above it. The force is at most the
  // coupling's maximum and never points away from the tool. The handle draws the tool out along its kerf.
  Verdict verdict("holds");
  double over_N = 0, away_N = 0, left_mm = 0, ticks = 0, stuck = 0;
  for (const double h : {0.2, 0.4}) {
    const Bone bone = test::MakeBox(Pose{}, kStartInsideSize, h);
    for (const double depth : {0.5, 3.0, 11.0}) {
      for (const bool askew : {false, true}) {
        for (const double rpm : {0.0, 7500.0}) {
          SCOPED_TRACE(testing::Message() << h << " " << depth << " " << askew << " " << rpm);
          const Pose X = Inside(depth, askew);
          Pose X_WH = X;
          X_WH.p_AB += X.Vector({0, -1, 0}) * 60.0;  // out along the disc's own plane
          CoupledParams params = MakeParams();
          params.coupling.max_force_N = 20;
          WatchedTool tool(bone, params, X_WH);
          ASSERT_TRUE(tool.simulation.SetDown(X));
          tool.invariants.SetDown(X);
          int out_at = -1;
          CoupledOutput out;
          for (int i = 0; i < 600 && out_at < 0; ++i) {
            // A tool that is stuck while the spindle is stopped comes free when the spindle turns.
            out = tool.Tick(X_WH, i < 300 ? rpm : 7500);
            over_N = std::max(over_N, glm::length(out.f_H_W_N) - 20);
            // The force on the hand points towards the tool.
            const Vec3 towards = out.X_WT.p_AB - X_WH.p_AB;
            away_N = std::max(away_N, -glm::dot(out.f_H_W_N, towards) / std::max(1.0, glm::length(towards)));
            if (out.status & kCoupledAsleep) out_at = i;
          }
          EXPECT_GE(out_at, 0);
          (out_at < 300 ? ticks : stuck) += out_at < 300 ? std::max(0.0, out_at - ticks) : 1;
          out = tool.Tick(X_WH, rpm);
          EXPECT_EQ(out.f_H_W_N, Vec3(0));
          left_mm = std::max(left_mm, glm::length(out.X_WT.p_AB - X_WH.p_AB));
          tool.invariants.CheckBone();
        }
      }
    }
  }
  verdict.AtMost("force in excess of the coupling's maximum of 20 N", over_N, 1e-9, "N");
  verdict.AtMost("push away from the handle", away_N, 1e-9, "N");
  verdict.AtMost("ticks until the tool is out and free", ticks, 300);
  verdict.AtMost("stopped discs, out of 12, that stuck until the spindle turned", stuck, 2);
  verdict.Equal("final distance of the tool from the handle", left_mm, 0, "mm");
}

TEST(HardCase05, BuriedToolIsHeldByTheSurroundingBone) {
  // The tool is pushed with 5 N for 0.2 s along each axis. Pushes on the flats do not move it. In its plane, a stopped
  // rim does not move either, and a turning rim continues to cut with at most 5 N of feed force.
  Verdict verdict("holds");
  double sideways_mm = 0, stopped_mm = 0, cut_mm = 0, max_N = 0;
  for (const double h : {0.2, 0.4}) {
    const Bone bone = test::MakeBox(Pose{}, kStartInsideSize, h);
    for (const bool askew : {false, true}) {
      for (const double rpm : {0.0, 7500.0}) {
        SCOPED_TRACE(testing::Message() << h << " " << askew << " " << rpm);
        const Pose X = Inside(23.5, askew);
        // A kerf is at least as wide as a voxel (docs/physics.md): a turning disc has this much room in it.
        const double play_mm = rpm == 0 ? 0 : CalcKerfWidth(kSaw.thickness_mm, h) - kSaw.thickness_mm;
        WatchedTool tool(bone, MakeParams(), X);
        for (int axis = 0; axis < 3; ++axis) {
          for (const double side : {1.0, -1.0}) {
            const Vec3 direction = X.Vector(Vec3(axis == 0, axis == 1, axis == 2)) * side;
            const Vec3 from = tool.X_WT.p_AB;
            for (int i = 0; i < 200; ++i) {
              const CoupledOutput out = tool.Push(X.R_AB, 5.0 * direction, rpm);
              max_N = std::max(max_N, glm::length(out.f_H_W_N));
            }
            double moved_mm = std::abs(glm::dot(tool.X_WT.p_AB - from, direction));
            if (axis == 2) moved_mm -= play_mm;
            double& max_mm = axis == 2 ? sideways_mm : rpm == 0 ? stopped_mm : cut_mm;
            max_mm = std::max(max_mm, moved_mm);
          }
        }
        tool.invariants.CheckBone();
      }
    }
  }
  verdict.AtMost("displacement along the spindle in a kerf as wide as the disc", 1000 * sideways_mm, 50, "um");
  verdict.AtMost("displacement in the disc's plane, spindle stopped", 1000 * stopped_mm, 10, "um");
  verdict.AtMost("further cut in the disc's plane, spindle turning", cut_mm, 2, "mm");
  // If a wall is nearer than the state of its spring implies, it pushes the tool out at 2 mm/s at most
  // (PenetrationLimiter): 2 um per tick, plus rotation.
  verdict.AtMost("force on the hand", max_N, 5.02, "N");
}

TEST(HardCase05, DeviceForceStartsAtZeroAndRampsIn) {
  // This is the complete step, with the default ramp and slew rate. The tool is set down in the bone 5 mm from the
  // handle, which would give 5 N at once without ramp and slew rate.
  Verdict verdict("holds");
  double first_N = 0, step_fraction = 0, ramp_fraction = 0, peak_fraction = 0, over_fraction = 0;
  for (const char* profile : {"omega_6", "touch"}) {
    for (const char* hand : {"H0", "H1", "H3"}) {
      for (const double depth : {3.0, 23.5}) {
        for (const double rpm : {0.0, 7500.0}) {
          SCOPED_TRACE(testing::Message() << profile << " " << hand << " " << depth << " " << rpm);
          test::HeldSawOptions options;
          options.profile = FindDeviceProfile(profile);
          options.hand = hand;
          options.stiffness_N_per_mm = 1;
          options.damping_Ns_per_mm = 0.002;
          options.voxel_mm = 0.4;
          options.above_mm = 5 - depth;
          test::HeldSaw saw(options);
          test::Invariants invariants(saw.simulation, saw.start, kQuiet);
          invariants.WatchDevice(options.profile, options.force_map);
          Pose X = saw.start;
          X.p_AB.z -= 5;
          ASSERT_TRUE(saw.simulation.SetDown(X));
          invariants.SetDown(X);
          const ForceMapParams& map = saw.step.force_map().params();
          const double scale = saw.step.force_map().force_scale();
          Vec3 last_N(0);
          double max_N = 0;
          for (int i = 0; i < 1000; ++i) {
            const HapticTick out = saw.Step(rpm);
            invariants.Step(out);
            const Vec3 f_N = out.force.f_H_W_N;
            if (i == 0) first_N = std::max(first_N, glm::length(f_N) / (scale * 5));
            step_fraction =
                std::max(step_fraction, glm::length(f_N - last_N) / (0.001 * options.profile.peak_force_N / 0.005));
            // The force is at most the fraction that the ramp allows.
            const double asked_N = scale * glm::length(out.coupled.f_H_W_N);
            const double t = std::min(1.0, 0.001 * (i + 1) / map.ramp_in_s);
            const double ramp = t * t * (3 - 2 * t);
            if (i < 400 && asked_N > 1e-3) ramp_fraction = std::max(ramp_fraction, glm::length(f_N) / (asked_N * ramp));
            peak_fraction = std::max(peak_fraction, glm::length(f_N) / options.profile.peak_force_N);
            max_N = std::max(max_N, glm::length(f_N));
            last_N = f_N;
          }
          // The hand feels a force, except where the disc turns in a kerf that is open above and comes out of it.
          if (depth > 2 * kR || rpm == 0) {
            EXPECT_GT(max_N, 0);
          }
          over_fraction = std::max(over_fraction, max_N / (scale * 5));
          CheckAll(invariants);
        }
      }
    }
  }
  verdict.AtMost("force in the first tick relative to 5 N", first_N, 0.01);
  verdict.AtMost("force step relative to the slew limit", step_fraction, 1 + 1e-9);
  verdict.AtMost("force relative to what the ramp allows", ramp_fraction, 1.05);
  verdict.AtMost("force relative to the device's peak", peak_fraction, 1);
  verdict.AtMost("force relative to the spring force at set-down", over_fraction, 1);
}

TEST(HardCase05, NoDeviceForceIsLeftOncePulledOutOfBone) {
  // The tool starts buried with the hand pushing on it, and is then pulled out and free. No force is left, and the
  // force never exceeded the hand's.
  Verdict verdict("holds");
  double idle_N = 0, over = 0, noise_N = 0;
  for (const double rpm : {0.0, 7500.0}) {
    for (const char* hand : {"H2", "H4"}) {
      SCOPED_TRACE(testing::Message() << hand << " " << rpm);
      test::HeldSawOptions options;
      options.profile = FindDeviceProfile("omega_6");
      options.hand = hand;
      options.stiffness_N_per_mm = 1;
      options.damping_Ns_per_mm = 0.002;
      options.voxel_mm = 0.4;
      options.above_mm = -8;
      test::HeldSaw saw(options);
      test::Invariants invariants(saw.simulation, saw.start, kQuiet);
      invariants.WatchDevice(options.profile, options.force_map);
      Pose X_up = saw.start;
      X_up.p_AB.z += 20;
      saw.device.SetScript(IntentionScript(saw.start, {{.seconds = 1.5, .X_WH = saw.start, .push_W_N = {0, 0, -4}},
                                                       {.seconds = 1, .X_WH = X_up},
                                                       {.seconds = 0.5, .X_WH = X_up}}));
      std::vector<Vec3> held;
      for (int i = 0; i < 3000; ++i) {
        const HapticTick out = saw.Step(rpm);
        invariants.Step(out);
        const double force_N = glm::length(out.force.f_H_W_N);
        over = std::max(over, force_N - 4 * 1.05);
        if (i >= 1000 && i < 1500) held.push_back(out.force.f_H_W_N);
        if (i >= 2900) idle_N = std::max(idle_N, force_N);
      }
      EXPECT_GT(glm::length(held.back()), 0.3);
      noise_N = std::max(noise_N, CalcNoise(held, 0.001));
      CheckAll(invariants);
    }
  }
  verdict.AtMost("force in excess of the hand's push of 4 N", std::max(0.0, over), 0, "N");
  verdict.AtMost("noise while pushed", 1000 * noise_N, 20, "mN");
  verdict.Equal("force outside the bone", idle_N, 0, "N");
}

}  // namespace
}  // namespace kerf
