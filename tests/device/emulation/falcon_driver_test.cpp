// The Falcon's model, and its driver with this model: firmware, homing and forces.
#include "device/devices/falcon/falcon_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <random>

#include "device/emulation/falcon_bench.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using testing::HasSubstr;

TEST(FalconModel, HalfACountMovesTheGripAtMostByTheStatedDistance) {
  // Computed with the inverse of the Jacobian, over the sphere of 40 mm.
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

TEST(FalconModel, IsRecognisedAsAFalcon) {
  FalconBench bench;
  const UsbDeviceInfo info = bench.bus.List().at(0);
  EXPECT_EQ(info.vendor, kFalconVendor);
  EXPECT_EQ(info.product, kFalconProduct);
  EXPECT_FALSE(info.is_hid);
  const std::vector<std::uint8_t> bytes = bench.model.descriptors();
  EXPECT_EQ(bytes.size(), 18U + 32U);
  EXPECT_EQ(bytes[18 + 2], 32);  // length of the configuration and all its descriptors
}

TEST(FalconModel, RefusesRequestsThatAnFt232DoesNotSupport) {
  FalconBench bench;
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
  FalconBench bench;
  bench.model.Control(kFtdiRequestType, kFtdiLatency, 5, 0, {});
  std::array<std::uint8_t, 64> bytes{};
  bench.model.Read(kFalconEndpointIn, bytes);
  int packets = 0;
  for (int ms = 0; ms < 50; ++ms) {
    bench.bus.Advance(kFalconDt_s);
    const Transfer transfer = bench.model.Read(kFalconEndpointIn, bytes);
    if (transfer.end == TransferEnd::kTimeout) continue;
    EXPECT_EQ(transfer.bytes, 2);
    ++packets;
  }
  EXPECT_NEAR(packets, 10, 1);
}

TEST(FalconModel, BootLoaderRequiresTheCorrectOrder) {
  // The device answers only if all steps are done in this order.
  struct Request {
    std::uint8_t request;
    std::uint16_t value;
  };
  const std::vector<Request> right = {{kFtdiBaud, kFalconBaudBoot},   {kFtdiFormat, kFtdiFormat8N1},
                                      {kFtdiFlowControl, 0},          {kFtdiModemLines, kFtdiRtsLow},
                                      {kFtdiModemLines, kFtdiDtrLow}, {kFtdiModemLines, kFtdiDtrHigh}};
  const auto answers = [](const std::vector<Request>& requests, std::span<const std::uint8_t> hello) {
    PrescribedMechanism handle;
    FalconModel model(handle, EmptyFalcon());
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
      options.firmware = MakeFalconFirmware(bytes);
      options.zero_before_answer = zero;
      FalconOptions driver_options;
      driver_options.firmware = options.firmware;
      FalconBench bench(options, driver_options);
      double last = -1;
      bench.driver->Start([&](const std::string& doing, double fraction) {
        EXPECT_FALSE(doing.empty());
        EXPECT_GE(fraction, last);
        last = fraction;
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
    FalconModelOptions options = EmptyFalcon();
    options.wrong_echoes = wrong;
    FalconBench bench(options, WithFalconFirmware());
    bench.Start();
    EXPECT_EQ(bench.model.uploads(), wrong + 1);
    EXPECT_EQ(bench.model.loaded(), options.firmware);
  }
  FalconModelOptions options = EmptyFalcon();
  options.wrong_echoes = 10;
  FalconBench bench(options, WithFalconFirmware());
  EXPECT_THROW(
      try { bench.Start(); } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("unplug"));
        EXPECT_THAT(error.what(), HasSubstr(bench.driver->firmware_sha256()));
        throw;
      },
      Error);
}

TEST(FalconDriver, UsesAFalconThatRunsAlready) {
  FalconBench bench;
  bench.Start();
  EXPECT_EQ(bench.model.uploads(), 0);
}

TEST(FalconDriver, ReportsHowToSupplyFirmware) {
  FalconBench bench(EmptyFalcon());
  EXPECT_THROW(
      try { bench.Start(); } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("--falcon-firmware"));
        EXPECT_THAT(error.what(), HasSubstr("KERF_FALCON_FIRMWARE"));
        throw;
      },
      Error);
}

