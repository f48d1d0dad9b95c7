// Tests of the loop with a fake body, with a simulated clock and in real time. None of them depends on the speed of
// the machine.
#include "loop/haptics/haptic_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <map>
#include <stdexcept>

#include "base/core/heap_guard.h"
#include "kerf/error.h"
#include "made_up.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::FakeBody;
using test::RecordingDevice;

constexpr std::int64_t kMs = 1'000'000;

struct Stage {
  RecordingDevice inner;
  GuardedDevice device{inner};
  VirtualClock clock;
  FakeBody body{device};
  LoopParams params;
};

TEST(HapticLoop, TicksOnceAPeriodOnAClockThatKeepsUp) {
  Stage s;
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(1000);
  EXPECT_EQ(loop.counts().ticks, 1000U);
  EXPECT_EQ(loop.counts().missed, 0U);
  EXPECT_EQ(loop.end(), LoopEnd::kRequested);
  EXPECT_EQ(s.clock.Now(), 1000 * kMs);
  for (std::size_t i = 0; i < s.body.dt.count; ++i) EXPECT_EQ(s.body.dt.values[i], 0.001);
  EXPECT_EQ(loop.tick_times().total(), 1000U);
  EXPECT_EQ(loop.lateness().CalcPercentile_us(1), 0);
  EXPECT_EQ(s.inner.force_x_N, 0);  // after the end
  EXPECT_EQ(s.device.counts().largest_N, 5);
}

TEST(HapticLoop, SkipsAndCountsMissedDeadlines) {
  Stage s;
  s.params.watchdog_ms = 1000;
  int n = 0;
  s.body.during = [&] {
    if (++n % 10 == 0) s.clock.Burn(3 * kMs + kMs / 2);  // ends 3.5 periods after its deadline
    if (n == 25) s.clock.Burn(40 * kMs);
  };
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(30);
  EXPECT_EQ(loop.counts().ticks, 30U);
  EXPECT_EQ(loop.counts().longest_gap, 40U);
  EXPECT_EQ(loop.counts().missed, 3U + 3U + 40U);  // the last long tick misses none, because no tick follows it
  // A tick's dt is the elapsed time, but at most 10 ms.
  EXPECT_DOUBLE_EQ(s.body.dt.values[10], 0.004);
  EXPECT_DOUBLE_EQ(s.body.dt.values[25], 0.010);
  EXPECT_DOUBLE_EQ(s.body.dt.values[26], 0.001);
}

TEST(HapticLoop, RampsTheForceInAfterAStall) {
  Stage s;
  int n = 0;
  s.body.during = [&] {
    if (++n == 100) s.clock.Burn(60 * kMs);  // the watchdog's limit is 50
  };
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  std::vector<double> forces;
  loop.RunHere(110, [&] {
    forces.push_back(s.inner.force_x_N);
    return true;
  });
  EXPECT_EQ(s.body.ramps, 1);
  EXPECT_EQ(loop.counts().ramps, 1U);
  EXPECT_EQ(forces[99], 5);
  EXPECT_NEAR(forces[100], 0.1, 1e-12);
  EXPECT_NEAR(s.device.counts().largest_step_N, 0.1, 1e-12);
}

TEST(HapticLoop, EndsWithZeroForceWhenTheDeviceFails) {
  Stage s;
  int n = 0;
  s.body.during = [&] { s.inner.fails = ++n == 50; };
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(1000);
  EXPECT_EQ(loop.end(), LoopEnd::kDeviceFailed);
  EXPECT_EQ(n, 50);
  EXPECT_EQ(s.inner.force_x_N, 0);
  EXPECT_THAT(loop.failure(), testing::HasSubstr("the device failed"));
}

TEST(HapticLoop, EndsWithZeroForceOnAnException) {
  const HeapUseCounter an_exception_needs_the_heap;
  Stage s;
  int n = 0;
  s.body.during = [&] {
    if (++n == 50) throw std::runtime_error("something broke");
  };
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(1000);
  EXPECT_EQ(loop.end(), LoopEnd::kFailed);
  EXPECT_EQ(loop.failure(), "something broke");
  EXPECT_EQ(s.inner.force_x_N, 0);
}

