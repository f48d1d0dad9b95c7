// The SpaceMouse driver with a model of the device, and the device's reports.
#include "device/devices/hid/spacemouse_driver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include "base/core/heap_guard.h"
#include "device/devices/hid/hid_report.h"
#include "device/emulation/direct_line.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/spacemouse_model.h"
#include "kerf/error.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

struct Rig {
  explicit Rig(bool six_axes = false, std::uint16_t vendor = 0x046d, std::uint16_t product = 0xc626)
      : model(vendor, product, six_axes) {
    bus.PlugIn(model);
    const UsbDeviceInfo info = bus.List().at(0);
    driver = std::make_unique<SpaceMouseDriver>(bus.Open(info, 0).transport, *FindSpaceMouse(info));
    driver->Start(nullptr);
  }
  DriverSample Run(int rounds) {
    DriverSample sample;
    for (int i = 0; i < rounds; ++i) {
      bus.Advance(0.004);
      EXPECT_EQ(driver->Exchange({}, sample), RoundEnd::kSample);
    }
    return sample;
  }

  SpaceMouseEmulation model;
  ModelBus bus;
  std::unique_ptr<SpaceMouseDriver> driver;
};

TEST(SpaceMouse, ReportsTheDeflectionOfTheCap) {
  for (const bool six_axes : {false, true}) {
    Rig setup(six_axes, 0x256f, 0xc62e);
    EXPECT_TRUE(setup.model.lamp());
    setup.model.Push({350, 175, -350, 0, 20, 350});
    const DriverSample sample = setup.Run(20);
    const double half = (0.5 - 0.06) / (1 - 0.06);
    const std::array<double, 6> wanted = {1, 1, half, 0, -1, 0};  // right, up, towards the user; rotations about them
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(sample.deflection[i], wanted[i], 1e-12) << i;
    setup.model.Push({});
    EXPECT_EQ(setup.Run(20).deflection, (std::array<double, 6>{}));
  }
}

TEST(SpaceMouse, ButtonsAreReportedAsBits) {
  Rig setup;
  setup.model.Press(0b10);
  EXPECT_EQ(setup.Run(10).buttons, 0b10u);
  setup.model.Press(0);
  EXPECT_EQ(setup.Run(10).buttons, 0u);
}

TEST(SpaceMouse, ButtonIsReportedAfterALongPauseOfTheHost) {
  for (const bool six_axes : {false, true}) {
    Rig setup(six_axes);
    setup.model.Push({350, 0, 0, 0, 0, 0});
    setup.model.Press(0b10);
    for (int i = 0; i < 1000; ++i) setup.bus.Advance(0.008);
    const DriverSample sample = setup.Run(40);
    EXPECT_EQ(sample.buttons, 0b10u);
    EXPECT_EQ(sample.deflection[0], 1);
  }
  // The buttons change more often than the queue can store; the final state counts.
  Rig setup;
  for (std::uint32_t i = 0; i < 100; ++i) {
    setup.model.Press(i % 2 == 0 ? 0b100 : 0b1000);
    setup.bus.Advance(0.008);
  }
  EXPECT_EQ(setup.Run(40).buttons, 0b1000u);
}

TEST(SpaceMouse, SilenceAtRestIsNotAFault) {
  SpaceMouseEmulation model;
  SpaceMouseDriver driver(std::make_unique<test::DirectLine>(model), SpaceMouseModels()[6]);
  driver.Start(nullptr);
  DriverSample sample;
  for (int i = 0; i < 100; ++i) {
    RoundEnd end;
    {
      HeapGuard guard;
      end = driver.Exchange({}, sample);
    }
    ASSERT_EQ(end, RoundEnd::kSample);
  }
  EXPECT_EQ(sample.deflection, (std::array<double, 6>{}));
}

TEST(SpaceMouse, CapIsReleasedIfItsLastReportWasLost) {
  Rig setup;
  setup.model.Push({300, 0, 0, 0, 0, 0});
  EXPECT_GT(setup.Run(20).deflection[0], 0.8);
  UsbFaults faults;
  faults.stalled = true;
  setup.bus.SetFaults(faults);
  EXPECT_GT(setup.Run(10).deflection[0], 0.8);  // 0.1 s
  EXPECT_EQ(setup.Run(60).deflection[0], 0);
}

