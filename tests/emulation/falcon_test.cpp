// The Falcon's driver over the Falcon's model: firmware, homing, forces, and all that goes wrong on the way.
#include "emulation/falcon_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <random>

#include "core/heap_guard.h"
#include "devices/falcon/falcon_driver.h"
#include "devices/falcon/falcon_usb.h"
#include "emulation/model_bus.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using testing::HasSubstr;

constexpr double kDt_s = 0.001;

/// Nobody's firmware.
std::vector<std::uint8_t> MakeFirmware(std::size_t bytes = 7324) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> firmware(bytes);
  for (std::uint8_t& byte : firmware) byte = static_cast<std::uint8_t>(random());
  return firmware;
}

FalconModelOptions Running() {
  FalconModelOptions options;
  options.firmware_is_there = true;
  options.homed = true;
  return options;
}

FalconModelOptions Empty() {
  FalconModelOptions options;
  options.firmware = MakeFirmware();
  return options;
}

/// A Falcon in a socket, and a driver that has it open.
struct Bench {
  explicit Bench(FalconModelOptions model_options = Running(), FalconOptions driver_options = {})
      : model(handle, std::move(model_options)) {
    bus.PlugIn(model);
    driver = Open(std::move(driver_options));
  }

  std::unique_ptr<FalconDriver> Open(FalconOptions options) {
    const std::vector<UsbDeviceInfo> devices = bus.List();
    EXPECT_EQ(devices.size(), 1U);
    UsbOpening opening = bus.Open(devices.at(0), kFalconInterface);
    EXPECT_TRUE(opening.transport);
    return std::make_unique<FalconDriver>(std::move(opening.transport), std::move(options));
  }

  void MoveTo(const Vec3& p_D_mm) {
    handle.X_DH.p_AB = p_D_mm;
    bus.Advance(kDt_s);
  }

  RoundEnd Round(const Vec3& f_D_N = Vec3{0}) {
    DriverCommand command;
    command.f_D_N = f_D_N;
    command.engaged = true;
    return driver->Exchange(command, sample);
  }

  /// Until the driver has a place.
  void Settle() {
    for (int i = 0; i < 10 && Round() != RoundEnd::kSample; ++i) {
    }
    ASSERT_EQ(Round(), RoundEnd::kSample);
  }

  void Start() { driver->Start({}); }

  HeldMechanism handle;
  FalconModel model;
  ModelBus bus;
  std::unique_ptr<FalconDriver> driver;
  DriverSample sample;
};

FalconOptions WithFirmware() {
  FalconOptions options;
  options.firmware = MakeFirmware();
  return options;
}

/// Half a count on each leg moves the grip at most this far.
constexpr double kHalfCount_mm = 0.06;

TEST(FalconModel, ACountIsWorthSoMuch) {
  // The Jacobian's inverse, over the sphere of 40 mm.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> draw(-40, 40);
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(draw(random), draw(random), draw(random));
    if (glm::length(p) > 40) continue;
    const glm::dmat3 inverse = glm::inverse(*CalcFalconJacobian(p));
    for (const double b : {-1.0, 1.0}) {
      for (const double c : {-1.0, 1.0}) {
        worst = std::max(worst, glm::length(inverse * Vec3(1, b, c)) * 0.5 * kFalconRadPerCount);
      }
    }
  }
  EXPECT_LT(worst, kHalfCount_mm);
  EXPECT_GT(worst, 0.5 * kHalfCount_mm);
}

TEST(FalconModel, IsFoundAsAFalcon) {
  Bench bench;
  const UsbDeviceInfo info = bench.bus.List().at(0);
  EXPECT_EQ(info.vendor, kFalconVendor);
  EXPECT_EQ(info.product, kFalconProduct);
  EXPECT_FALSE(info.is_hid);
  const std::vector<std::uint8_t> bytes = bench.model.descriptors();
  EXPECT_EQ(bytes.size(), 18U + 32U);
  EXPECT_EQ(bytes[18 + 2], 32);  // length of configuration and all below it
}