TEST(HapticLoop, FailsOnHeapUseInATick) {
  if (!HeapGuardIsInstalled()) GTEST_SKIP() << "the sanitizers have an allocator of their own";
  const HeapUseCounter counter;
  Stage s;
  s.body.MakeLeaves(100);
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(200);
  EXPECT_EQ(counter.count(), 0);  // the loop itself does not allocate
  Stage t;
  t.body.during = [] {
    void* memory = std::malloc(10);
    asm volatile("" : : "g"(memory) : "memory");  // prevents the compiler from removing both
    std::free(memory);
  };
  HapticLoop other(t.body, t.device, t.clock, t.params);
  other.RunHere(5);
  EXPECT_EQ(counter.count(), 10);
}

TEST(HapticLoop, StepsDownWhileTimeIsBurntAndUpAfterwards) {
  Stage s;
  s.params.governor.degrade = true;
  s.params.load = {3000, 2, 6};
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(15'000);
  std::vector<std::pair<Fidelity, Fidelity>> steps;
  for (const FidelityStep& step : loop.governor().steps()) steps.emplace_back(step.from, step.to);
  EXPECT_THAT(
      steps, testing::ElementsAre(
                 testing::Pair(Fidelity::kFull, Fidelity::kCoarse), testing::Pair(Fidelity::kCoarse, Fidelity::kSlab),
                 testing::Pair(Fidelity::kSlab, Fidelity::kCoarse), testing::Pair(Fidelity::kCoarse, Fidelity::kSlab),
                 testing::Pair(Fidelity::kSlab, Fidelity::kCoarse), testing::Pair(Fidelity::kCoarse, Fidelity::kFull)));
  EXPECT_EQ(s.body.fidelity, Fidelity::kFull);
  EXPECT_GT(loop.counts().missed, 0U);
}

TEST(HapticLoop, SendsEveryChangedLeafDespiteShortQueueAndRing) {
  Stage s;
  s.body.MakeLeaves(150);
  s.body.changes_per_tick = 30;  // far more than can be sent
  s.params.max_leaves_waiting = 20;
  s.params.leaf_ring = 8;
  s.params.leaves_per_tick = 4;
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  std::map<std::array<int, 3>, std::array<float, 512>> mirror;
  int n = 0;
  loop.RunHere(3000, [&] {
    if (++n == 2500) s.body.changes_per_tick = 0;  // from here on the tool is at rest
    while (const LeafMessage* message = loop.leaves().Peek()) {
      mirror[message->index] = message->values;
      loop.leaves().Pop();
    }
    return true;
  });
  ASSERT_EQ(mirror.size(), 150U);
  for (int leaf = 0; leaf < 150; ++leaf) {
    EXPECT_EQ(mirror.at(FakeBody::IndexOf(leaf)), s.body.leaves[static_cast<std::size_t>(leaf)]) << leaf;
  }
}

TEST(HapticLoop, SendsTheRestOfMoreChangedLeavesThanWaitInTheQueue) {
  Stage s;
  s.body.MakeLeaves(150);
  s.body.changes_per_tick = 150;
  s.params.max_leaves_waiting = 20;
  s.params.leaf_ring = 8;
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(20);
  std::map<std::array<int, 3>, std::array<float, 512>> mirror;
  const auto read = [&] {
    while (const LeafMessage* message = loop.leaves().Peek()) {
      mirror[message->index] = message->values;
      loop.leaves().Pop();
    }
  };
  for (int calls = 0; loop.SendRemaining(); ++calls) {
    ASSERT_LT(calls, 150);  // each sends a leaf at least
    read();
  }
  read();
  EXPECT_EQ(s.body.changed_count(), 0);
  ASSERT_EQ(mirror.size(), 150U);
  for (int leaf = 0; leaf < 150; ++leaf) {
    EXPECT_EQ(mirror.at(FakeBody::IndexOf(leaf)), s.body.leaves[static_cast<std::size_t>(leaf)]) << leaf;
  }
}

TEST(HapticLoop, LogsEveryTickAndCountsLostSamples) {
  Stage s;
  s.params.sample_ring = 64;
  HapticLoop loop(s.body, s.device, s.clock, s.params);
  loop.RunHere(100);
  EXPECT_EQ(loop.counts().samples_lost, 36U);
  int read = 0;
  while (const LoopTick* sample = loop.samples().Peek()) {
    EXPECT_NEAR(sample->time_s, 0.001 * ++read, 1e-12);
    loop.samples().Pop();
  }
  EXPECT_EQ(read, 64);
  ASSERT_TRUE(loop.state().Update());
  EXPECT_EQ(loop.state().front().last.number, 100U);
}

TEST(HapticLoop, RefusesParametersOutOfRange) {
  Stage s;
  s.params.rate_hz = 5000;
  EXPECT_EQ(test::MessageOf([&] { HapticLoop loop(s.body, s.device, s.clock, s.params); }),
            "loop: rate_hz = 5000 is above 4000; valid range 250 to 4000 Hz");
}

// ---- live

template <typename Condition>
void WaitFor(Condition condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::microseconds(200));
}

