// The WoodenHaptics driver: its kinematics compared with closed forms, and the driver with a model of the device and
// with faulty cables.
#include "device/devices/hid/wooden_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <random>

#include "base/core/heap_guard.h"
#include "device/devices/hid/hid_report.h"
#include "device/emulation/direct_line.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

/// Returns the aluminium version of 2017; at zero, its upper arm is level and its forearm hangs down.
WoodenParams MakeAluminium() {
  WoodenParams params;
  params.base_mm = 111;
  params.upper_arm_mm = 140;
  params.forearm_mm = 111;
  params.middle_mm = {140, 0, 0};
  params.counts_per_turn = {2000, 2000, 2000};
  params.gear = {116 / 13.8, -76 / 9.8, 76 / 9.8};
  params.zero_deg = {0, 90, 0};
  return params;
}

/// Computes the position with rigid transforms, joint by joint, in the makers' axes, and converts it to frame D.
Vec3 CalcByTransforms(const WoodenParams& params, const Vec3& angles) {
  glm::dmat4 X(1.0);
  X = glm::rotate(X, angles.x, glm::dvec3(0, 0, 1));
  X = glm::translate(X, glm::dvec3(0, 0, params.base_mm));
  X = glm::rotate(X, angles.y, glm::dvec3(0, 1, 0));  // from upright towards the user
  X = glm::translate(X, glm::dvec3(0, 0, params.upper_arm_mm));
  X = glm::rotate(X, -angles.y, glm::dvec3(0, 1, 0));  // parallelogram: the forearm's angle is relative to the world
  X = glm::rotate(X, -angles.z, glm::dvec3(0, 1, 0));
  const glm::dvec4 tip = X * glm::dvec4(0, 0, -params.forearm_mm, 1);
  const Vec3 p = Vec3(tip) - params.middle_mm;
  return {p.y, p.z, p.x};
}

Vec3 DrawAngles(std::mt19937_64& random) {
  std::uniform_real_distribution<double> draw(-1, 1);
  return {1.2 * draw(random), 0.8 + 0.7 * draw(random), 0.9 + 0.7 * draw(random)};
}

double CalcDistance(const Vec3& a, const Vec3& b) {
  return glm::length(a - b);
}

TEST(WoodenKinematics, ZeroPosesAreThoseOfTheMakers) {
  // The wooden version has its upper arm upright and its forearm level towards the user: 245 mm out and 80 + 205 mm up,
  // minus the middle.
  const WoodenParams wood;
  EXPECT_LT(CalcDistance(CalcWoodenPosition(wood, CalcWoodenAngles(wood, {})), {0, 205, 25}), 1e-9);
  // The zero pose of the aluminium version is exactly the middle of its workspace.
  const WoodenParams aluminium = MakeAluminium();
  EXPECT_LT(CalcDistance(CalcWoodenPosition(aluminium, CalcWoodenAngles(aluminium, {})), Vec3{0}), 1e-9);
}

TEST(WoodenKinematics, PositionEqualsAChainOfTransforms) {
  std::mt19937_64 random(1);
  for (const WoodenParams& params : {WoodenParams{}, MakeAluminium()}) {
    for (int i = 0; i < 10'000; ++i) {
      const Vec3 angles = DrawAngles(random);
      // Lengths are up to 1e3 mm, with a relative error of 1e-16.
      ASSERT_LT(CalcDistance(CalcWoodenPosition(params, angles), CalcByTransforms(params, angles)), 1e-10);
    }
  }
}

TEST(WoodenKinematics, JacobianIsTheSlopeOfThePosition) {
  std::mt19937_64 random(2);
  const WoodenParams params;
  constexpr double kStep = 1e-5;  // central differences: error about 450 mm step^2 / 6 + 1e-13 mm / step
  for (int i = 0; i < 1000; ++i) {
    const Vec3 angles = DrawAngles(random);
    const auto columns = CalcWoodenJacobian(params, angles);
    for (int joint = 0; joint < 3; ++joint) {
      Vec3 step{0};
      step[joint] = kStep;
      const Vec3 slope =
          (CalcWoodenPosition(params, angles + step) - CalcWoodenPosition(params, angles - step)) / (2 * kStep);
      ASSERT_LT(CalcDistance(columns[static_cast<std::size_t>(joint)], slope), 1e-6);
    }
  }
}