/// Transport that reports once that the cap is pushed to the right; time advances only while the driver waits.
class OneWord final : public UsbTransport {
 public:
  explicit OneWord(double& now_s) : now_s_(now_s) {}
  Transfer Control(std::uint8_t /*request_type*/, std::uint8_t /*request*/, std::uint16_t /*value*/,
                   std::uint16_t /*index*/, std::span<std::uint8_t> data, int /*timeout_ms*/) noexcept override {
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Write(std::uint8_t /*endpoint*/, std::span<const std::uint8_t> data, int /*timeout_ms*/) noexcept override {
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Read(std::uint8_t /*endpoint*/, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    if (reported_) {
      now_s_ += 1e-3 * timeout_ms;
      return {TransferEnd::kTimeout, 0};
    }
    reported_ = true;
    constexpr std::array<std::uint8_t, 7> kPushed = {1, 0x5e, 0x01, 0, 0, 0, 0};
    std::copy(kPushed.begin(), kPushed.end(), data.begin());
    return {TransferEnd::kOk, static_cast<int>(kPushed.size())};
  }

 private:
  double& now_s_;
  bool reported_ = false;
};

TEST(SpaceMouse, SilentCapIsReleasedAfterTheDocumentedTime) {
  double now_s = 0;
  SpaceMouseDriver driver(std::make_unique<OneWord>(now_s), SpaceMouseModels()[6]);
  driver.Start(nullptr);
  DriverSample sample;
  ASSERT_EQ(driver.Exchange({}, sample), RoundEnd::kSample);
  ASSERT_EQ(sample.deflection[0], 1);
  // Rounds begin at multiples of the period; a round that takes longer skips the rounds that should have begun in the
  // meantime.
  const double period_s = 1 / driver.traits().rate_hz;
  while (sample.deflection[0] != 0 && now_s < 10) {
    now_s = period_s * (std::floor(now_s / period_s + 1e-9) + 1);
    ASSERT_EQ(driver.Exchange({}, sample), RoundEnd::kSample);
  }
  EXPECT_NEAR(now_s, SpaceMouseDriver::kSilence_s, 2 * period_s);
}

TEST(SpaceMouse, StopSwitchesTheLampOffAndAnUnpluggedDeviceIsGone) {
  Rig setup;
  setup.driver->Stop();
  EXPECT_FALSE(setup.model.lamp());
  UsbFaults faults;
  faults.unplugged = true;
  setup.bus.SetFaults(faults);
  DriverSample sample;
  EXPECT_EQ(setup.driver->Exchange({}, sample), RoundEnd::kGone);
  EXPECT_THROW(setup.driver->Start(nullptr), Error);
}

TEST(SpaceMouse, DeflectionIsSymmetricMonotonicAndContinuous) {
  for (int raw = -500; raw <= 500; ++raw) {
    const double x = CalcDeflection(raw, 0.1);
    ASSERT_EQ(x, -CalcDeflection(-raw, 0.1));
    ASSERT_LE(std::abs(x), 1);
    const double rise = CalcDeflection(raw + 1, 0.1) - x;
    ASSERT_GE(rise, 0);
    ASSERT_LE(rise, 1 / (350 * 0.9) + 1e-12);
  }
}

TEST(SpaceMouse, AnyBytesAreAcceptedOrRefused) {
  std::mt19937_64 random(1);
  SpaceMouseState state;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    std::array<std::uint8_t, 16> bytes{};
    for (std::size_t b = 0; b < bytes.size(); b += 8) {
      const std::uint64_t draw = random();
      for (std::size_t k = 0; k < 8; ++k) bytes[b + k] = static_cast<std::uint8_t>(draw >> (8 * k));
    }
    bytes[0] %= 6;
    const SpaceMouseState before = state;
    const SpaceMouseReport report = ReadSpaceMouseReport(std::span(bytes).first(random() % 17), state);
    if (report == SpaceMouseReport::kBad || report == SpaceMouseReport::kOther) {
      ASSERT_EQ(before.axes, state.axes);
      ASSERT_EQ(before.buttons, state.buttons);
    }
    for (const int axis : state.axes) ASSERT_LE(std::abs(axis), 2000);
  }
}

TEST(SpaceMouse, ModelsHaveDifferentIds) {
  std::set<std::pair<int, int>> seen;
  for (const SpaceMouseModel& model : SpaceMouseModels()) {
    EXPECT_TRUE(seen.insert({model.vendor, model.product}).second) << model.name;
  }
  UsbDeviceInfo keyboard;
  keyboard.vendor = 0x046d;
  keyboard.product = 0xc31c;
  EXPECT_EQ(FindSpaceMouse(keyboard), nullptr);
}

TEST(SpaceMouse, DescriptorsOfTheModelAreValid) {
  for (const bool six_axes : {false, true}) {
    SpaceMouseEmulation model(0x256f, 0xc62e, six_axes);
    const std::vector<std::uint8_t> bytes = model.descriptors();
    std::size_t at = 0;
    while (at < bytes.size() && bytes[at] > 0) at += bytes[at];
    EXPECT_EQ(at, bytes.size());
    EXPECT_EQ(bytes[18 + 2] | bytes[18 + 3] << 8, static_cast<int>(bytes.size()) - 18);
    EXPECT_TRUE(ReadDeviceInfo(bytes).is_hid);
    std::array<std::uint8_t, 256> report{};
    const Transfer transfer = model.Control(0x81, 6, 0x2200, 0, report);
    ASSERT_EQ(transfer.end, TransferEnd::kOk);
    const auto sizes = ReadHidReportSizes(std::span(report).first(static_cast<std::size_t>(transfer.bytes)));
    ASSERT_TRUE(sizes);
    EXPECT_EQ(sizes->input_bytes, six_axes ? 12 : 6);
    EXPECT_EQ(sizes->output_bytes, 1);
  }
}

}  // namespace
}  // namespace kerf