TEST(FalconModel, RefusesWhatAnFt232DoesNotKnow) {
  Bench bench;
  const auto end = [&](std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index) {
    return bench.model.Control(type, request, value, index, {}).end;
  };
  EXPECT_EQ(end(0x40, kFtdiBaud, 0x4138, 0), TransferEnd::kOk);
  EXPECT_EQ(end(0x40, 0x77, 0, 0), TransferEnd::kStall);
  EXPECT_EQ(end(0x21, kFtdiBaud, 0x4138, 0), TransferEnd::kStall);
  EXPECT_EQ(end(0x40, kFtdiBaud, 0x4138, 5), TransferEnd::kStall);
  EXPECT_EQ(end(0x40, kFtdiReset, 3, 0), TransferEnd::kStall);
  EXPECT_EQ(end(0x40, kFtdiLatency, 0, 0), TransferEnd::kStall);
  std::array<std::uint8_t, 64> bytes{};
  EXPECT_EQ(bench.model.Write(0x04, bytes).end, TransferEnd::kStall);
  EXPECT_EQ(bench.model.Read(0x83, bytes).end, TransferEnd::kStall);
}

TEST(FalconModel, SendsTwoStatusBytesWhenTheLatencyTimerRunsOut) {
  Bench bench;
  bench.model.Control(kFtdiRequestType, kFtdiLatency, 5, 0, {});
  std::array<std::uint8_t, 64> bytes{};
  bench.model.Read(kFalconEndpointIn, bytes);
  int packets = 0;
  for (int ms = 0; ms < 50; ++ms) {
    bench.bus.Advance(kDt_s);
    const Transfer transfer = bench.model.Read(kFalconEndpointIn, bytes);
    if (transfer.end == TransferEnd::kTimeout) continue;
    EXPECT_EQ(transfer.bytes, 2);
    ++packets;
  }
  EXPECT_NEAR(packets, 10, 1);
}

TEST(FalconModel, BootLoaderKeepsToItsOrder) {
  // Each step left out or in the wrong place: nothing answers. All in order: it does.
  struct Request {
    std::uint8_t request;
    std::uint16_t value;
  };
  const std::vector<Request> right = {{kFtdiBaud, kFalconBaudBoot},   {kFtdiFormat, kFtdiFormat8N1},
                                      {kFtdiFlowControl, 0},          {kFtdiModemLines, kFtdiRtsLow},
                                      {kFtdiModemLines, kFtdiDtrLow}, {kFtdiModemLines, kFtdiDtrHigh}};
  const auto answers = [](const std::vector<Request>& requests, std::span<const std::uint8_t> hello) {
    HeldMechanism handle;
    FalconModel model(handle, Empty());
    for (const Request& r : requests) model.Control(kFtdiRequestType, r.request, r.value, 0, {});
    model.Write(kFalconEndpointOut, hello);
    std::array<std::uint8_t, 64> bytes{};
    return model.Read(kFalconEndpointIn, bytes).bytes > 2;
  };
  EXPECT_TRUE(answers(right, kFalconHello));
  for (const std::size_t left_out : {0U, 5U}) {
    std::vector<Request> wrong = right;
    wrong.erase(wrong.begin() + static_cast<std::ptrdiff_t>(left_out));
    EXPECT_FALSE(answers(wrong, kFalconHello)) << left_out;
  }
  std::vector<Request> fast = right;
  fast[0].value = kFalconBaudRun;
  EXPECT_FALSE(answers(fast, kFalconHello));
  EXPECT_FALSE(answers(right, std::span(&kFalconLoadMark, 1)));
  const std::uint8_t other[] = {0x0a, 0x44, 0x0d};
  EXPECT_FALSE(answers(right, other));
  EXPECT_FALSE(answers(right, Pack(FalconCommand{})));
}

TEST(FalconDriver, LoadsTheFirmwareByteForByte) {
  for (const bool zero : {false, true}) {
    for (const std::size_t bytes : {std::size_t{1024}, std::size_t{7324}, std::size_t{8999}, std::size_t{32768}}) {
      FalconModelOptions options;
      options.firmware = MakeFirmware(bytes);
      options.zero_before_answer = zero;
      FalconOptions driver_options;
      driver_options.firmware = options.firmware;
      Bench bench(options, driver_options);
      double last = -1;
      bench.driver->Start([&](const std::string& doing, double share) {
        EXPECT_FALSE(doing.empty());
        EXPECT_GE(share, last);
        last = share;
        return true;
      });
      EXPECT_EQ(last, 1);
      EXPECT_TRUE(bench.model.runs());
      EXPECT_EQ(bench.model.loaded(), options.firmware);
      EXPECT_EQ(bench.model.uploads(), 1);
      EXPECT_EQ(bench.driver->firmware_sha256().size(), 64U);
    }
  }
}