TEST(WoodenKinematics, AnglesAreRecoveredOverTheWorkspace) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const WoodenParams& params : {WoodenParams{}, MakeAluminium()}) {
    int reached = 0;
    for (int i = 0; i < 100'000; ++i) {
      const Vec3 p_D_mm = params.workspace_radius_mm / 2 * Vec3(normal(random), normal(random), normal(random));
      const auto angles = FindWoodenAngles(params, p_D_mm);
      if (!angles) continue;
      ++reached;
      ASSERT_LT(CalcDistance(CalcWoodenPosition(params, *angles), p_D_mm), 1e-6);  // 1e-9 m
    }
    EXPECT_GT(reached, 60'000);
  }
}

TEST(WoodenKinematics, MotorPowerEqualsHandlePower) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  const WoodenParams params;
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 angles = DrawAngles(random);
    const Vec3 rates(normal(random), normal(random), normal(random));
    const Vec3 f_D_N = 0.5 * Vec3(normal(random), normal(random), normal(random));
    const Vec3 mA = CalcWoodenCurrents(params, angles, f_D_N);
    const auto columns = CalcWoodenJacobian(params, angles);
    const Vec3 v = columns[0] * rates.x + columns[1] * rates.y + columns[2] * rates.z;
    double motors = 0;  // N mm/s: sum of each motor's torque times its speed
    for (int j = 0; j < 3; ++j) motors += 1e-3 * mA[j] * params.motor_Nmm_per_A[j] * params.gear[j] * rates[j];
    ASSERT_NEAR(motors, glm::dot(f_D_N, v), 1e-9 * (1 + glm::length(v)));
  }
}

TEST(WoodenKinematics, LimitedCurrentsKeepTheDirection) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const WoodenParams params;
  int limited = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 angles = DrawAngles(random);
    const Vec3 f_D_N = 40.0 * Vec3(normal(random), normal(random), normal(random));
    const Vec3 mA = CalcWoodenCurrents(params, angles, f_D_N);
    for (int j = 0; j < 3; ++j) ASSERT_LE(std::abs(mA[j]), 3000 * (1 + 1e-12));
    const Vec3 made = CalcWoodenForce(params, angles, mA);
    if (glm::length(made) == 0) continue;  // almost fully extended
    limited += glm::length(made) < 0.999 * glm::length(f_D_N) ? 1 : 0;
    const Vec3 unit = glm::normalize(f_D_N);
    const double fraction = glm::dot(made, unit) / glm::length(made);
    ASSERT_NEAR(fraction, 1, 1e-6);
    ASSERT_LE(glm::length(made), glm::length(f_D_N) * (1 + 1e-9));
  }
  EXPECT_GT(limited, 1000);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(CalcWoodenCurrents(params, {0, 0.5, 1}, {bad, 0, 0}), Vec3{0});
  }
}

TEST(WoodenReports, AreReadAsTheyAreWritten) {
  std::mt19937_64 random(6);
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    std::array<std::uint8_t, 12> bytes{};
    const std::uint64_t draw = random();
    for (std::size_t b = 0; b < 8; ++b) bytes[b] = static_cast<std::uint8_t>(draw >> (8 * b));
    const std::size_t length = i % 4 == 0 ? random() % 13 : 8;
    WoodenReport report;
    ASSERT_EQ(ReadWoodenReport(std::span(bytes).first(length), report), length == 8);
    if (length != 8) continue;
    std::array<std::uint8_t, 8> again{};
    WriteWoodenReport(report, again);
    ASSERT_TRUE(std::equal(again.begin(), again.end(), bytes.begin()));
  }
  std::array<std::uint8_t, 8> bytes{};
  WriteWoodenCurrents({1234, -2999.6, std::nan("")}, bytes);
  EXPECT_EQ(ReadWoodenCurrents(bytes), Vec3(1234, -3000, 0));
}

