// Deadlines are met, skipped and counted for any duration of ticks and any lateness of wake-ups.
#include "base/realtime/deadlines.h"

#include <gtest/gtest.h>

#include <random>

namespace kerf {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;

TEST(Deadlines, StayOnTheGridWithoutDelays) {
  Deadlines deadlines(kPeriod);
  deadlines.Start(17);
  for (int i = 1; i <= 100; ++i) {
    EXPECT_EQ(deadlines.due_ns(), 17 + i * kPeriod);
    const Deadlines::Tick tick = deadlines.Begin(deadlines.due_ns() + 1000 * (i % 7));
    EXPECT_EQ(tick.late_ns, 1000 * (i % 7));  // lateness does not accumulate
    EXPECT_EQ(tick.skipped, 0);
    deadlines.End(deadlines.due_ns() + 300'000);
  }
}

TEST(Deadlines, LongTickSkipsMissedDeadlines) {
  Deadlines deadlines(kPeriod);
  deadlines.Start(0);
  deadlines.Begin(kPeriod);
  deadlines.End(kPeriod + 3'400'000);  // tick 1, which misses deadlines 2, 3 and 4
  EXPECT_EQ(deadlines.due_ns(), 5 * kPeriod);
  const Deadlines::Tick tick = deadlines.Begin(5 * kPeriod + 10);
  EXPECT_EQ(tick.skipped, 3);
  EXPECT_EQ(tick.late_ns, 10);
}

TEST(Deadlines, LateWakeUpSkipsMissedDeadlines) {
  Deadlines deadlines(kPeriod);
  deadlines.Start(0);
  const Deadlines::Tick tick = deadlines.Begin(4 * kPeriod + 800'000);
  EXPECT_EQ(tick.due_ns, 4 * kPeriod);
  EXPECT_EQ(tick.skipped, 3);
  EXPECT_EQ(tick.late_ns, 3 * kPeriod + 800'000);  // counted from the first deadline, for which the loop waited
  deadlines.End(4 * kPeriod + 900'000);
  EXPECT_EQ(deadlines.due_ns(), 6 * kPeriod);  // deadline 5 would begin within a quarter of a period
}

TEST(Deadlines, NoBurstsAndEveryDeadlineIsRunOrCountedAsSkipped) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 50; ++run) {
    // The times range from far below to far above the period.
    std::lognormal_distribution<double> late(8 + 0.1 * run, 1.5);
    std::lognormal_distribution<double> work(10 + 0.1 * run, 1.5);
    Deadlines deadlines(kPeriod);
    const std::int64_t start = 123'456'789;
    deadlines.Start(start);
    std::int64_t began_before = start;
    std::int64_t ticks = 0;
    std::int64_t skipped = 0;
    std::int64_t last_due = start;
    for (int i = 0; i < 1000; ++i) {
      const std::int64_t waited_for = deadlines.due_ns();
      const std::int64_t now = waited_for + static_cast<std::int64_t>(late(random));
      const Deadlines::Tick tick = deadlines.Begin(now);
      ++ticks;
      skipped += tick.skipped;
      ASSERT_EQ((tick.due_ns - start) % kPeriod, 0);
      ASSERT_GT(tick.due_ns, last_due);
      ASSERT_LE(tick.due_ns, now);
      ASSERT_GT(tick.due_ns + kPeriod, now);
      ASSERT_EQ(waited_for + tick.late_ns, now);
      if (i > 0) {
        ASSERT_GE(now - began_before, kPeriod / 4);
      }
      began_before = now;
      last_due = tick.due_ns;
      const std::int64_t end = now + static_cast<std::int64_t>(work(random));
      deadlines.End(end);
      ASSERT_GT(deadlines.due_ns(), end);
    }
    EXPECT_EQ(ticks + skipped, (last_due - start) / kPeriod);
  }
}

}  // namespace
}  // namespace kerf
