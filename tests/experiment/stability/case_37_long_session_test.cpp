// Hard case 37: a long session. Sums must not drift, and rotations must keep their angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/realtime/deadlines.h"
#include "cut/hand_sim/hands.h"
#include "device/devices/profiles.h"
#include "device/devices/velocity.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/force_map.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Effort;
using test::Handle;
using test::Verdict;

const double kClear = 5 + kR + 0.2;  // height of the disc's centre just above the block

Bone MakeLongSessionBlock() {
  return test::MakeBox(Pose{}, {26, 4, 10}, 0.2);
}

TEST(HardCase37, AMillionIdleTicksCauseNoDrift) {
  Verdict verdict("holds: no tooth angle is stored that could grow");
  const Bone bone = MakeLongSessionBlock();
  const Pose start = DiscPose(Pose{}, {0, 0, kClear});
  CoupledSimulation rested(bone, test::DiscParams(), start);
  CoupledSimulation fresh(bone, test::DiscParams(), start);
  const int idle = static_cast<int>(1e6 * Effort());
  double max_N = 0;
  double off_mm = 0;
  for (int i = 1; i <= idle; ++i) {
    // The handle moves in circles, 2 to 8 mm above the bone, and rotates.
    const double angle = 0.01 * i;
    Pose X = DiscPose(Pose{}, {3 * std::sin(angle), 2 * std::cos(angle), kClear + 5 + 3 * std::sin(0.37 * angle)});
    X.R_AB = glm::angleAxis(angle, Vec3(0, 1, 0)) * X.R_AB;
    const CoupledOutput out = rested.Tick(Handle(X));
    max_N = std::max({max_N, glm::length(out.f_H_W_N), glm::length(out.tau_H_W_Nmm), out.hand_mJ, out.stored_mJ});
    off_mm = std::max(off_mm, glm::length(out.X_WT.p_AB - X.p_AB));
  }
  verdict.Equal("largest force, torque or work while idle", max_N, 0);
  verdict.Equal("distance of the tool from the handle", off_mm, 0, "mm");
  rested.Tick(Handle(start));
  fresh.Tick(Handle(start));
  double difference_N = 0;
  double touched_N = 0;
  for (int i = 1; i <= 1500; ++i) {
    const CoupledInput in = Handle(DiscPose(Pose{}, {0.2 * std::sin(0.01 * i), 0, kClear - 0.003 * i}));
    const Vec3 f = rested.Tick(in).f_H_W_N;
    const Vec3 g = fresh.Tick(in).f_H_W_N;
    difference_N = std::max(difference_N, glm::length(f - g));
    touched_N = std::max(touched_N, glm::length(f));
  }
  EXPECT_GT(touched_N, 0.5);
  verdict.AtMost("force difference between a cut after idling and one without", difference_N, 1e-6, "N");
}

TEST(HardCase37, SumsOfMillionsOfPartsEqualTheWhole) {
  Verdict verdict("holds");
  // The same stroke is made in few and in very many ticks. Each of the many ticks removes some millionths of a voxel
  // from hundreds of voxels, and the sum is the same volume.
  CoupledParams params = test::DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.max_force_N = 1e4;
  double sum_mm3[2];
  double exact_mm3[2];
  double account = 0;
  const int many = static_cast<int>(std::max(3000.0, 30000 * std::min(Effort(), 20.0)));
  for (const int run : {0, 1}) {
    const int ticks = run == 0 ? 600 : many;
    const Bone bone = MakeLongSessionBlock();
    CoupledSimulation simulation(bone, params, DiscPose(Pose{}, {0, 0, kClear}));
    double sum = 0;
    for (int i = 1; i <= ticks; ++i) {
      CoupledInput in = Handle(DiscPose(Pose{}, {0, 0, kClear - 3.0 * i / ticks}));
      in.dt_s = 0.6 / ticks;
      sum += simulation.Tick(in).removed_mm3;
    }
    // The tool lags by the stretch of the coupling under the force. When the handle rests, the tool creeps to the same
    // position.
    for (int i = 0; i < 2000; ++i) {
      sum += simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, kClear - 3}))).removed_mm3;
    }
    const std::array<double, 256> removed = simulation.CalcRemovedByRegion();
    sum_mm3[run] = sum;
    exact_mm3[run] = std::accumulate(removed.begin(), removed.end(), 0.0);
    const double lost = bone.CalcVolume() - simulation.UpdateBone().CalcVolume();
    account = std::max(account, std::abs(exact_mm3[run] - lost) / bone.CalcVolume());
  }
  EXPECT_GT(exact_mm3[0], 2);
  verdict.AtMost("difference between the sums over many and over few ticks",
                 1e6 * std::abs(sum_mm3[1] / sum_mm3[0] - 1), 200, "ppm");
  verdict.AtMost("difference between the exact removed volumes", 1e6 * std::abs(exact_mm3[1] / exact_mm3[0] - 1), 200,
                 "ppm");
  verdict.AtMost("error of removed + remaining relative to the initial volume", account, 1e-9);
  EXPECT_NEAR(sum_mm3[1] / exact_mm3[1], 1, 0.03);
}

