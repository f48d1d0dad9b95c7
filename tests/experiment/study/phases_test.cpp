// Tests of phases on made-up engagements with known ends.
#include "experiment/study/phases.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

constexpr double kTick_s = 0.001;

/// Returns engaged teeth by tick: increasing from 0.1 to 0.4 s, full until 1 s, decreasing to a twentieth until 1.2 s,
/// and constant until 1.5 s; zero before and after.
std::vector<ReferenceTick> MakeCut(double until_s) {
  std::vector<ReferenceTick> ticks;
  for (int i = 1; kTick_s * i <= until_s + 1e-9; ++i) {
    const double t_s = kTick_s * i;
    double fraction = 0;
    if (t_s > 0.1 && t_s <= 0.4) fraction = (t_s - 0.1) / 0.3;
    if (t_s > 0.4 && t_s <= 1) fraction = 1;
    if (t_s > 1 && t_s <= 1.2) fraction = 1 - 0.95 * (t_s - 1) / 0.2;
    if (t_s > 1.2 && t_s <= 1.5) fraction = 0.05;
    ticks.emplace_back().engaged_teeth = 6 * fraction;
  }
  return ticks;
}

TEST(CutPhases, AreWhereTheEngagementRisesAndFalls) {
  const std::vector<CutPhase> phases = FindCutPhases(MakeCut(2), kTick_s);
  ASSERT_EQ(phases.size(), 4u);
  const char* names[] = {"entry", "cut", "breakthrough", "exit"};
  // The engagement reaches 0.9 of its maximum on the way up at 0.37 s and on the way down at 1 + 0.1 * 0.2 / 0.95 s,
  // and 0.1 of it at 1 + 0.9 * 0.2 / 0.95 s.
  const double ends_s[] = {0.1, 0.37, 1.021, 1.189, 1.5};
  for (std::size_t i = 0; i < phases.size(); ++i) {
    EXPECT_EQ(phases[i].name, names[i]);
    EXPECT_NEAR(phases[i].from_s, ends_s[i], 1.5 * kTick_s) << names[i];
    EXPECT_NEAR(phases[i].to_s, ends_s[i + 1], 1.5 * kTick_s) << names[i];
    if (i > 0) {
      EXPECT_EQ(phases[i].from_s, phases[i - 1].to_s);
    }
  }
}

TEST(CutPhases, APathThatEndsInTheBoneHasNoBreakthrough) {
  const std::vector<CutPhase> phases = FindCutPhases(MakeCut(0.8), kTick_s);
  ASSERT_EQ(phases.size(), 2u);
  EXPECT_EQ(phases[1].name, "cut");
  EXPECT_NEAR(phases[1].to_s, 0.8, 1e-12);
  EXPECT_TRUE(FindCutPhases(MakeCut(0.09), kTick_s).empty());
  EXPECT_TRUE(FindCutPhases({}, kTick_s).empty());
}

}  // namespace
}  // namespace kerf
