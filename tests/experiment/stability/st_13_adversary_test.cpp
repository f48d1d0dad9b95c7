// ST13: an adversary searches for the worst hand and path.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "experiment/stability/adversary.h"
#include "experiment/stability/held_block.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

/// Returns the default coupling for the lightest named grip. The adversary's own hand may have half its damping.
StabilitySubject Subject(const std::string& profile) {
  StabilitySubject subject{test::BlockOfBone(), test::HeldBlock(profile, "H1"), test::OverBlock(), {0, 0, -1}, 7500};
  return subject;
}

void Report(const std::string& profile, const Worst& worst) {
  fmt::print(
      "{}: noise {:.4g} N of {:.3g} N, kept {:.4g}, lowest {:.4g} mJ of {:.4g} mJ exchanged, spindle {:.3g} mJ; found "
      "at try "
      "{}: {}\n",
      profile, worst.result.noise_N, worst.result.mean_N, worst.result.min_kept, worst.result.lowest_mJ,
      worst.result.exchanged_mJ, worst.result.spindle_mJ, worst.found.at_try, ToText(worst.attack));
}

AdversaryOptions Options(int tries, std::uint64_t seed = 1, bool random_only = false) {
  return {std::max(1, static_cast<int>(tries * test::Effort())), seed, random_only};
}

TEST(ClosedLoopST13, SearchFindsNoHandThatMakesTheShippedLoopTremble) {
  test::Verdict verdict("holds");
  for (const std::string profile : {"omega_6", "touch"}) {
    const Worst worst = FindWorst(Subject(profile), AttackGoal::kNoise, Options(60));
    Report(profile, worst);
    verdict.AtMost("worst noise relative to 20 mN or 1 %, " + profile, worst.result.NoiseFraction(), 1);
  }
}

// The energy is measured at the handle, including the device's own friction and damping, as the hand feels it. The
// possible error of the integration and of the energy balance is 0.1 %.
TEST(ClosedLoopST13, SearchFindsNoHandThatExtractsEnergyFromTheShippedLoop) {
  test::Verdict verdict("holds");
  for (const std::string profile : {"omega_6", "touch"}) {
    const Worst worst = FindWorst(Subject(profile), AttackGoal::kEnergy, Options(60));
    Report(profile, worst);
    verdict.AtLeast("minimum energy retained relative to that exchanged, " + profile, worst.result.min_kept, -1e-3);
  }
}

// Without damping, a held force returns energy because K T / 2 of damping are missing. The coupling's damper and the
// device's own losses are removed.
TEST(ClosedLoopST13, SearchFindsAPlantedEnergySourceAndExtractsMoreThanRandomTries) {
  test::Verdict verdict("holds");
  StabilitySubject subject = Subject("omega_6");
  subject.setup.coupled.coupling.damping_Ns_per_mm = 0;
  subject.setup.profile.friction_N = 0;
  subject.setup.profile.own_damping_Ns_per_mm = 0;
  subject.setup.loop_gain = 2;
  double by_search = 0, by_chance = 0;
  const int seeds = test::Effort() < 1 ? 1 : 3;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto s = static_cast<std::uint64_t>(seed);
    const Worst found = FindWorst(subject, AttackGoal::kEnergy, {40, s, false});
    const Worst chance = FindWorst(subject, AttackGoal::kEnergy, {40, s, true});
    Report("planted source, search", found);
    Report("planted source, chance", chance);
    by_search += found.result.min_kept / seeds;
    by_chance += chance.result.min_kept / seeds;
    EXPECT_LT(found.result.min_kept, -0.01);
  }
  verdict.Note("energy retained, by search", by_search);
  verdict.Note("energy retained, by the same number of random tries", by_chance);
  EXPECT_LT(by_search, by_chance);
}

TEST(ClosedLoopST13, TheSearchFindsAPlantedInstability) {
  test::Verdict verdict("holds");
  StabilitySubject subject = Subject("omega_6");
  subject.setup.coupled.coupling.damping_Ns_per_mm = 0;
  subject.setup.profile.friction_N = 0;
  subject.setup.profile.own_damping_Ns_per_mm = 0;
  subject.setup.loop_gain = 8;
  double smallest = 1e9;
  for (int seed = 1; seed <= (test::Effort() < 1 ? 1 : 3); ++seed) {
    const Worst found = FindWorst(subject, AttackGoal::kNoise, {40, static_cast<std::uint64_t>(seed), false});
    Report("planted instability", found);
    smallest = std::min(smallest, found.result.NoiseFraction());
  }
  verdict.AtLeast("noise found relative to the bound", smallest, 1);
}

}  // namespace
}  // namespace kerf
