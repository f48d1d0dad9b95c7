// The Falcon's driver with faults of the connection: lost, late and damaged packets, and unplugged cables.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "base/core/heap_guard.h"
#include "device/emulation/falcon_bench.h"
#include "kerf/error.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

struct Tally {
  int samples = 0;
  int none = 0;
  int bad = 0;
  int gone = 0;
  double worst_mm = 0;  // largest distance of a sample from the nearest of the last positions
};

/// Runs rounds on a slow circle with the faults that are set.
Tally RunRounds(FalconBench& bench, int rounds, int memory) {
  Tally tally;
  std::vector<Vec3> places;
  const auto place = [](int i) {
    const double a = 0.004 * i;
    return Vec3(25 * std::cos(a), 25 * std::sin(a), 10 * std::sin(0.3 * a));
  };
  for (int i = 0; i < rounds; ++i) {
    bench.MoveTo(place(i));
    switch (bench.Round(Vec3(0.5, 0.2, -0.1))) {
      case RoundEnd::kSample: {
        ++tally.samples;
        double nearest = 1e9;
        for (int k = std::max(0, i - memory); k <= i; ++k) {
          nearest = std::min(nearest, glm::length(bench.sample.X_DH.p_AB - place(k)));
        }
        tally.worst_mm = std::max(tally.worst_mm, nearest);
        break;
      }
      case RoundEnd::kNoAnswer:
        ++tally.none;
        break;
      case RoundEnd::kBadAnswer:
        ++tally.bad;
        break;
      case RoundEnd::kGone:
        ++tally.gone;
        break;
    }
  }
  return tally;
}

Tally RunWith(const UsbFaults& faults, int memory, FalconModelOptions options = RunningFalcon()) {
  FalconBench bench(std::move(options));
  bench.handle.X_DH.p_AB = Vec3(25, 0, 0);
  bench.bus.Advance(kFalconDt_s);
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults(faults);
  return RunRounds(bench, 20000, memory);
}

TEST(FalconDriver, LostPacketsAreRoundsWithoutAnswer) {
  for (const bool out : {false, true}) {
    UsbFaults faults;
    (out ? faults.drop_out : faults.drop_in) = 0.05;
    const Tally tally = RunWith(faults, 0);
    EXPECT_NEAR(tally.none, 1000, 150);
    EXPECT_EQ(tally.bad, 0);
    EXPECT_EQ(tally.samples + tally.none, 20000);
    EXPECT_LT(tally.worst_mm, kHalfCount_mm);
  }
}

TEST(FalconDriver, OldAnswersDoNotPileUp) {
  // A doubled packet delays the next answer by a round, until the serial port sends two answers in one packet.
  for (const bool twice : {false, true}) {
    UsbFaults faults;
    (twice ? faults.duplicate : faults.delay) = 0.05;
    const Tally tally = RunWith(faults, 4);
    EXPECT_GT(tally.samples, 19000);
    EXPECT_LT(tally.worst_mm, kHalfCount_mm);
  }
}

TEST(FalconDriver, TruncatedPacketsAreDetected) {
  UsbFaults faults;
  faults.truncate = 0.05;
  const Tally tally = RunWith(faults, 0);
  EXPECT_GT(tally.samples, 18000);
  EXPECT_GT(tally.bad, 500);
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
  FalconModelOptions options = RunningFalcon();
  options.short_report_every = 20;
  const Tally fourteen = RunWith({}, 0, options);
  EXPECT_EQ(fourteen.samples + fourteen.bad, 20000);
  EXPECT_NEAR(fourteen.bad, 1000, 50);
  EXPECT_LT(fourteen.worst_mm, kHalfCount_mm);
}

TEST(FalconDriver, ReportsInTwoPacketsAreReassembled) {
  FalconModelOptions options = RunningFalcon();
  options.split_report_every = 3;
  const Tally tally = RunWith({}, 0, options);
  EXPECT_EQ(tally.samples, 20000);
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
}