TEST(WoodenReports, FewDamagedReportsAreAccepted) {
  std::mt19937_64 random(7);
  WoodenReportFilter filter(Vec3{32000, -32000, 32000});
  WoodenReport truth;
  int sent = 0;
  int good = 0;
  int wrong = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    ++truth.counter;
    for (std::int16_t& count : truth.counts) count = static_cast<std::int16_t>(count + random() % 41 - 20);
    if (random() % 50 == 0) continue;  // the report is lost
    WoodenReport seen = truth;
    const bool flipped = random() % 100 == 0;
    const int bit = static_cast<int>(random() % 16);
    if (flipped) seen.counts[random() % 3] ^= static_cast<std::int16_t>(1 << bit);
    if (random() % 100 == 0) seen.counter ^= static_cast<std::uint16_t>(1 << random() % 16);
    ++sent;
    const bool taken = filter.Judge(seen) == WoodenReportFilter::Verdict::kNew;
    good += taken && !flipped ? 1 : 0;
    // A flip of one of the 8 upper bits is 256 counts or more: impossible for a hand, unless earlier reports were lost.
    wrong += taken && flipped && bit >= 8 ? 1 : 0;
  }
  // 2 of 100 reports are damaged, and each of these may also cost the next one.
  EXPECT_GT(good, 0.95 * sent);
  // 1 of 200 is flipped so. After one loss, a jump of 320 counts is accepted, and after a flipped counter more, so a
  // few percent are wrong.
  EXPECT_LT(wrong, 0.05 * cases / 200);
}

// The limit is 31 rad/s for any encoder; a larger motion in one millisecond is rejected at first.
TEST(WoodenReports, SpeedLimitIsTheSameForAnyEncoder) {
  using Verdict = WoodenReportFilter::Verdict;
  const Vec3 counts_per_turn{32000, 1000, -65534};
  const std::array<std::int16_t, 3> largest{160, 5, 328};
  for (std::size_t joint = 0; joint < largest.size(); ++joint) {
    for (const int sign : {1, -1}) {
      for (const int beyond : {0, 1}) {
        WoodenReportFilter filter(counts_per_turn);
        WoodenReport report;
        EXPECT_EQ(filter.Judge(report), Verdict::kNew);
        report.counts[joint] = static_cast<std::int16_t>(sign * (largest[joint] + beyond));
        ++report.counter;
        EXPECT_EQ(filter.Judge(report), beyond == 0 ? Verdict::kNew : Verdict::kBad) << joint;
      }
    }
  }
}

TEST(WoodenDriver, RefusesEncodersWhoseCountsWrapAroundWithinATurn) {
  WoodenParams params;
  params.counts_per_turn.y = 20000;
  params.gear.y = 16;
  EXPECT_THAT(test::MessageOf([&] { const WoodenDriver driver(nullptr, params); }),
              testing::HasSubstr("is 320000 for a joint; it must be at most 65534"));
}