TEST(HardCase37, ManyStrokesInTheKerfStayTheSame) {
  Verdict verdict("holds");
  // The saw moves in its own kerf, with 250 ticks per stroke. Once the bone in the way is cut, each stroke equals the
  // one before.
  CoupledSimulation simulation(MakeLongSessionBlock(), test::DiscParams(), DiscPose(Pose{}, {0, 0, kClear}));
  const int strokes = static_cast<int>(std::max(400.0, 400 * Effort()));  // with fewer strokes it still cuts
  std::vector<Vec3> early;
  double drift_N = 0;
  double late_mm3 = 0;
  double early_mm3 = 0;
  double max_N = 0;
  for (int stroke = 0; stroke < strokes; ++stroke) {
    for (int i = 0; i < 250; ++i) {
      const double down = std::min(2.0, 0.002 * (250 * stroke + i));
      const double phase = 2 * std::numbers::pi * i / 250;
      const CoupledOutput out =
          simulation.Tick(Handle(DiscPose(Pose{}, {2 * std::sin(phase), 0.3 * std::sin(2 * phase), kClear - down})));
      if (stroke < strokes / 3) early_mm3 += out.removed_mm3;
      if (stroke == strokes - 11) early.push_back(out.f_H_W_N);
      if (stroke < strokes - 10) continue;
      late_mm3 += out.removed_mm3;
      max_N = std::max(max_N, glm::length(out.f_H_W_N));
      drift_N = std::max(drift_N, glm::length(out.f_H_W_N - early[static_cast<std::size_t>(i)]));
    }
  }
  EXPECT_GT(early_mm3, 1);
  EXPECT_GT(max_N, 0.1);
  verdict.AtMost("force difference from ten strokes earlier", drift_N, 0.002, "N");
  verdict.AtMost("volume still removed in ten strokes", late_mm3, 0.005 * early_mm3, "mm3");
}

TEST(HardCase37, SumsOfTimeAndDistanceStayExact) {
  Verdict verdict("holds");
  // The handle has made a very long rotation or motion: 1e7 ticks at 1 mm/s, and 10 km from its start.
  AdaptiveVelocity velocity(0.001);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const double v = velocity.Update(Vec3(1e7 + 0.001 * i, 0, 0), 0.001).x;
    if (i > 40) worst = std::max(worst, std::abs(v - 1));
  }
  verdict.AtMost("error of a velocity of 1 mm/s after 10 km", worst, 1e-4, "mm/s");
  // Over a month at 4 kHz, the deadlines are whole nanoseconds, and no deadline is lost.
  constexpr std::int64_t kPeriod = 250'000;
  constexpr std::int64_t kMonth = std::int64_t{30} * 86400 * 1'000'000'000;
  Deadlines deadlines(kPeriod);
  deadlines.Start(17);
  const Deadlines::Tick after = deadlines.Begin(17 + kMonth);
  EXPECT_EQ(after.skipped, kMonth / kPeriod - 1);
  deadlines.End(17 + kMonth + 100'000);
  verdict.Equal("deadline error after a month", static_cast<double>(deadlines.due_ns() - (17 + kMonth + kPeriod)), 0,
                "ns");
  // The motors exert a constant force.
  const DeviceProfile profile = FindDeviceProfile("omega_3");
  ForceMap map(profile);
  Vec3 half_way(0);
  Vec3 last(0);
  const int ticks = static_cast<int>(std::max(1e5, 1e6 * Effort()));
  for (int i = 0; i < ticks; ++i) {
    last = map.Calc({1, 2, 3}, Vec3(0), 0.001).f_H_W_N;
    if (i == ticks / 2) half_way = last;
  }
  EXPECT_GT(glm::length(last), 0.1);
  EXPECT_EQ(map.counts().ticks, static_cast<std::uint64_t>(ticks));
  verdict.AtMost("drift of a steady force", glm::length(last - half_way), 1e-9, "N");
}

}  // namespace
}  // namespace kerf
