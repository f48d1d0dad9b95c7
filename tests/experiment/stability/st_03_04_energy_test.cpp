// Tests of the energy that the hand supplies to the motors and of the energy that is returned.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "experiment/stability/held_block.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched_loop.h"

namespace kerf {
namespace {

using test::DrawOrbit;
using test::Effort;
using test::HandOrbit;
using test::HeldBlock;
using test::Verdict;
using test::WatchedLoop;

constexpr const char* kProfiles[] = {"omega_6", "omni", "falcon", "premium_1_5_hf", "virtuose_6d", "maglev_200"};
constexpr const char* kHands[] = {"H1", "H2", "H3", "H4"};

/// Returns device, hand and coupling of round i. The coupling is the default, or the stiffest that the device accepts.
ClosedLoopSetup MakeRound(int i, bool stiff) {
  CouplingParams asked;
  if (stiff) asked.stiffness_N_per_mm = 1000;
  return HeldBlock(kProfiles[i % std::size(kProfiles)], kHands[(i / std::size(kProfiles)) % std::size(kHands)], asked);
}

struct Rounds {
  int rounds = 0;
  int overdrawn_rounds = 0;     // rounds that returned more than the tolerance
  double overdrawn = 0;         // worst of WatchedLoop::overdrawn
  double lowest_mJ = 0;         // of motors and spindle
  double lowest_handle_mJ = 0;  // of the handle and spindle
  double exchanged_mJ = 0;
  double spindle_mJ = 0;
  double cut_mJ = 0;
  double removed_mm3 = 0;
  double max_N = 0;
};

Rounds RunRounds(int rounds, double rpm, bool stiff, double damping_fraction, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Rounds all;
  for (int i = 0; i < rounds; ++i) {
    ClosedLoopSetup setup = MakeRound(i, stiff);
    setup.coupled.coupling.damping_Ns_per_mm *= damping_fraction;
    const HandOrbit orbit = DrawOrbit(random, 4, 10, rpm != 0);
    WatchedLoop saw(test::BlockOfBone(rpm == 0 ? 0.4 : 0.2, Vec3(26, 6, 12)), setup, test::AboveOrbit(orbit));
    PortEnergy energy;
    test::FollowOrbit(saw, orbit, rpm, [&](const ClosedLoopTick& tick) {
      energy = tick.energy;
      const CoupledOutput& out = tick.out.coupled;
      all.cut_mJ += out.cut_mJ;
      all.removed_mm3 += out.removed_mm3;
    });
    ++all.rounds;
    all.overdrawn_rounds += saw.overdrawn > 1 ? 1 : 0;
    all.overdrawn = std::max(all.overdrawn, saw.overdrawn);
    all.lowest_mJ = std::min(all.lowest_mJ, energy.lowest_mJ);
    all.lowest_handle_mJ = std::min(all.lowest_handle_mJ, energy.lowest_handle_mJ);
    all.exchanged_mJ += energy.exchanged_mJ;
    all.spindle_mJ += energy.spindle_mJ;
    all.max_N = std::max(all.max_N, saw.largest_N);
  }
  return all;
}

// A hand moves along a hundred closed orbits, in and out of the bone and along it, with frequencies up to 10 Hz. There
// are six devices with four hands, including encoder steps. At no tick have the motors returned more energy than they
// received, within 1e-6 J or a thousandth of the exchanged energy: what is left of the half tick of a force held over a
// tick, after the damper. At the handle, behind the device's own friction and damping, no energy is returned at all.
TEST(ClosedLoopST3, StoppedSawReturnsNoEnergyAtAnyTick) {
  Verdict verdict(
      "holds after the half second in which the force ramps in: during the ramp more energy returns than was put in "
      "(ST9 bounds it)");
  const int rounds =
      static_cast<int>(std::ceil(std::max(20.0, 50 * Effort())));  // with fewer, too little energy is exchanged
  for (const bool stiff : {false, true}) {
    const Rounds all = RunRounds(rounds, 0.0, stiff, 1.0, stiff ? 2 : 1);
    const std::string which = stiff ? ", stiffest coupling allowed" : ", 1 N/mm requested";
    EXPECT_GT(all.exchanged_mJ, 10);
    EXPECT_GT(all.max_N, 1);
    EXPECT_EQ(all.removed_mm3, 0);
    verdict.AtMost("maximum energy returned" + which, all.overdrawn, 1, "times the tolerance");
    verdict.AtLeast("minimum energy at the handle" + which, 1e3 * all.lowest_handle_mJ, -1e-3, "uJ");
  }
}

// Shows that the test above can detect a fault: the orbits are the same, without the damper that the coupling now has.
TEST(ClosedLoopST3, HeldForceReturnsEnergyWithoutItsDamper) {
  Verdict verdict("without the damper the test fails, as it should");
  const Rounds all = RunRounds(24, 0.0, true, 0.0, 2);
  verdict.AtLeast("orbits, out of 24, that return more than the tolerance", all.overdrawn_rounds, 3);
  verdict.AtMost("minimum energy at the motors", all.lowest_mJ, -0.02, "mJ");
}

// With a running saw, the returned energy is at most the spindle's. Hertz's law has no minimum work for a volume of
// bone (the force is proportional to the bite to the power of 1.5, so the work goes to zero with the bite), but bone
// must not be removed without work. The invariants check the energy balance of each tick.
TEST(ClosedLoopST4, RunningSawReturnsNoMoreThanItsSpindlePutInAtAnyTick) {
  Verdict verdict(
      "holds; this cutting law has no minimum work per volume of bone (it falls with the bite), so the actual work "
      "is reported");
  double removed_mm3 = 0;
  double cut_mJ = 0;
  const int rounds =
      static_cast<int>(std::ceil(std::max(20.0, 50 * Effort())));  // with fewer, too little energy is exchanged
  for (const bool stiff : {false, true}) {
    const Rounds all = RunRounds(rounds, 7500.0, stiff, 1.0, stiff ? 4 : 3);
    const std::string which = stiff ? ", stiffest coupling allowed" : ", 1 N/mm requested";
    EXPECT_GT(all.exchanged_mJ, 10);
    EXPECT_GT(all.spindle_mJ, 0.001);
    verdict.AtMost("maximum energy returned" + which, all.overdrawn, 1, "times the tolerance");
    EXPECT_GE(all.lowest_handle_mJ, -1e-6);
    removed_mm3 += all.removed_mm3;
    cut_mJ += all.cut_mJ;
  }
  verdict.AtLeast("bone removed", removed_mm3, 10, "mm3");
  verdict.AtLeast("work of the feed per volume", cut_mJ / removed_mm3, 0.01, "mJ/mm3");
}

}  // namespace
}  // namespace kerf