TEST(FalconDriver, TriesUpToTenTimes) {
  for (const int wrong : {1, 9}) {
    FalconModelOptions options = Empty();
    options.wrong_echoes = wrong;
    Bench bench(options, WithFirmware());
    bench.Start();
    EXPECT_EQ(bench.model.uploads(), wrong + 1);
    EXPECT_EQ(bench.model.loaded(), options.firmware);
  }
  FalconModelOptions options = Empty();
  options.wrong_echoes = 10;
  Bench bench(options, WithFirmware());
  EXPECT_THROW(
      try { bench.Start(); } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("unplug"));
        EXPECT_THAT(error.what(), HasSubstr(bench.driver->firmware_sha256()));
        throw;
      },
      Error);
}

TEST(FalconDriver, UsesAFalconThatRunsAlready) {
  Bench bench;
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 0);
}

TEST(FalconDriver, SaysHowToGiveFirmware) {
  Bench bench(Empty());
  EXPECT_THROW(
      try { bench.Start(); } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("--falcon-firmware"));
        EXPECT_THAT(error.what(), HasSubstr("KERF_FALCON_FIRMWARE"));
        throw;
      },
      Error);
}

TEST(FalconDriver, RefusesFilesThatAreNoFirmware) {
  for (const std::size_t bytes : {1U, 1023U, 32769U}) {
    EXPECT_THROW(CheckFalconFirmware(MakeFirmware(bytes), "a.bin"), Error);
    FalconOptions options;
    options.firmware = MakeFirmware(bytes);
    EXPECT_THROW(Bench(Empty(), options), Error);
  }
  CheckFalconFirmware(MakeFirmware(1024), "a.bin");
  CheckFalconFirmware(MakeFirmware(32768), "a.bin");
}

TEST(FalconDriver, StartCanBeCalledOff) {
  Bench bench(Empty(), WithFirmware());
  EXPECT_THROW(bench.driver->Start([](const std::string&, double share) { return share < 0.3; }), Error);
  EXPECT_FALSE(bench.model.runs());
  bench.Start();
  EXPECT_TRUE(bench.model.runs());
}

TEST(FalconDriver, StartOnAStalledOrUnpluggedFalconSaysSo) {
  Bench stalled(Empty(), WithFirmware());
  stalled.bus.SetFaults({.stalled = true});
  EXPECT_THROW(stalled.Start(), Error);
  Bench unplugged;
  unplugged.bus.SetFaults({.unplugged = true});
  EXPECT_THROW(unplugged.Start(), Error);
}

TEST(FalconDriver, HomesAndForgetsWhatWasBefore) {
  FalconModelOptions options = Empty();
  Bench bench(options, WithFirmware());
  bench.Start();
  const auto stay = [&](const Vec3& p) {
    bench.MoveTo(p);
    for (int i = 0; i < 5; ++i) bench.Round({0, 0, 5});
  };
  // Neither out alone nor in alone is enough, and no motor moves before.
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0, 0, -35), Vec3(0, 0, 38), Vec3(0, 0, 0)}) {
    stay(p);
    EXPECT_EQ(bench.Round({0, 0, 5}), RoundEnd::kSample);
    EXPECT_FALSE(bench.sample.homed);
    EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
    EXPECT_EQ(bench.model.last_command().lamps, kFalconRed);
  }
  stay({0, 0, -35});
  EXPECT_EQ(bench.Round(), RoundEnd::kSample);
  EXPECT_TRUE(bench.sample.homed);
  EXPECT_TRUE(bench.model.homed());
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - Vec3(0, 0, -35)), kHalfCount_mm);
  EXPECT_FALSE(bench.model.saw_homing_off());
}

