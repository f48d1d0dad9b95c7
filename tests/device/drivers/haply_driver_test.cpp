// The driver of the Inverse3, tested with a service that speaks Haply's JSON and with faulty services.
#include "device/drivers/haply_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <thread>
#include <tuple>

#include "device/drivers/haply_service.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "support/stall_detector.h"

namespace kerf {
namespace {

using test::HaplyService;
using testing::HasSubstr;
using Mood = HaplyService::Mood;

HaplyOptions MakeHaplyOptions(std::uint16_t port, int timeout_ms = 1000) {
  HaplyOptions options;
  options.port = port;
  options.timeout_ms = timeout_ms;
  options.start_timeout_ms = 2000;
  return options;
}

std::string MessageOfStart(HaplyDriver& driver) {
  return test::MessageOf([&] { driver.Start(nullptr); }, "nothing thrown");
}

/// Repeats the exchange until there is an answer, so that the tests ignore the rounds whose answers a busy machine has
/// delayed. Adds the rounds without an answer to `late`.
RoundEnd ExchangeUntilAnswered(HaplyDriver& driver, const DriverCommand& command, DriverSample& sample, int& late) {
  RoundEnd end = driver.Exchange(command, sample);
  for (int i = 0; i < 5 && end == RoundEnd::kNoAnswer; ++i) {
    ++late;
    end = driver.Exchange(command, sample);
  }
  return end;
}

RoundEnd ExchangeUntilAnswered(HaplyDriver& driver, const DriverCommand& command, DriverSample& sample) {
  int late = 0;
  return ExchangeUntilAnswered(driver, command, sample, late);
}

/// Waits until the condition is true, at most one second.
template <typename Condition>
void WaitFor(const Condition& condition) {
  for (int i = 0; i < 500 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

TEST(HaplyDriver, ReportsTheCursorPositionAndSendsTheForce) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  EXPECT_EQ(driver.profile().name, "inverse3");
  EXPECT_TRUE(driver.traits().senses_orientation);
  EXPECT_EQ(driver.traits().buttons.size(), 3u);
  DriverSample sample;
  // The start position is taken as the middle.
  ASSERT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
  EXPECT_LT(glm::length(sample.X_DH.p_AB), 1e-9);
  EXPECT_EQ(sample.buttons, 0b101u);
  // A rotation about the service's up axis is one about y of frame D.
  EXPECT_LT(glm::length(sample.X_DH.R_AB * Vec3(0, 1, 0) - Vec3(0, 1, 0)), 1e-12);
  EXPECT_NEAR(sample.X_DH.R_AB.y, 0.6, 1e-12);
  // 10 mm to the right, 20 mm away from the user, 30 mm up.
  service.Put(Vec3(0.02, -0.1, 0.23));
  DriverCommand command;
  command.f_D_N = {1, 2, 3};
  for (int i = 0; i < 3; ++i) ASSERT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample);
  EXPECT_LT(glm::length(sample.X_DH.p_AB - Vec3(10, 30, -20)), 1e-9);
  EXPECT_LT(glm::length(service.force_N() - Vec3(1, -3, 2)), 1e-12);
  driver.Stop();
  WaitFor([&] { return service.force_N() == Vec3{0}; });
  EXPECT_EQ(service.force_N(), Vec3{0});
  EXPECT_EQ(driver.Exchange({}, sample), RoundEnd::kGone);
}

TEST(HaplyDriver, EachOfAThousandRoundsHasItsOwnAnswer) {
  // A round waits at most one second; a run in which the machine stalled that long is repeated.
  for (int tries = 1;; ++tries) {
    HaplyService service;
    HaplyDriver driver(MakeHaplyOptions(service.port()));
    driver.Start(nullptr);
    const test::StallDetector awake;
    DriverSample sample;
    int samples = 0;
    for (RoundEnd end = RoundEnd::kSample; samples < 1000 && end == RoundEnd::kSample;) {
      DriverCommand command;
      command.f_D_N = {0.001 * samples, 0, 0};
      end = driver.Exchange(command, sample);
      samples += end == RoundEnd::kSample ? 1 : 0;
    }
    if (samples < 1000 && awake.Longest() > std::chrono::milliseconds(500) && tries < test::kMaxTries) continue;
    EXPECT_EQ(samples, 1000);
    EXPECT_EQ(service.forces(), 1000);
    return;
  }
}

TEST(HaplyDriver, AfterALateAnswerEachRoundReceivesItsOwnAgain) {
  HaplyService service;
  service.MoveWithForce();
  HaplyDriver driver(MakeHaplyOptions(service.port(), 200));
  driver.Start(nullptr);
  DriverSample sample;
  ASSERT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
  service.SetMood(Mood::kWithheld);
  RoundEnd end = RoundEnd::kSample;
  for (int i = 0; i < 7 && end == RoundEnd::kSample; ++i) end = driver.Exchange({}, sample);
  EXPECT_EQ(end, RoundEnd::kNoAnswer);
  const int reported = service.reported();
  service.SetMood(Mood::kGood);
  WaitFor([&] { return service.reported() > reported; });
  // Each force moves the cursor to a different place. The machine may make some answers late, but not all.
  bool own = false;
  for (int i = 1; i <= 50 && !own; ++i) {
    DriverCommand command;
    command.f_D_N = {0.1 * i, 0, 0};
    own = driver.Exchange(command, sample) == RoundEnd::kSample && std::abs(sample.X_DH.p_AB.x - 0.1 * i) < 1e-9;
  }
  EXPECT_TRUE(own);
}

TEST(HaplyDriver, BadForcesAreZeroAndLongOnesShortened) {
  HaplyService service(Mood::kGood, /*with_grip=*/false);
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  EXPECT_FALSE(driver.traits().senses_orientation);
  DriverSample sample;
  DriverCommand command;
  for (const double x : {std::nan(""), HUGE_VAL}) {
    command.f_D_N = {x, 1, 1};
    ASSERT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample);
    EXPECT_EQ(service.force_N(), Vec3{0});
  }
  command.f_D_N = {0, 3000, 4000};
  ASSERT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample);
  WaitFor([&] { return service.force_N() != Vec3{0}; });  // the last answer may have been a late one
  EXPECT_LT(glm::length(service.force_N() - Vec3(0, -8, 6)), 1e-9);
}