TEST(WoodenReports, DuplicateAndOldReportsAreIgnored) {
  using Verdict = WoodenReportFilter::Verdict;
  WoodenReportFilter filter(Vec3{32000, -32000, 32000});
  EXPECT_EQ(filter.Judge({{0, 0, 0}, 65534}), Verdict::kNew);
  EXPECT_EQ(filter.Judge({{1, 0, 0}, 65534}), Verdict::kOld);
  EXPECT_EQ(filter.Judge({{1, 0, 0}, 65535}), Verdict::kNew);
  EXPECT_EQ(filter.Judge({{2, 0, 0}, 3}), Verdict::kNew);     // wrapped around; 0, 1 and 2 were lost
  EXPECT_EQ(filter.Judge({{2, 0, 0}, 1}), Verdict::kBad);     // an earlier report
  EXPECT_EQ(filter.Judge({{9000, 0, 0}, 4}), Verdict::kBad);  // a jump
  EXPECT_EQ(filter.Judge({{3, 0, 0}, 4}), Verdict::kNew);     // the jump was damage
  EXPECT_EQ(filter.Judge({{9000, 0, 0}, 5}), Verdict::kBad);  // a jump again
  EXPECT_EQ(filter.Judge({{9001, 0, 0}, 6}), Verdict::kNew);  // a jump that is repeated
}

struct WoodenRig {
  explicit WoodenRig(const WoodenParams& params = {}) : model(hand, params) {
    bus.PlugIn(model);
    bus.Advance(0.001);
  }
  std::unique_ptr<WoodenDriver> Open(const WoodenParams& params = {}) {
    UsbOpening opening = bus.Open(bus.List().at(0), 0);
    return std::make_unique<WoodenDriver>(std::move(opening.transport), params);
  }

  PrescribedMechanism hand;
  WoodenModel model;
  ModelBus bus;
};

TEST(WoodenDriver, ReportsTheHandlePositionAndOutputsTheForce) {
  WoodenRig setup;
  const auto driver = setup.Open();
  driver->Start(nullptr);
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> draw(-1, 1);
  Vec3 step{0};
  for (int i = 0; i < 5000; ++i) {
    if (i % 500 == 0) step = 0.3 * Vec3(draw(random), draw(random), draw(random));
    Vec3& p = setup.hand.X_DH.p_AB;
    p += step;
    if (glm::length(p) > 60) step = -glm::normalize(p) * 0.3;
    DriverCommand command;
    command.f_D_N = 2.0 * Vec3(std::sin(0.01 * i), std::cos(0.013 * i), std::sin(0.007 * i));
    DriverSample sample;
    ASSERT_EQ(driver->Exchange(command, sample), RoundEnd::kSample) << i;
    // Half a count on each joint, with an arm of at most 245 mm: each contributes at most 0.5 * 245 * 2 pi / 24000 mm.
    ASSERT_LT(CalcDistance(sample.X_DH.p_AB, p), 0.1) << i;
    // The lever arm is that of a few rounds ago: 0.6 mm / 100 mm * 3.5 N = 0.02 N. Currents are integers in mA:
    // 0.5 mA * 25.9 N mm/A * 16 / 100 mm = 2e-3 N.
    ASSERT_LT(CalcDistance(setup.hand.f_D_N(), command.f_D_N), 0.05) << i;
  }
  driver->Stop();
  EXPECT_EQ(setup.model.currents_mA(), Vec3{0});
}

TEST(WoodenDriver, RoundsAllocateNothing) {
  PrescribedMechanism hand;
  WoodenModel model(hand);
  WoodenDriver driver(std::make_unique<test::DirectLine>(model), {});
  driver.Start(nullptr);
  DriverCommand command;
  command.f_D_N = {1, 20, 3};
  for (int i = 0; i < 1000; ++i) {
    DriverSample sample;
    RoundEnd end;
    {
      HeapGuard guard;
      end = driver.Exchange(command, sample);
    }
    ASSERT_EQ(end, RoundEnd::kSample);
  }
}

TEST(WoodenDriver, FirmwareSwitchesTheMotorsOffWhenTheHostIsSilent) {
  WoodenRig setup;
  const auto driver = setup.Open();
  driver->Start(nullptr);
  DriverSample sample;
  DriverCommand command;
  command.f_D_N = {0, 3, 0};
  driver->Exchange(command, sample);
  driver->Exchange(command, sample);
  setup.bus.Advance(0.4);
  EXPECT_GT(glm::length(setup.hand.f_D_N()), 2.9);
  setup.bus.Advance(0.15);
  EXPECT_EQ(setup.hand.f_D_N(), Vec3{0});
  EXPECT_FALSE(setup.model.motors_on());
}