TEST(FalconDriver, ShowsLampsAndButtons) {
  Bench bench;
  bench.Start();
  bench.Settle();
  bench.Round();
  EXPECT_EQ(bench.model.last_command().lamps, kFalconGreen);
  bench.driver->Exchange(DriverCommand{}, bench.sample);
  EXPECT_EQ(bench.model.last_command().lamps, kFalconBlue);
  for (std::uint32_t buttons = 0; buttons < 16; ++buttons) {
    bench.handle.pressed = buttons;
    ASSERT_EQ(bench.Round(), RoundEnd::kSample);
    EXPECT_EQ(bench.sample.buttons, buttons);
  }
  EXPECT_EQ(bench.driver->traits().buttons.size(), 4U);
}

TEST(FalconDriver, FollowsTheHandleForAThousandRounds) {
  Bench bench;
  bench.Start();
  bench.Settle();
  for (int i = 0; i < 1000; ++i) {
    const double a = 0.01 * i;
    const Vec3 p(30 * std::sin(a), 25 * std::sin(1.7 * a), 25 * std::sin(0.6 * a));
    bench.MoveTo(p);
    ASSERT_EQ(bench.Round(), RoundEnd::kSample) << i;
    ASSERT_TRUE(bench.sample.homed);
    ASSERT_LT(glm::length(bench.sample.X_DH.p_AB - p), kHalfCount_mm) << i;
  }
}

TEST(FalconDriver, ForceAtTheGripIsTheOneCommanded) {
  // Rounding to a motor count is off by half of one, 0.05 N mm on each arm, and arms of 60 mm and shins make of
  // it at most the force that one count on each leg makes.
  Bench bench;
  bench.Start();
  bench.Settle();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    bench.MoveTo(22.0 * Vec3(draw(random), draw(random), draw(random)));
    for (int k = 0; k < 3; ++k) bench.Round();  // a leap is believed at the second report
    ASSERT_EQ(bench.Round(), RoundEnd::kSample);
    const Vec3 f = 3.0 * Vec3(draw(random), draw(random), draw(random));
    ASSERT_EQ(bench.Round(f), RoundEnd::kSample);
    const std::optional<glm::dmat3> J = CalcFalconJacobian(bench.handle.X_DH.p_AB);
    ASSERT_TRUE(J);
    // Half a count of torque, and the place known to half a count.
    const double rounding = 0.05 * (glm::length((*J)[0]) + glm::length((*J)[1]) + glm::length((*J)[2]));
    ASSERT_LT(glm::length(bench.model.f_D_N() - f), rounding + 0.01 * glm::length(f)) << i;
  }
}

TEST(FalconDriver, BeyondTheLimitTheDirectionIsKept) {
  Bench bench;
  bench.Start();
  bench.Settle();
  std::mt19937 random(6);
  std::normal_distribution<double> draw;
  double smallest = 1e9;
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 f = std::pow(10.0, 2 + i % 200) * Vec3(draw(random), draw(random), draw(random));
    ASSERT_EQ(bench.Round(f), RoundEnd::kSample);
    for (const int motor : bench.driver->motors()) ASSERT_LE(std::abs(motor), 4096);
    const Vec3 made = bench.model.f_D_N();
    // The limit of 8 N of the profile, or that of the motors.
    ASSERT_LE(glm::length(made), 8.01);
    ASSERT_GT(glm::dot(glm::normalize(made), *CalcDirection(f)), 1 - 2e-6) << i;  // 0.1 degrees
    smallest = std::min(smallest, glm::length(made));
    largest = std::max(largest, glm::length(made));
  }
  EXPECT_GT(smallest, 6);  // the worst direction, by devices.md's figure
  EXPECT_GT(largest, 7.9);
}

TEST(FalconDriver, NonsenseIsNoForce) {
  Bench bench;
  bench.Start();
  bench.Settle();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Vec3& f : {Vec3(nan, 1, 1), Vec3(1, infinity, 1), Vec3(1, 1, -infinity)}) {
    bench.Round({1, 2, 3});
    EXPECT_NE(bench.model.last_command().motors, (std::array<int, 3>{}));
    bench.Round(f);
    EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  }
  bench.Round({1e300, 1e300, -1e300});
  EXPECT_GT(glm::length(bench.model.f_D_N()), 6);
}