TEST(HaplyDriver, GarbageIsDroppedAndTheNextMessageIsRead) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  DriverSample sample;
  for (const Mood mood : {Mood::kGarbage, Mood::kStrange}) {
    int late = 0;
    service.SetMood(mood);
    ExchangeUntilAnswered(driver, {}, sample, late);
    sample.buttons = 77;
    EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample, late), RoundEnd::kBadAnswer);
    EXPECT_EQ(sample.buttons, 77u);
    service.SetMood(Mood::kGood);
    // One answer may still be in transit, in addition to the late ones.
    RoundEnd end = RoundEnd::kBadAnswer;
    for (int rounds = 0; rounds < 2 + late && end != RoundEnd::kSample; ++rounds) {
      end = driver.Exchange({}, sample);
      late += end == RoundEnd::kNoAnswer ? 1 : 0;
    }
    EXPECT_EQ(end, RoundEnd::kSample);
  }
}

TEST(HaplyDriver, SlowAndSilentServicesGiveNoAnswerUntilTheyRespond) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port(), 10));
  driver.Start(nullptr);
  DriverSample sample;
  service.SetMood(Mood::kSlow);
  int none = 0;
  int samples = 0;
  // An answer takes six times as long as a round waits; if the machine stalls, it may be available at once.
  for (int i = 0; i < 3000 && (none <= 10 || samples == 0); ++i) {
    const RoundEnd end = driver.Exchange({}, sample);
    ASSERT_NE(end, RoundEnd::kGone);
    none += end == RoundEnd::kNoAnswer ? 1 : 0;
    samples += end == RoundEnd::kSample ? 1 : 0;
  }
  EXPECT_GT(none, 10);
  EXPECT_GT(samples, 0);
}

// Runs until the sockets' buffers are full; from then on forces cannot be sent, whatever the service reports.
TEST(HaplyDriver, ServiceThatSendsButDoesNotReadGivesNoAnswer) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  service.SetMood(Mood::kDeaf);
  DriverCommand command;
  command.f_D_N = {0.5, 0, 0};
  DriverSample sample;
  const auto give_up_at = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  int in_a_row = 0;
  while (in_a_row < 20 && std::chrono::steady_clock::now() < give_up_at) {
    in_a_row = driver.Exchange(command, sample) == RoundEnd::kNoAnswer ? in_a_row + 1 : 0;
  }
  EXPECT_EQ(in_a_row, 20);
  EXPECT_GT(service.reported(), 20);
}

