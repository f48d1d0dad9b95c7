// Tests of extreme parameters, of changing hands, and of a long session.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "experiment/stability/held_block.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched_loop.h"

namespace kerf {
namespace {

using test::Effort;
using test::HeldBlock;
using test::Uniform;
using test::Upright;
using test::Verdict;
using test::WatchedLoop;

// The requested coupling is from a tenth to a hundred times the usual one, the bone ranges from foam of 1 kPa to 1000
// GPa, and friction from 0 to 2. The tool is pressed on with 5 N and rubbed along, with the spindle stopped and
// turning.
TEST(ClosedLoopST10, CornersOfTheParameterRangesHaveNoNoise) {
  Verdict verdict("holds");
  double noise = 0;
  double noise_soft = 0;
  int cycles = 0;
  int runs = 0;
  std::string table;
  for (const double K : {0.1, 1.0, 10.0, 100.0}) {
    for (const double E_MPa : {1e-3, 1e3, 1e6}) {
      for (const double mu : {0.0, 2.0}) {
        for (const double rpm : {0.0, 7500.0}) {
          CouplingParams asked;
          asked.stiffness_N_per_mm = K;
          ClosedLoopSetup setup = HeldBlock("omega_6", "H3", asked);
          setup.profile.friction_N = 0;
          SetEffect(setup.coupled.effects, "kerf_friction", "coefficient", mu);
          const Pose start = test::OverBlock();
          WatchedLoop saw(MakeBlock({.size_mm = Vec3(26, 6, 26), .X_WB = {}, .layers = {}, .voxel_mm = 0.4},
                                    test::OneRegionTable(24, E_MPa)),
                          setup, start);
          const double scale = ForceMap(setup.profile, setup.force_map).force_scale();
          Intention push;
          push.X_WH = start;
          push.yield_s = 0.5;
          push.v_W_mm_per_s = Vec3(1, 0.3, 0);  // it rubs along, and against the wall of its kerf
          std::vector<Vec3> f;
          std::vector<double> f_z;
          for (int i = 0; i < 2200; ++i) {
            push.push_W_N = Vec3(0, 0, -5 * scale * std::min(1.0, 1e-3 * i / 0.3));
            push.X_WH.p_AB = start.p_AB + 1e-3 * i * push.v_W_mm_per_s;
            saw.loop.device().SetIntention(push);
            const ClosedLoopTick tick = saw.Step(rpm);
            ASSERT_EQ(tick.out.faults, kHapticOk);
            if (i < 1200) continue;
            f.push_back(tick.out.force.f_H_W_N / scale);
            f_z.push_back(f.back().z);
          }
          const double noise_mN = 1000 * CalcNoise(f, 0.001);
          // The second term of the bound is an encoder step of 10 um times K, whatever the bone.
          const double step_mN = 1000 * setup.coupled.coupling.stiffness_N_per_mm * setup.profile.resolution_mm;
          double& worst = K <= 1 ? noise_soft : noise;
          worst = std::max(worst, noise_mN / (K <= 1 ? 50 : 50 + step_mN));
          cycles += FindOscillation(f_z, 0.001, 0.02 + 2e-3 * step_mN).is_limit_cycle ? 1 : 0;
          ++runs;
          table +=
              fmt::format("K {:.3g} E {:.0e} mu {} rpm {}: noise {:.2f} mN, a step {:.1f} mN, f {:.2f} N\n",
                          setup.coupled.coupling.stiffness_N_per_mm, E_MPa, mu, rpm, noise_mN, step_mN, f_z.back());
        }
      }
    }
  }
  std::puts(table.c_str());
  verdict.Note("corners", runs);
  verdict.AtMost("noise relative to 50 mN (1 % of 5 N), usual couplings, worst", noise_soft, 1);
  verdict.AtMost("noise relative to 50 mN plus an encoder step, stiffest couplings, worst", noise, 1);
  verdict.Equal("limit cycles", cycles, 0);
}

// The grip changes in the middle of a push, between all hands; in the end the device is released. The coupling is
// fitted for the firmest hand, so that the released device has the stiffest coupling possible.
TEST(ClosedLoopST11, RegrippedAndReleasedHandleLeavesTheBoneWithoutAKick) {
  Verdict verdict("holds");
  double kick = 0;
  double largest_step_N = 0;
  double handle_mJ = 0;
  double overdrawn = 0;
  double speed = 0;
  for (const char* profile : {"omega_6", "omni", "premium_1_5_hf", "virtuose_6d", "maglev_200"}) {
    for (const double ask : {1.0, 1000.0}) {
      for (const auto& [rpm, hertz] : {std::pair(0.0, false), std::pair(7500.0, false), std::pair(7500.0, true)}) {
        CouplingParams asked;
        asked.stiffness_N_per_mm = ask;
        ClosedLoopSetup setup = HeldBlock(profile, "H4", asked);
        if (hertz) setup.coupled.law = ForceLaw("hertz_chip");
        const Pose start = test::OverBlock();
        WatchedLoop saw(test::BlockOfBone(0.4), setup, start);
        const double push_N = 0.3 * setup.profile.peak_force_N;
        Intention push;
        push.X_WH = start;
        push.yield_s = 0.3;
        for (int i = 0; i < 600; ++i) saw.Step(rpm);
        test::YieldingHand yielding(setup, push.yield_s, start);
        int pushed = 0;
        double taken_N = 0;  // of the push, by the hand itself
        for (const char* hand : {"H4", "H3", "H1", "H2", "H3", "H4"}) {
          HandModel model = FindHandModel(hand);
          saw.loop.device().SetHand(model);
          for (int i = 0; i < 400; ++i) {
            push.push_W_N = Vec3(0, 0, -push_N * std::min(1.0, ++pushed / 300.0));
            saw.loop.device().SetIntention(push);
            taken_N = yielding.Add(saw.Step(rpm), model);
          }
        }
        const double hold_N = glm::length(saw.loop.device().force_N());
        EXPECT_NEAR(hold_N + taken_N, push_N, setup.profile.friction_N + 0.02 * push_N) << profile;
        // The handle is released: there is no hand and no push. The device's energy is then that of the spring.
        const double K = setup.coupled.coupling.stiffness_N_per_mm * ForceMap(setup.profile, {}).force_scale();
        const double spring_mm_per_s = hold_N / std::sqrt(K * 1e-3 * setup.profile.mass_kg);
        saw.loop.device().SetHand(FindHandModel("H0"));
        saw.loop.device().SetIntention({.X_WH = start});
        saw.largest_N = 0;
        double max_mm_per_s = 0;
        ClosedLoopTick tick;
        for (int i = 0; i < 1200; ++i) {
          tick = saw.Step(rpm);
          max_mm_per_s = std::max(max_mm_per_s, glm::length(tick.v_WC_mm_per_s));
        }
        // It is out of contact with the bone. The kerf of the default law is so deep that friction may hold the handle.
        const double held_N = hertz || rpm == 0 ? 0 : setup.profile.friction_N;
        EXPECT_LT(glm::length(saw.loop.device().force_N()), held_N + 1e-9) << profile << " " << hertz;
        kick = std::max(kick, saw.largest_N / hold_N);
        speed = std::max(speed, max_mm_per_s / spring_mm_per_s);
        largest_step_N = std::max(largest_step_N, saw.largest_rise_N / setup.profile.peak_force_N);
        handle_mJ = std::min(handle_mJ, tick.energy.lowest_handle_mJ);
        overdrawn = std::max(overdrawn, saw.overdrawn);
      }
    }
  }
  verdict.AtMost("largest force after release relative to the holding force", kick, 1.02);
  verdict.AtMost("speed after release relative to that of a released spring", speed, 1.02);
  verdict.AtMost("maximum energy returned at the motors, regrips and release", overdrawn, 1, "times the tolerance");
  verdict.AtLeast("minimum energy at the handle", 1000 * handle_mJ, -1e-3, "uJ");
}

// The saw makes strokes in different places, some of them into old kerfs, with pauses in free air in between, in which
// there is no force.
TEST(ClosedLoopST12, ALongSurgeryHasNoDrift) {
  Verdict verdict(Effort() >= 10 ? "holds"
                                 : "holds; takes ten minutes with KERF_STABILITY_EFFORT=10, a tenth of that here");
  CouplingParams asked;
  ClosedLoopSetup setup = HeldBlock("omega_6", "H3", asked);
  setup.coupled.spare_leaves = 40000;
  const Pose rest = test::OverBlock(6);
  WatchedLoop saw(test::BlockOfBone(0.4, Vec3(40, 24, 26)), setup, rest, true);
  std::mt19937_64 random(12);
  const int strokes = static_cast<int>(std::ceil(12 * Effort()));
  double idle_N = 0;
  double largest_rise_N = 0;
  int not_finite = 0;
  int ticks = 0;
  std::uint32_t faults = 0;
  Vec3 at(0, 0, 17);
  for (int k = 0; k < strokes; ++k) {
    const bool old_place = k % 3 == 2;
    if (!old_place) at = Vec3(Uniform(random, -12, 12), Uniform(random, -9, 9), 17);
    const double depth = Uniform(random, 1, 6);
    const double rpm = k % 5 == 4 ? 0 : 7500;
    const std::vector<IntentionStep> steps = {
        {.seconds = 0.8, .X_WH = Upright(at)},
        {.seconds = 2, .X_WH = Upright(Vec3(at.x, at.y, 11 - depth)), .saw_W_mm = Vec3(2, 0, 0), .saw_Hz = 2},
        {.seconds = 0.8, .X_WH = Upright(Vec3(at.x + 1, at.y + 0.4, 11 - depth))},
        {.seconds = 1, .X_WH = Upright(at)},
        {.seconds = 0.5, .X_WH = Upright(at)}};
    saw.loop.device().SetScript(IntentionScript({Quat(rest.R_AB), saw.loop.device().p_WC_mm()}, steps));
    for (int i = 0; i < 5100; ++i) {
      const ClosedLoopTick tick = saw.Step(rpm);
      ++ticks;
      faults |= tick.out.faults;
      const Vec3 f = saw.loop.device().force_N();
      if (!(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.z))) ++not_finite;
      if (i > 4800) idle_N = std::max(idle_N, glm::length(f));
    }
    largest_rise_N = std::max(largest_rise_N, saw.largest_rise_N);
    saw.loop.simulation().Refill();
  }
  saw.invariants.CheckBone();
  EXPECT_EQ(faults, kHapticOk);
  EXPECT_GT(saw.largest_N, 0.3);
  verdict.Note("ticks", ticks);
  verdict.Equal("ticks with a force that is not finite", not_finite, 0);
  verdict.Equal("force at rest in the air", idle_N, 0, "N");
  verdict.AtMost("largest rise of the force in a tick", largest_rise_N, 2.4, "N");
  verdict.AtLeast("bone removed", saw.invariants.removed_mm3(), 10 * std::min(1.0, strokes / 12.0), "mm3");
}

}  // namespace
}  // namespace kerf