TEST(WoodenDriver, BadCommandsGiveNoForceOrAReducedOne) {
  WoodenRig setup;
  const auto driver = setup.Open();
  driver->Start(nullptr);
  DriverSample sample;
  DriverCommand command;
  command.f_D_N = {std::nan(""), 0, 1};
  driver->Exchange(command, sample);
  EXPECT_EQ(setup.model.currents_mA(), Vec3{0});
  command.f_D_N = {0, 0, 1000};
  driver->Exchange(command, sample);
  driver->Exchange(command, sample);
  EXPECT_LE(glm::length(setup.hand.f_D_N()), 5.01);
  EXPECT_GT(setup.hand.f_D_N().z, 4.8);  // the force that 3 A make there
}

TEST(WoodenDriver, ToleratesAllCableFaults) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    WoodenRig setup;
    const auto driver = setup.Open();
    driver->Start(nullptr);
    UsbFaults faults;
    faults.seed = seed;
    faults.drop_out = 0.05;
    faults.drop_in = 0.05;
    faults.duplicate = 0.05;
    faults.truncate = 0.05;
    faults.corrupt = 0.02;
    faults.delay = 0.05;
    setup.bus.SetFaults(faults);
    int samples = 0;
    for (int i = 0; i < 2000; ++i) {
      DriverCommand command;
      command.f_D_N = {1, 0, 0};
      DriverSample sample;
      const RoundEnd end = driver->Exchange(command, sample);
      ASSERT_NE(end, RoundEnd::kGone);
      if (end != RoundEnd::kSample) continue;
      ++samples;
      ASSERT_TRUE(IsValid(sample.X_DH));
      // A damaged byte may look like a fast hand, so the error is at most the motion of a hand since the last report.
      ASSERT_LT(glm::length(sample.X_DH.p_AB), 250) << "seed " << seed << " round " << i;
      for (int j = 0; j < 3; ++j) ASSERT_LE(std::abs(setup.model.currents_mA()[j]), 3000);
    }
    EXPECT_GT(samples, 1300) << seed;
    faults = {};
    setup.bus.SetFaults(faults);
    for (int i = 0; i < 10; ++i) {
      DriverSample sample;
      driver->Exchange({}, sample);
    }
    DriverSample sample;
    EXPECT_EQ(driver->Exchange({}, sample), RoundEnd::kSample);
    EXPECT_LT(glm::length(sample.X_DH.p_AB), 0.1);
  }
}

TEST(WoodenDriver, ReportsAGoneOrSilentDevice) {
  WoodenRig setup;
  const auto driver = setup.Open();
  driver->Start(nullptr);
  UsbFaults faults;
  faults.stalled = true;
  setup.bus.SetFaults(faults);
  DriverSample sample;
  sample.buttons = 77;
  EXPECT_EQ(driver->Exchange({}, sample), RoundEnd::kNoAnswer);
  EXPECT_EQ(sample.buttons, 77u);
  faults = {};
  faults.unplugged = true;
  setup.bus.SetFaults(faults);
  EXPECT_EQ(driver->Exchange({}, sample), RoundEnd::kGone);
  driver->Stop();
  setup.bus.PlugInAgain();
  const auto again = setup.Open();
  again->Start(nullptr);
  EXPECT_EQ(again->Exchange({}, sample), RoundEnd::kSample);
}