TEST(HaplyDriver, ReportsAClosedConnectionAndReconnects) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  DriverSample sample;
  service.SetMood(Mood::kClosing);
  RoundEnd end = ExchangeUntilAnswered(driver, {}, sample);
  for (int i = 0; i < 5 && end == RoundEnd::kSample; ++i) end = ExchangeUntilAnswered(driver, {}, sample);
  EXPECT_EQ(end, RoundEnd::kGone);
  EXPECT_EQ(driver.Exchange({}, sample), RoundEnd::kGone);
  service.SetMood(Mood::kGood);
  driver.Start(nullptr);
  EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
}

TEST(HaplyDriver, ADeviceThatLeavesTheListIsGone) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  DriverSample sample;
  service.SetMood(Mood::kNoDevice);
  RoundEnd end = RoundEnd::kSample;
  int rounds = 0;
  for (; rounds < 500 && end != RoundEnd::kGone; ++rounds) end = driver.Exchange({}, sample);
  EXPECT_EQ(end, RoundEnd::kGone);
  EXPECT_GE(rounds, HaplyDriver::kMaxMissing);
}

TEST(HaplyDriver, StartReportsWhatIsWrong) {
  std::uint16_t free_port = 0;
  {
    HaplyService service;
    free_port = service.port();
  }
  HaplyDriver no_reader(MakeHaplyOptions(free_port));
  EXPECT_THAT(MessageOfStart(no_reader), HasSubstr("no Haply service is listening at ws://127.0.0.1:"));
  // Most of these failures take the full timeout; after a stall of the machine, a longer timeout is tried.
  const auto message_in = [](Mood mood, const std::string& wanted, const std::string& id = "") {
    std::string message;
    for (const int timeout_ms : {200, 2000, 20'000}) {
      HaplyService service(mood);
      HaplyOptions options = MakeHaplyOptions(service.port());
      options.start_timeout_ms = timeout_ms;
      options.device_id = id;
      HaplyDriver driver(options);
      message = MessageOfStart(driver);
      if (message.find(wanted) != std::string::npos) break;
    }
    return message;
  };
  for (const auto& [mood, id, wanted] :
       {std::tuple{Mood::kNoDevice, "", "lists no Inverse3; plug it in"},
        std::tuple{Mood::kGood, "FFFF", "no Inverse3 with the id FFFF"},
        std::tuple{Mood::kSilent, "", "does not answer"}, std::tuple{Mood::kGarbage, "", "does not speak the JSON"},
        std::tuple{Mood::kShortHello, "", "nothing thrown"}}) {
    EXPECT_THAT(message_in(mood, wanted, id), HasSubstr(wanted));
  }
}

TEST(HaplyDriver, ConnectsToThisMachineOnly) {
  HaplyOptions options;
  options.address = "192.0.2.1";
  EXPECT_THROW(HaplyDriver{options}, Error);
  options = {};
  options.timeout_ms = 0;
  EXPECT_THROW(HaplyDriver{options}, Error);
}

TEST(HaplyDriver, LostGripGivesNoAnswerAndKeepsTheOrientation) {
  HaplyService service;
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  DriverSample sample;
  ASSERT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
  const Quat before = sample.X_DH.R_AB;
  ASSERT_GT(std::abs(before.y), 0.5);
  service.SetMood(Mood::kNoGrip);
  driver.Exchange({}, sample);  // one state may still be in transit
  for (int i = 0; i < 2 * HaplyDriver::kMaxMissing; ++i) {
    ASSERT_EQ(driver.Exchange({}, sample), RoundEnd::kNoAnswer) << i;
    ASSERT_EQ(sample.X_DH.R_AB, before);
  }
  service.SetMood(Mood::kGood);
  driver.Exchange({}, sample);
  EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
  EXPECT_EQ(sample.X_DH.R_AB, before);
}

TEST(HaplyDriver, StartsAndRunsWithoutAGrip) {
  HaplyService service(Mood::kGood, /*with_grip=*/false);
  HaplyDriver driver(MakeHaplyOptions(service.port()));
  driver.Start(nullptr);
  DriverSample sample;
  EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
  EXPECT_EQ(sample.X_DH.R_AB, Quat(1, 0, 0, 0));
}

}  // namespace
}  // namespace kerf