TEST(LiveLoop, WatchdogSetsZeroForceWhenATickHangs) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  MonotonicClock clock;
  FakeBody body(device);
  std::atomic<bool> hang{false};
  std::atomic<bool> hanging{false};
  body.during = [&] {
    while (hang) {
      hanging = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  LoopParams params;
  HapticLoop loop(body, device, clock, params);
  loop.Start();
  WaitFor([&] { return inner.force_x_N > 1; });
  const long ramps_before = body.ramps;
  hang = true;
  WaitFor([&] { return hanging.load(); });
  WaitFor([&] { return inner.force_x_N == 0; });  // the loop still hangs, so this was the watchdog
  EXPECT_TRUE(hang);
  WaitFor([&] { return loop.watchdog_trips() >= 1; });  // the trip is counted after that
  hang = false;
  WaitFor([&] { return inner.force_x_N > 1; });  // the force returns, from zero
  EXPECT_GT(body.ramps, ramps_before);
  loop.Stop();
  EXPECT_EQ(loop.end(), LoopEnd::kRequested);
  EXPECT_EQ(inner.force_x_N, 0);
  EXPECT_NEAR(device.counts().largest_step_N, 0.1, 1e-9);
  EXPECT_EQ(inner.two_at_once, 0);
  EXPECT_EQ(loop.counts().ticks, loop.tick_times().total());
}

TEST(LiveLoop, ReportsWhatTheSystemGrants) {
  RecordingDevice inner;
  GuardedDevice device(inner);
  MonotonicClock clock;
  FakeBody body(device);
  HapticLoop loop(body, device, clock, LoopParams{});
  loop.Start();
  WaitFor([&] { return inner.writes > 20; });
  loop.Stop();
  loop.Stop();  // may be called repeatedly
  const RealtimeGrants& grants = loop.grants();
  EXPECT_THAT(grants.scheduling,
              testing::StartsWith(grants.fifo ? "SCHED_FIFO was granted" : "SCHED_FIFO was refused"));
  EXPECT_THAT(grants.memory,
              grants.locked ? testing::HasSubstr(" locked in RAM") : testing::HasSubstr("Memory could not be locked"));
  EXPECT_EQ(grants.priority, grants.fifo ? 80 : 0);
}

TEST(LiveLoop, StopsSafelyWhileOthersRead) {
  for (int run = 0; run < 5; ++run) {
    RecordingDevice inner;
    GuardedDevice device(inner);
    MonotonicClock clock;
    FakeBody body(device);
    body.MakeLeaves(50);
    LoopParams params;
    params.rate_hz = 4000;
    params.lock_memory = false;
    HapticLoop loop(body, device, clock, params);
    std::atomic<bool> done{false};
    std::map<std::array<int, 3>, std::array<float, 512>> mirror;
    std::uint64_t ticks_seen = 0;
    std::thread reader([&] {
      for (bool last = false; !last;) {
        last = done;
        while (const LeafMessage* message = loop.leaves().Peek()) {
          mirror[message->index] = message->values;
          loop.leaves().Pop();
        }
        while (loop.samples().Peek() != nullptr) loop.samples().Pop();
        if (loop.state().Update()) ticks_seen = loop.state().front().last.number;
        loop.tick_times().CalcPercentile_us(0.99);
        loop.stage_times(TickStage::kRemove).CalcPercentile_us(0.99);
        std::this_thread::yield();
      }
    });
    loop.Start();
    WaitFor([&] { return inner.writes > 200; });
    loop.Stop();
    done = true;
    reader.join();
    EXPECT_EQ(inner.force_x_N, 0);
    EXPECT_EQ(ticks_seen, loop.counts().ticks);
  }
}

}  // namespace
}  // namespace kerf