TEST(FalconDriver, ChangedBytesAreDetectedOrCauseASmallError) {
  // The format cannot reveal a nibble that was changed to another valid one; the error is at most the largest accepted
  // jump on one leg, 100 counts, which is 200 times half a count.
  UsbFaults faults;
  faults.corrupt = 0.05;
  const Tally tally = RunWith(faults, 0);
  EXPECT_GT(tally.samples, 18500);
  EXPECT_GT(tally.bad, 300);
  EXPECT_LT(tally.worst_mm, 200 * kHalfCount_mm);
}

TEST(FalconDriver, AcceptsDelayedAnswers) {
  FalconModelOptions options = RunningFalcon();
  options.answer_after_s = 0.002;
  FalconBench bench(options);
  bench.Start();
  bench.Settle();
  const Tally tally = RunRounds(bench, 2000, 8);
  EXPECT_EQ(tally.samples, 1999);  // the jump to the circle is accepted with the second report
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
}

/// Answers without heap use, unlike a model on a bus.
class PlainTransport final : public UsbTransport {
 public:
  Transfer Control(std::uint8_t, std::uint8_t, std::uint16_t, std::uint16_t, std::span<std::uint8_t>,
                   int) noexcept override {
    return {TransferEnd::kOk, 0};
  }
  Transfer Write(std::uint8_t, std::span<const std::uint8_t> data, int) noexcept override {
    asked_ = true;
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Read(std::uint8_t, std::span<std::uint8_t> data, int) noexcept override {
    const FalconPacket packet = Pack(FalconReport{{10 + rounds_ % 7, -20, 300}, 0, kFalconAllHomed});
    const std::size_t bytes = asked_ ? packet.size() : 0;
    std::copy_n(packet.begin(), bytes, data.begin() + kFtdiStatusBytes);
    asked_ = false;
    ++rounds_;
    return {TransferEnd::kOk, static_cast<int>(kFtdiStatusBytes + bytes)};
  }

 private:
  bool asked_ = false;
  int rounds_ = 0;
};

TEST(FalconDriver, RoundsAllocateNothing) {
  FalconDriver driver(std::make_unique<PlainTransport>(), {});
  driver.Start({});
  DriverSample sample;
  DriverCommand command;
  command.f_D_N = Vec3(1, 2, 3);
  int samples = 0;
  for (int i = 0; i < 1000; ++i) {
    const HeapGuard guard;
    samples += driver.Exchange(command, sample) == RoundEnd::kSample ? 1 : 0;
  }
  EXPECT_EQ(samples, 999);
}

TEST(FalconDriver, ContinuesAfterAStall) {
  FalconBench bench;
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.stalled = true});
  for (int i = 0; i < 100; ++i) ASSERT_EQ(bench.Round(), RoundEnd::kNoAnswer);
  bench.bus.SetFaults({});
  bench.Settle();
}

TEST(FalconDriver, LateAnswerDoesNotDelayLaterAnswers) {
  FalconModelOptions options = RunningFalcon();
  options.answer_after_s = 0.002;
  FalconBench bench(options);
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.stalled = true});
  for (int i = 0; i < 3; ++i) ASSERT_EQ(bench.Round(), RoundEnd::kNoAnswer);
  bench.bus.SetFaults({});
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(0.1 * i, 0, 0);
    bench.MoveTo(p);
    ASSERT_EQ(bench.Round(), RoundEnd::kSample);
    ASSERT_LT(glm::length(bench.sample.X_DH.p_AB - p), kHalfCount_mm) << i;
  }
}

TEST(FalconDriver, UnpluggedAndPluggedInAgain) {
  FalconBench bench(EmptyFalcon(), WithFalconFirmware());
  const auto home = [&] {
    for (const double z : {38.0, -35.0, 0.0}) {
      bench.MoveTo({0, 0, z});
      for (int i = 0; i < 5; ++i) bench.Round();
    }
    EXPECT_EQ(bench.Round(), RoundEnd::kSample);
    EXPECT_TRUE(bench.sample.homed);
  };
  bench.Start();
  home();
  bench.Round({1, 1, 1});
  bench.bus.SetFaults({.unplugged = true});
  const DriverSample last = bench.sample;
  for (int i = 0; i < 10; ++i) ASSERT_EQ(bench.Round(), RoundEnd::kGone);
  EXPECT_EQ(bench.sample.X_DH.p_AB, last.X_DH.p_AB);
  bench.driver->Stop();
  EXPECT_THROW(bench.Start(), Error);
  bench.bus.PlugInAgain();
  ASSERT_EQ(bench.Round(), RoundEnd::kGone);  // the old driver remains without a device
  bench.driver = bench.Open(WithFalconFirmware());
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 2);
  // The device has lost its zero together with its power.
  for (int i = 0; i < 5; ++i) bench.Round({1, 1, 1});
  EXPECT_FALSE(bench.sample.homed);
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  home();
}