TEST(FalconDriver, RefusesFilesThatCannotBeFirmware) {
  for (const std::size_t bytes : {1U, 1023U, 32769U}) {
    EXPECT_THROW(CheckFalconFirmware(MakeFalconFirmware(bytes), "a.bin"), Error);
    FalconOptions options;
    options.firmware = MakeFalconFirmware(bytes);
    EXPECT_THROW(FalconBench(EmptyFalcon(), options), Error);
  }
  CheckFalconFirmware(MakeFalconFirmware(1024), "a.bin");
  CheckFalconFirmware(MakeFalconFirmware(32768), "a.bin");
}

TEST(FalconDriver, StartCanBeCalledOff) {
  FalconBench bench(EmptyFalcon(), WithFalconFirmware());
  EXPECT_THROW(bench.driver->Start([](const std::string&, double fraction) { return fraction < 0.3; }), Error);
  EXPECT_FALSE(bench.model.runs());
  bench.Start();
  EXPECT_TRUE(bench.model.runs());
}

TEST(FalconDriver, StartReportsAStalledOrUnpluggedFalcon) {
  FalconBench stalled(EmptyFalcon(), WithFalconFirmware());
  stalled.bus.SetFaults({.stalled = true});
  EXPECT_THROW(stalled.Start(), Error);
  FalconBench unplugged;
  unplugged.bus.SetFaults({.unplugged = true});
  EXPECT_THROW(unplugged.Start(), Error);
}

TEST(FalconDriver, RequiresBothHomingPositions) {
  FalconModelOptions options = EmptyFalcon();
  FalconBench bench(options, WithFalconFirmware());
  bench.Start();
  const auto stay = [&](const Vec3& p) {
    bench.MoveTo(p);
    for (int i = 0; i < 5; ++i) bench.Round({0, 0, 5});
  };
  // Neither the outer nor the inner position alone is enough, and no motor is driven before both have been reached.
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
  FalconBench bench;
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
  FalconBench bench;
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
  // Rounding to a motor count causes an error of up to half a count, 0.05 N mm on each arm; with arms of 60 mm and the
  // shins, this is at most the force of one count on each leg.
  FalconBench bench;
  bench.Start();
  bench.Settle();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    bench.MoveTo(22.0 * Vec3(draw(random), draw(random), draw(random)));
    for (int k = 0; k < 3; ++k) bench.Round();  // a jump is accepted with the second report
    ASSERT_EQ(bench.Round(), RoundEnd::kSample);
    const Vec3 f = 3.0 * Vec3(draw(random), draw(random), draw(random));
    ASSERT_EQ(bench.Round(f), RoundEnd::kSample);
    const std::optional<glm::dmat3> J = CalcFalconJacobian(bench.handle.X_DH.p_AB);
    ASSERT_TRUE(J);
    // Rounding by half a count of torque and half a count of position.
    const double rounding = 0.05 * (glm::length((*J)[0]) + glm::length((*J)[1]) + glm::length((*J)[2]));
    ASSERT_LT(glm::length(bench.model.f_D_N() - f), rounding + 0.01 * glm::length(f)) << i;
  }
}

TEST(FalconDriver, LimitedForceKeepsItsDirection) {
  FalconBench bench;
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
    // The force is limited by the profile's 8 N or by the motors.
    ASSERT_LE(glm::length(made), 8.01);
    ASSERT_GT(glm::dot(glm::normalize(made), *CalcDirection(f)), 1 - 2e-6) << i;  // 0.1 degrees
    smallest = std::min(smallest, glm::length(made));
    largest = std::max(largest, glm::length(made));
  }
  EXPECT_GT(smallest, 6);  // in the worst direction, see devices.md
  EXPECT_GT(largest, 7.9);
}

