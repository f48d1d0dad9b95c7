// Tests of the governor: it steps down after long overruns and up after a calm time, and does not alternate.
#include "loop/haptics/governor.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace kerf {
namespace {

GovernorParams Degrading() {
  GovernorParams params;
  params.degrade = true;
  return params;
}

/// Observes ticks at 1 kHz from `from_s` to `to_s`, each with the duration us(time, fidelity).
void Feed(Governor& governor, double from_s, double to_s, const std::function<double(double, Fidelity)>& us) {
  for (double t = from_s; t < to_s; t += 0.001) governor.Observe(t, us(t, governor.fidelity()));
}

TEST(Governor, DoesNothingUnlessEnabled) {
  Governor governor(GovernorParams{});
  Feed(governor, 0, 10, [](double, Fidelity) { return 5000; });
  EXPECT_EQ(governor.fidelity(), Fidelity::kFull);
  EXPECT_EQ(governor.step_count(), 0);
}

TEST(Governor, StepsDownOneByOneAndNoFurtherThanSlab) {
  Governor governor(Degrading());
  Feed(governor, 0, 10, [](double, Fidelity) { return 900; });  // budget: 800
  EXPECT_EQ(governor.fidelity(), Fidelity::kSlab);
  ASSERT_EQ(governor.steps().size(), 2U);
  EXPECT_EQ(governor.steps()[0].from, Fidelity::kFull);
  EXPECT_EQ(governor.steps()[0].to, Fidelity::kCoarse);
  EXPECT_EQ(governor.steps()[0].reason, FidelityReason::kOverrun);
  EXPECT_NEAR(governor.steps()[0].time_s, 0.1, 0.002);  // after one window
  EXPECT_EQ(governor.steps()[0].fraction_over, 1);
  EXPECT_EQ(governor.steps()[0].longest_us, 900);
  EXPECT_EQ(governor.steps()[1].from, Fidelity::kCoarse);
  EXPECT_EQ(governor.steps()[1].to, Fidelity::kSlab);
}

TEST(Governor, ForgivesALongTickNowAndThen) {
  Governor governor(Degrading());
  // 5 % of the ticks are over budget, and a few last 30 times the period; this is not a persistent overrun.
  int n = 0;
  Feed(governor, 0, 60, [&n](double, Fidelity) { return ++n % 5000 == 0 ? 30'000.0 : n % 20 == 0 ? 900.0 : 100.0; });
  EXPECT_EQ(governor.step_count(), 0);
}

TEST(Governor, StepsUpAfterACalmPeriod) {
  Governor governor(Degrading());
  Feed(governor, 0, 1, [](double, Fidelity) { return 900; });
  ASSERT_EQ(governor.fidelity(), Fidelity::kSlab);
  Feed(governor, 1, 2.5, [](double, Fidelity) { return 100; });
  EXPECT_EQ(governor.fidelity(), Fidelity::kSlab);  // the calm time has not passed yet
  Feed(governor, 2.5, 6, [](double, Fidelity) { return 100; });
  EXPECT_EQ(governor.fidelity(), Fidelity::kFull);
  ASSERT_EQ(governor.steps().size(), 4U);
  EXPECT_EQ(governor.steps()[2].reason, FidelityReason::kCalm);
  EXPECT_GE(governor.steps()[2].time_s - governor.steps()[1].time_s, 2);
  EXPECT_GE(governor.steps()[3].time_s - governor.steps()[2].time_s, 2);
}

TEST(Governor, KeepsTheFidelityBetweenOverrunAndCalm) {
  Governor governor(Degrading());
  Feed(governor, 0, 0.1005, [](double, Fidelity) { return 900; });
  ASSERT_EQ(governor.fidelity(), Fidelity::kCoarse);
  Feed(governor, 0.1005, 60, [](double, Fidelity) { return 600; });  // between half the budget and the budget
  EXPECT_EQ(governor.fidelity(), Fidelity::kCoarse);
  EXPECT_EQ(governor.step_count(), 1);
}

TEST(Governor, WaitsLongerAfterEachRevertedRaise) {
  // Full fidelity always takes too long, coarse never does. If the waits did not increase, the governor would alternate
  // every two seconds.
  Governor governor(Degrading());
  Feed(governor, 0, 300, [](double, Fidelity f) { return f == Fidelity::kFull ? 1500 : 200; });
  std::vector<double> ups;
  for (const FidelityStep& step : governor.steps()) {
    if (step.reason == FidelityReason::kCalm) ups.push_back(step.time_s);
  }
  ASSERT_GE(ups.size(), 6U);
  // The waits are 2, 4, 8, 16, 32, 32, ... seconds.
  EXPECT_NEAR(ups[2] - ups[1], 2 * (ups[1] - ups[0]), 0.5);
  EXPECT_NEAR(ups[4] - ups[3], 32, 1);
  EXPECT_NEAR(ups[5] - ups[4], 32, 1);
  EXPECT_LE(governor.step_count(), 2 * 15);
}

TEST(Governor, KeepsABoundedListAndCountsTheRest) {
  GovernorParams params = Degrading();
  params.calm_s = params.longest_calm_s = 0.1;
  Governor governor(params);
  Feed(governor, 0, 60, [](double, Fidelity f) { return f == Fidelity::kFull ? 1500 : 200; });
  EXPECT_GT(governor.step_count(), Governor::kKeptSteps);
  EXPECT_EQ(governor.steps().size(), static_cast<std::size_t>(Governor::kKeptSteps));
}

TEST(Governor, StepsDownInTimeWhenTicksAreFarTooLong) {
  // Ticks last 50 ms; a window of 100 of them would take 5 s.
  Governor governor(Degrading());
  for (int i = 1; i <= 8; ++i) governor.Observe(0.05 * i, 50'000);
  EXPECT_EQ(governor.fidelity(), Fidelity::kSlab);
}

}  // namespace
}  // namespace kerf