TEST(FalconDriver, StopIsNoForce) {
  Bench bench;
  bench.Start();
  bench.Settle();
  bench.Round({1, 2, 3});
  bench.driver->Stop();
  bench.driver->Stop();
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  bench.Settle();
  bench.Round({1, 2, 3});
  bench.driver.reset();
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
}

TEST(FalconDriver, ALeapIsBelievedWhenItIsSaidTwice) {
  Bench bench;
  bench.Start();
  bench.Settle();
  const Vec3 before = bench.sample.X_DH.p_AB;
  bench.MoveTo({10, 10, 20});
  EXPECT_EQ(bench.Round(), RoundEnd::kBadAnswer);
  EXPECT_EQ(bench.sample.X_DH.p_AB, before);
  EXPECT_EQ(bench.Round(), RoundEnd::kSample);
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - Vec3(10, 10, 20)), kHalfCount_mm);
}

struct Tally {
  int samples = 0;
  int none = 0;
  int bad = 0;
  int gone = 0;
  double worst_mm = 0;  // of samples, from the nearest of the last places
};

/// Rounds on a slow circle, the faults as they are set.
Tally RunRounds(Bench& bench, int rounds, int memory) {
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

Tally RunWith(const UsbFaults& faults, int memory, FalconModelOptions options = Running()) {
  Bench bench(std::move(options));
  bench.handle.X_DH.p_AB = Vec3(25, 0, 0);
  bench.bus.Advance(kDt_s);
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
  // A doubled packet makes the next answer late by a round, until the serial port has two of them in a packet.
  for (const bool twice : {false, true}) {
    UsbFaults faults;
    (twice ? faults.duplicate : faults.delay) = 0.05;
    const Tally tally = RunWith(faults, 4);
    EXPECT_GT(tally.samples, 19000);
    EXPECT_LT(tally.worst_mm, kHalfCount_mm);
  }
}

TEST(FalconDriver, PacketsCutShortAreSeen) {
  UsbFaults faults;
  faults.truncate = 0.05;
  const Tally tally = RunWith(faults, 0);
  EXPECT_GT(tally.samples, 18000);
  EXPECT_GT(tally.bad, 500);
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
  FalconModelOptions options = Running();
  options.short_report_every = 20;
  const Tally fourteen = RunWith({}, 0, options);
  EXPECT_EQ(fourteen.samples + fourteen.bad, 20000);
  EXPECT_NEAR(fourteen.bad, 1000, 50);
  EXPECT_LT(fourteen.worst_mm, kHalfCount_mm);
}

TEST(FalconDriver, ReportsInTwoPacketsAreWhole) {
  FalconModelOptions options = Running();
  options.split_report_every = 3;
  const Tally tally = RunWith({}, 0, options);
  EXPECT_EQ(tally.samples, 20000);
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
}

TEST(FalconDriver, ChangedBytesAreSeenOrSmall) {
  // What the format can't show is a nibble that became another one: no further than the leap that is believed, on one
  // leg. 100 counts are 200 times half a count.
  UsbFaults faults;
  faults.corrupt = 0.05;
  const Tally tally = RunWith(faults, 0);
  EXPECT_GT(tally.samples, 18500);
  EXPECT_GT(tally.bad, 300);
  EXPECT_LT(tally.worst_mm, 200 * kHalfCount_mm);
}

TEST(FalconDriver, AnswersThatTakeTheirTime) {
  FalconModelOptions options = Running();
  options.answer_after_s = 0.002;
  Bench bench(options);
  bench.Start();
  bench.Settle();
  const Tally tally = RunRounds(bench, 2000, 8);
  EXPECT_EQ(tally.samples, 1999);  // the leap to the circle is believed at the second report
  EXPECT_LT(tally.worst_mm, kHalfCount_mm);
}

/// Answers without heap memory, unlike a model on a bus.
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

TEST(FalconDriver, RoundsAskForNoHeapMemory) {
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

TEST(FalconDriver, StalledThenBack) {
  Bench bench;
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.stalled = true});
  for (int i = 0; i < 100; ++i) ASSERT_EQ(bench.Round(), RoundEnd::kNoAnswer);
  bench.bus.SetFaults({});
  bench.Settle();
}