TEST(FalconDriver, InvalidCommandsGiveNoForce) {
  FalconBench bench;
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

TEST(FalconDriver, StopSetsZeroForce) {
  FalconBench bench;
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

TEST(FalconDriver, JumpIsAcceptedWhenItIsReportedTwice) {
  FalconBench bench;
  bench.Start();
  bench.Settle();
  const Vec3 before = bench.sample.X_DH.p_AB;
  bench.MoveTo({10, 10, 20});
  EXPECT_EQ(bench.Round(), RoundEnd::kBadAnswer);
  EXPECT_EQ(bench.sample.X_DH.p_AB, before);
  EXPECT_EQ(bench.Round(), RoundEnd::kSample);
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - Vec3(10, 10, 20)), kHalfCount_mm);
}

/// Transport that adds to the counts of each report that arrives complete.
class BentLine final : public UsbTransport {
 public:
  explicit BentLine(std::unique_ptr<UsbTransport> line) : line_(std::move(line)) {}
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    return line_->Control(request_type, request, value, index, data, timeout_ms);
  }
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept override {
    return line_->Write(endpoint, data, timeout_ms);
  }
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    const Transfer transfer = line_->Read(endpoint, data, timeout_ms);
    FalconPacket packet;
    if (transfer.bytes != static_cast<int>(kFtdiStatusBytes + packet.size())) return transfer;
    std::copy_n(data.begin() + kFtdiStatusBytes, packet.size(), packet.begin());
    if (std::optional<FalconReport> report = UnpackReport(packet)) {
      for (std::size_t i = 0; i < 3; ++i) report->counts[i] += added[i];
      packet = Pack(*report);
      std::copy(packet.begin(), packet.end(), data.begin() + kFtdiStatusBytes);
    }
    return transfer;
  }
  FalconCounts added{};

 private:
  std::unique_ptr<UsbTransport> line_;
};

/// Returns a position, and changes to its counts that a hand can cause in a millisecond but for which no position
/// exists.
std::pair<Vec3, FalconCounts> FindEdge() {
  constexpr int kAdded = 90;  // of the 100 that are accepted
  for (double r_mm = 0; r_mm < 120; r_mm += 1) {
    for (const Vec3& direction : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, -1}}) {
      const auto angles = CalcFalconAnglesAt(r_mm * direction);
      FalconForward forward;
      if (!angles || !CalcFalconTorques(r_mm * direction, {0, 0, 1}) || !forward.Solve(*angles)) continue;
      for (int bits = 0; bits < 8; ++bits) {
        FalconCounts added{};
        FalconCounts counts = CalcFalconCounts(*angles);
        for (std::size_t i = 0; i < 3; ++i) {
          added[i] = (bits >> i & 1) != 0 ? kAdded : -kAdded;
          counts[i] += added[i];
        }
        FalconForward bent = forward;
        if (!bent.Solve(CalcFalconAngles(counts))) return {r_mm * direction, added};
      }
    }
  }
  throw Error("no such position was found");
}

TEST(FalconDriver, ReportWithoutAPositionDoesNotInterruptTheForce) {
  const auto [edge_mm, added] = FindEdge();
  FalconBench bench;
  bench.driver.reset();
  UsbOpening opening = bench.bus.Open(bench.bus.List().at(0), kFalconInterface);
  auto line = std::make_unique<BentLine>(std::move(opening.transport));
  BentLine& bent = *line;
  bench.driver = std::make_unique<FalconDriver>(std::move(line), FalconOptions{});
  bench.Start();
  bench.MoveTo(edge_mm);
  bench.Settle();
  const Vec3 f_D_N{0, 0, 2};
  ASSERT_EQ(bench.Round(f_D_N), RoundEnd::kSample);
  const Vec3 before_mm = bench.sample.X_DH.p_AB;
  const std::array<int, 3> motors = bench.model.last_command().motors;
  ASSERT_NE(motors, (std::array<int, 3>{}));
  bent.added = added;
  EXPECT_EQ(bench.Round(f_D_N), RoundEnd::kBadAnswer);
  EXPECT_EQ(bench.Round(f_D_N), RoundEnd::kBadAnswer);
  // The force for the last valid position continues: after a round without force, the full force would return abruptly.
  EXPECT_EQ(bench.model.last_command().motors, motors);
  bent.added = {};
  EXPECT_EQ(bench.Round(f_D_N), RoundEnd::kSample);
  EXPECT_LT(glm::length(bench.sample.X_DH.p_AB - before_mm), 1e-6);
}

}  // namespace
}  // namespace kerf