TEST(FalconDriver, UnpluggedWithItsPowerOnIsStillHomed) {
  FalconModelOptions options = RunningFalcon();
  options.keeps_power = true;
  FalconBench bench(options);
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.unplugged = true});
  EXPECT_EQ(bench.Round({1, 1, 1}), RoundEnd::kGone);
  bench.bus.PlugInAgain();
  bench.driver = bench.Open({});
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 0);
  // There is no force before the device's position is known.
  bench.Round({1, 1, 1});
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  bench.Settle();
  EXPECT_TRUE(bench.sample.homed);
}

TEST(FalconDriver, StartsAgainAfterStop) {
  FalconBench bench(EmptyFalcon(), WithFalconFirmware());
  for (int i = 0; i < 3; ++i) {
    bench.Start();
    bench.Settle();
    bench.driver->Stop();
  }
  EXPECT_EQ(bench.model.uploads(), 1);
}

TEST(FalconDriver, StartsDespiteFaults) {
  // Firmware is uploaded over a line that loses and damages packets. Either one of the attempts succeeds, or the error
  // states what to do. If it succeeds, the loaded firmware is correct byte for byte.
  int started = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    FalconBench bench(EmptyFalcon(), WithFalconFirmware());
    bench.bus.SetFaults({.seed = seed, .drop_out = 0.001, .drop_in = 0.001, .truncate = 0.001, .corrupt = 0.001});
    try {
      bench.Start();
      ++started;
      EXPECT_TRUE(bench.model.runs());
      EXPECT_EQ(bench.model.loaded(), MakeFalconFirmware());
    } catch (const Error&) {
    }
  }
  EXPECT_GT(started, 30);
}

TEST(FalconDriver, RoundsWithAllFaultsAtOnce) {
  FalconBench bench;
  bench.handle.X_DH.p_AB = Vec3(25, 0, 0);
  bench.bus.Advance(kFalconDt_s);
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.seed = 9,
                       .drop_out = 0.02,
                       .drop_in = 0.02,
                       .duplicate = 0.02,
                       .truncate = 0.02,
                       .corrupt = 0.02,
                       .delay = 0.02});
  std::mt19937_64 random(10);
  int samples = 0;
  double largest_N = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    const double a = 0.004 * i;
    bench.handle.X_DH.p_AB = Vec3(25 * std::cos(a), 25 * std::sin(a), 10 * std::sin(0.3 * a));
    DriverCommand command;
    command.f_D_N = Vec3(3 * std::sin(0.01 * i), 2, -1);
    const RoundEnd end = bench.driver->Exchange(command, bench.sample);
    ASSERT_NE(end, RoundEnd::kGone);
    if (i % 8 == 0) bench.bus.Advance(kFalconDt_s);
    // This is the force of the motors; the faults here do not include changed nibbles in commands.
    largest_N = std::max(largest_N, glm::length(bench.model.f_D_N()));
    if (end != RoundEnd::kSample) continue;
    ++samples;
    ASSERT_TRUE(IsValid(bench.sample.X_DH));
    ASSERT_LT(glm::length(bench.sample.X_DH.p_AB), 110 * 1.8);
  }
  EXPECT_GT(samples, 0.8 * cases);
  EXPECT_LT(largest_N, 16);
  bench.bus.SetFaults({});
  bench.Settle();
  bench.Settle();
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - bench.handle.X_DH.p_AB), kHalfCount_mm);
}

}  // namespace
}  // namespace kerf