TEST(FalconDriver, AnAnswerThatCameTooLateDoesNotMakeAllOthersLate) {
  FalconModelOptions options = Running();
  options.answer_after_s = 0.002;
  Bench bench(options);
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
  Bench bench(Empty(), WithFirmware());
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
  ASSERT_EQ(bench.Round(), RoundEnd::kGone);  // the old one stays gone
  bench.driver = bench.Open(WithFirmware());
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 2);
  // It has lost its zero with its power.
  for (int i = 0; i < 5; ++i) bench.Round({1, 1, 1});
  EXPECT_FALSE(bench.sample.homed);
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  home();
}

TEST(FalconDriver, UnpluggedWithItsPowerOnIsStillHomed) {
  FalconModelOptions options = Running();
  options.keeps_power = true;
  Bench bench(options);
  bench.Start();
  bench.Settle();
  bench.bus.SetFaults({.unplugged = true});
  EXPECT_EQ(bench.Round({1, 1, 1}), RoundEnd::kGone);
  bench.bus.PlugInAgain();
  bench.driver = bench.Open({});
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 0);
  // No force before its place is known.
  bench.Round({1, 1, 1});
  EXPECT_EQ(bench.model.last_command().motors, (std::array<int, 3>{}));
  bench.Settle();
  EXPECT_TRUE(bench.sample.homed);
}

TEST(FalconDriver, StartsAgainAfterStop) {
  Bench bench(Empty(), WithFirmware());
  EXPECT_FALSE(bench.driver->Runs());
  for (int i = 0; i < 3; ++i) {
    bench.Start();
    EXPECT_TRUE(bench.driver->Runs());
    bench.Settle();
    bench.driver->Stop();
  }
  EXPECT_EQ(bench.model.uploads(), 1);
}

TEST(FalconDriver, StartsThroughFaults) {
  // Firmware through a line that loses and damages packets: one of the attempts goes well, or it says what to do; what
  // runs in the end is the firmware, byte for byte.
  int started = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Bench bench(Empty(), WithFirmware());
    bench.bus.SetFaults({.seed = seed, .drop_out = 0.001, .drop_in = 0.001, .truncate = 0.001, .corrupt = 0.001});
    try {
      bench.Start();
      ++started;
      EXPECT_TRUE(bench.model.runs());
      EXPECT_EQ(bench.model.loaded(), MakeFirmware());
    } catch (const Error&) {
    }
  }
  EXPECT_GT(started, 30);
}

TEST(FalconDriver, AMillionRoundsWithAllFaultsAtOnce) {
  Bench bench;
  bench.handle.X_DH.p_AB = Vec3(25, 0, 0);
  bench.bus.Advance(kDt_s);
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
  for (int i = 0; i < 1000000; ++i) {
    const double a = 0.004 * i;
    bench.handle.X_DH.p_AB = Vec3(25 * std::cos(a), 25 * std::sin(a), 10 * std::sin(0.3 * a));
    DriverCommand command;
    command.f_D_N = Vec3(3 * std::sin(0.01 * i), 2, -1);
    const RoundEnd end = bench.driver->Exchange(command, bench.sample);
    ASSERT_NE(end, RoundEnd::kGone);
    if (i % 8 == 0) bench.bus.Advance(kDt_s);
    // Whatever arrived at the motors: commands whose nibbles were changed are not among these faults.
    largest_N = std::max(largest_N, glm::length(bench.model.f_D_N()));
    if (end != RoundEnd::kSample) continue;
    ++samples;
    ASSERT_TRUE(IsValid(bench.sample.X_DH));
    ASSERT_LT(glm::length(bench.sample.X_DH.p_AB), 110 * 1.8);
  }
  EXPECT_GT(samples, 800000);
  EXPECT_LT(largest_N, 16);
  bench.bus.SetFaults({});
  bench.Settle();
  bench.Settle();
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - bench.handle.X_DH.p_AB), kHalfCount_mm);
}

}  // namespace
}  // namespace kerf