/// A gadget with mbed's ids and reports of 32 bytes.
class OtherGadget final : public UsbModel {
 public:
  OtherGadget() {
    face_.vendor = kWoodenVendor;
    face_.product = kWoodenProduct;
    face_.report_descriptor = {0x06, 0xab, 0xff, 0xa1, 0x01, 0x75, 8, 0x95, 32, 0x81, 0x02, 0x91, 0x02, 0xc0};
  }
  std::vector<std::uint8_t> descriptors() const override { return MakeHidDescriptors(face_); }
  void Advance(double /*dt_s*/) override {}
  Transfer Control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t /*index*/,
                   std::span<std::uint8_t> data) override {
    return AnswerHidRequest(face_, type, request, value, data);
  }
  Transfer Write(std::uint8_t /*endpoint*/, std::span<const std::uint8_t> data) override {
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Read(std::uint8_t /*endpoint*/, std::span<std::uint8_t> /*data*/) override {
    return {TransferEnd::kTimeout, 0};
  }
  void PowerOn() override {}

 private:
  HidFace face_;
};

std::string MessageOfStart(DeviceDriver& driver) {
  return test::MessageOf([&] { driver.Start(nullptr); }, "nothing thrown");
}

TEST(WoodenDriver, RefusesOtherGadgetsWithTheSameId) {
  OtherGadget gadget;
  ModelBus bus;
  bus.PlugIn(gadget);
  WoodenDriver driver(bus.Open(bus.List().at(0), 0).transport, {});
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("not a WoodenHaptics device"));
}

TEST(WoodenDriver, ReportsThatNoReportsArrive) {
  WoodenRig setup;
  UsbFaults faults;
  faults.stalled = true;
  setup.bus.SetFaults(faults);
  const auto driver = setup.Open();
  EXPECT_THAT(MessageOfStart(*driver), HasSubstr("sends no reports"));
}

TEST(WoodenDriver, RefusesImpossibleArms) {
  WoodenRig setup;
  WoodenParams params;
  params.gear.y = 0;
  EXPECT_THROW(setup.Open(params), Error);
  params = {};
  params.counts_per_turn.z = 0;
  EXPECT_THROW(setup.Open(params), Error);
  params = {};
  params.middle_mm = {900, 0, 0};
  EXPECT_THROW(setup.Open(params), Error);
}

TEST(WoodenDriver, UsesThePoseAtTheStartAsZeroIfRequested) {
  // The device was plugged in while in an arbitrary pose, so the model's own zero is off by 10 degrees on each joint.
  WoodenParams device;
  device.zero_deg += Vec3(10, -10, 10);
  WoodenRig setup(device);
  WoodenParams params;
  params.zero_at_start = true;
  const Vec3 zero = CalcWoodenPosition(params, kDegree * params.zero_deg);
  setup.hand.X_DH.p_AB = zero;
  setup.bus.Advance(0.002);
  setup.bus.Advance(0.002);
  const auto driver = setup.Open(params);
  driver->Start(nullptr);
  EXPECT_THAT(driver->traits().homing,
              HasSubstr("or when the session began; otherwise unplug it, hold it in that pose, and plug it in"));
  DriverSample sample;
  ASSERT_EQ(driver->Exchange({}, sample), RoundEnd::kSample);
  EXPECT_LT(CalcDistance(sample.X_DH.p_AB, zero), 0.1);
}

TEST(HidReports, SizesAreSummedForEachId) {
  const std::vector<std::uint8_t> two = {0x85, 1, 0x75, 16, 0x95, 3, 0x81, 2, 0x85, 2,
                                         0x95, 6, 0x81, 2,  0x75, 1, 0x95, 3, 0x91, 2};
  const auto sizes = ReadHidReportSizes(two);
  ASSERT_TRUE(sizes);
  EXPECT_EQ(sizes->input_bytes, 12);
  EXPECT_EQ(sizes->output_bytes, 1);
  EXPECT_TRUE(sizes->has_ids);
}

TEST(HidReports, AnyBytesAreAcceptedOrRefused) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 100'000; ++i) {
    std::vector<std::uint8_t> bytes(random() % 64);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const auto sizes = ReadHidReportSizes(bytes);
    ASSERT_TRUE(!sizes || sizes->input_bytes >= 0);
  }
}

}  // namespace
}  // namespace kerf
