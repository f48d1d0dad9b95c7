// The bridge's driver, tested with the example client in a separate process and with faulty bridges.
#include "device/drivers/bridge_driver.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <deque>
#include <functional>
#include <glm/geometric.hpp>
#include <random>
#include <thread>

#include "base/core/heap_guard.h"
#include "device/devices/servo_round.h"
#include "device/drivers/child_process.h"
#include "kerf/error.h"
#include "kerf_bridge.h"
#include "support/message_of.h"
#include "support/stall_detector.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ChildProcess;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

using Packets = std::vector<std::vector<std::uint8_t>>;

std::uint16_t PortOf(ChildProcess& example) {
  const std::string line = example.ReadLine();
  return static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1)));
}

/// Returns options with long waits, so that a busy machine does not count as a fault.
BridgeOptions MakeOptions(std::uint16_t port) {
  BridgeOptions options;
  options.port = port;
  options.timeout_ms = 500;
  return options;
}

std::string MessageOfStart(BridgeDriver& driver) {
  return test::MessageOf([&] { driver.Start(nullptr); }, "nothing thrown");
}

/// Repeats the exchange until there is an answer, so that the tests ignore the rounds whose answers a busy machine has
/// delayed.
RoundEnd ExchangeUntilAnswered(BridgeDriver& driver, const DriverCommand& command, DriverSample& sample) {
  RoundEnd end = RoundEnd::kNoAnswer;
  for (int i = 0; i < 100 && end == RoundEnd::kNoAnswer; ++i) {
    const HeapGuard guard;
    end = driver.Exchange(command, sample);
  }
  return end;
}

/// A socket on loopback whose answers the test defines; an empty answer sends nothing.
class Answerer {
 public:
  using Answer = std::function<Packets(std::span<const std::uint8_t>)>;

  explicit Answerer(Answer answer) : answer_(std::move(answer)) {
    socket_ = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) throw std::runtime_error("no socket");
    socklen_t size = sizeof at;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size);
    port_ = ntohs(at.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~Answerer() {
    stop_ = true;
    thread_.join();
    close(socket_);
  }
  Answerer(const Answerer&) = delete;
  Answerer& operator=(const Answerer&) = delete;

  std::uint16_t port() const { return port_; }

 private:
  void Serve() {
    while (!stop_) {
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      if (poll(&waiting, 1, 5) <= 0) continue;
      std::array<std::uint8_t, 512> bytes{};
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t got = recvfrom(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) continue;
      for (const auto& reply : answer_(std::span<const std::uint8_t>(bytes).first(static_cast<std::size_t>(got)))) {
        sendto(socket_, reply.data(), reply.size(), 0, reinterpret_cast<const sockaddr*>(&from), size);
      }
    }
  }

  Answer answer_;
  int socket_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::vector<std::uint8_t> ToVector(const BridgeBytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Answers as a good bridge would; written in C++.
class GoodBridge {
 public:
  std::vector<std::uint8_t> Answer(std::span<const std::uint8_t> bytes) {
    const auto heard = ReadBridgeHeader(bytes);
    if (!heard) return {};
    BridgeHeader header;
    header.session = heard->session;
    header.sequence = ++sequence;
    header.answer_to = heard->sequence;
    if (heard->kind == BridgeKind::kHello) {
      BridgeDescription description;
      description.name = "made up";
      description.peak_force_N = 5;
      return ToVector(WriteBridgeDescription(header, description));
    }
    if (heard->kind != BridgeKind::kCommand) return {};
    BridgeState state;
    state.X_DH.p_AB = {1, 2, 3};
    state.homed = true;
    state.ready = true;
    return ToVector(WriteBridgeState(header, state));
  }
  std::uint32_t sequence = 0;
};

TEST(BridgeDriver, MovesTheExamplesMass) {
  ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
  BridgeDriver driver(MakeOptions(PortOf(example)));
  driver.Start(nullptr);
  EXPECT_EQ(driver.profile().name, "example");
  EXPECT_FLOAT_EQ(float(driver.profile().peak_force_N), 3.3f);
  EXPECT_EQ(driver.traits().buttons.size(), 2u);
  DriverSample sample;
  DriverCommand command;
  // The hand's spring of 0.2 N/mm yields 5 mm to a force of 1 N along z; the hand's intended position is 0.
  command.f_D_N = {0, 0, 1};
  double z_mm = 0;
  // If the machine stalls between two rounds, the bridge outputs no force for a moment. If it stalls within a round,
  // the bridge's measured state is too old to be ready.
  const auto off_N = [&] { return glm::length(driver.actual_f_D_N() - Vec3(0, 0, 1)); };
  for (int i = 0; i < 1'000'000 && (!sample.homed || std::abs(z_mm - 5) > 0.1 || off_N() > 1e-6); ++i) {
    ASSERT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample);
    z_mm = sample.X_DH.p_AB.z;
  }
  EXPECT_TRUE(sample.homed);
  EXPECT_NEAR(z_mm, 5, 0.1);
  EXPECT_LT(off_N(), 1e-6);
  // The force for a command above the device's peak is limited to the peak.
  command.f_D_N = {0, 0, 100};
  driver.Exchange(command, sample);
  for (int i = 0; i < 1000 && driver.actual_f_D_N().z < 3.2; ++i) driver.Exchange(command, sample);
  EXPECT_NEAR(glm::length(driver.actual_f_D_N()), 3.3, 1e-5);
  EXPECT_EQ(driver.bad_packets(), 0u);
  // After a regular end, the same program can begin a second session.
  driver.Stop();
  EXPECT_EQ(driver.Exchange(command, sample), RoundEnd::kGone);
  driver.Start(nullptr);
  EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
}

TEST(BridgeDriver, BridgeComputesTheForceField) {
  ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
  BridgeOptions options = MakeOptions(PortOf(example));
  options.valid_ms = 1000;
  BridgeDriver driver(options);
  driver.Start(nullptr);
  // A wall at z = 2 mm pushes with 1 N there and has 0.3 N/mm; the hand's spring of 0.2 N/mm pulls to 0. At rest,
  // 1 - 0.3 (z - 2) = 0.2 z, so z = 3.2 mm, a position that no command contains.
  DriverCommand command;
  command.f_D_N = {0, 0, 1};
  command.p_D_mm = {0, 0, 2};
  command.stiffness_N_per_mm = 0.3;
  command.damping_Ns_per_mm = 0.003;
  DriverSample sample;
  double z_mm = 0;
  double force_N = 0;
  for (int i = 0; i < 1'000'000 && !(i > 500 && std::abs(z_mm - 3.2) < 0.05 && std::abs(force_N - 0.64) < 0.05); ++i) {
    ASSERT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample);
    z_mm = sample.X_DH.p_AB.z;
    force_N = driver.actual_f_D_N().z;
  }
  EXPECT_NEAR(z_mm, 3.2, 0.05);
  EXPECT_NEAR(force_N, 0.64, 0.05);
}

TEST(BridgeDriver, ReportsAKilledBridgeAndReconnects) {
  auto example = std::make_unique<ChildProcess>(std::vector<std::string>{KERF_BRIDGE_EXAMPLE, "0"});
  const std::uint16_t port = PortOf(*example);
  BridgeOptions options = MakeOptions(port);
  options.timeout_ms = 50;
  BridgeDriver driver(options);
  driver.Start(nullptr);
  DriverSample sample;
  for (int i = 0; i < 100; ++i) driver.Exchange({}, sample);
  example->End(SIGKILL);
  sample.buttons = 77;
  RoundEnd end = driver.Exchange({}, sample);
  for (int i = 0; i < 5 && end == RoundEnd::kNoAnswer; ++i) end = driver.Exchange({}, sample);
  EXPECT_EQ(end, RoundEnd::kGone);
  EXPECT_EQ(sample.buttons, 77u);
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("no bridge program is listening at 127.0.0.1:"));
  example = std::make_unique<ChildProcess>(std::vector<std::string>{KERF_BRIDGE_EXAMPLE, std::to_string(port)});
  example->ReadLine();
  driver.Start(nullptr);
  EXPECT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
}

TEST(BridgeDriver, ABridgeThatIsStoppedGivesNoAnswerAndGoesOn) {
  ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
  BridgeOptions options = MakeOptions(PortOf(example));
  options.timeout_ms = 20;
  BridgeDriver driver(options);
  driver.Start(nullptr);
  DriverSample sample;
  example.Signal(SIGSTOP);
  // One answer may still be in transit.
  driver.Exchange({}, sample);
  EXPECT_EQ(driver.Exchange({}, sample), RoundEnd::kNoAnswer);
  example.Signal(SIGCONT);
  int samples = 0;
  for (int i = 0; i < 500 && samples < 10; ++i) samples += driver.Exchange({}, sample) == RoundEnd::kSample ? 1 : 0;
  EXPECT_EQ(samples, 10);
}

TEST(BridgeDriver, IsRefusedWhileAnotherProgramUsesTheDevice) {
  // A program that sends nothing for two seconds loses the device.
  test::RetryIfStalled(std::chrono::milliseconds(1000), [](test::LongestGap& /*own*/) {
    ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
    const std::uint16_t port = PortOf(example);
    BridgeDriver first(MakeOptions(port));
    first.Start(nullptr);
    BridgeDriver second(MakeOptions(port));
    DriverSample sample;
    first.Exchange({}, sample);
    EXPECT_THAT(MessageOfStart(second), HasSubstr("is in use by another program"));
    EXPECT_EQ(ExchangeUntilAnswered(first, {}, sample), RoundEnd::kSample);
    first.Stop();
    EXPECT_EQ(MessageOfStart(second), "nothing thrown");
  });
}

TEST(BridgeDriver, IgnoresPacketsFromOtherSenders) {
  ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
  const std::uint16_t port = PortOf(example);
  BridgeDriver driver(MakeOptions(port));
  driver.Start(nullptr);
  // A third socket sends garbage, and packets that look valid, to the bridge and to all ports where kerf may listen.
  std::atomic<bool> stop{false};
  std::thread noise([&] {
    std::mt19937_64 random(1);
    const int s = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    while (!stop) {
      std::array<std::uint8_t, 200> bytes{};
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
      to.sin_port = htons(random() % 2 == 0 ? port : static_cast<std::uint16_t>(32768 + random() % 28000));
      sendto(s, bytes.data(), random() % bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
      BridgeCommand push;
      push.f_D_N = {3, 0, 0};
      push.engaged = true;
      const BridgeBytes whole = WriteBridgeCommand({}, push);
      sendto(s, whole.data(), whole.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
      usleep(200);
    }
    close(s);
  });
  DriverSample sample;
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_EQ(ExchangeUntilAnswered(driver, {}, sample), RoundEnd::kSample);
    ASSERT_EQ(driver.actual_f_D_N(), Vec3{0});
  }
  stop = true;
  noise.join();
  EXPECT_EQ(driver.bad_packets(), 0u);
}

TEST(BridgeDriver, ReportsTheVersionOfTheBridge) {
  Answerer other([](std::span<const std::uint8_t> bytes) {
    BridgeHeader header = ReadBridgeHeader(bytes).value_or(BridgeHeader{});
    header.version = 9;
    return Packets{ToVector(WriteBridgeRefusal(header, {BridgeReason::kVersion, 9, "too old"}))};
  });
  BridgeDriver driver(MakeOptions(other.port()));
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("uses version 9 of the protocol, but kerf uses version 1"));
}

TEST(BridgeDriver, ReportsThatThereIsNoDevice) {
  Answerer other([](std::span<const std::uint8_t> bytes) {
    return Packets{ToVector(WriteBridgeRefusal(ReadBridgeHeader(bytes).value_or(BridgeHeader{}),
                                               {BridgeReason::kNoDevice, 1, "hdInitDevice failed"}))};
  });
  BridgeDriver driver(MakeOptions(other.port()));
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("finds no device; "));
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("hdInitDevice failed"));
}

TEST(BridgeDriver, ReportsThatADifferentProgramAnswers) {
  Answerer other([](std::span<const std::uint8_t>) { return Packets{std::vector<std::uint8_t>(40, 'x')}; });
  BridgeOptions options = MakeOptions(other.port());
  options.start_timeout_ms = 250;
  BridgeDriver driver(options);
  EXPECT_THAT(MessageOfStart(driver), HasSubstr("gave no valid answer"));
}

TEST(BridgeDriver, OldDuplicateAndDamagedAnswersAreIgnored) {
  GoodBridge good;
  std::atomic<int> what{0};
  Answerer other([&](std::span<const std::uint8_t> bytes) {
    Packets answers = {good.Answer(bytes)};
    if (answers[0].empty()) return Packets{};
    if (what == 1) answers[0][40] ^= 1;
    if (what == 2) good.sequence -= 1;  // repeats the sequence number
    if (what == 3) answers.push_back(answers[0]);
    return answers;
  });
  BridgeOptions options = MakeOptions(other.port());
  options.timeout_ms = 30;
  BridgeDriver driver(options);
  driver.Start(nullptr);
  DriverSample sample;
  // On a busy machine, some answers may be late. Runs rounds until 15 of them have ended with `wanted`; returns how
  // each round ended.
  const auto rounds_until = [&](RoundEnd wanted) {
    std::vector<RoundEnd> ends;
    for (int count = 0; ends.size() < 400 && count < 15;) {
      ends.push_back(driver.Exchange({}, sample));
      count += ends.back() == wanted ? 1 : 0;
    }
    EXPECT_EQ(std::count(ends.begin(), ends.end(), wanted), 15) << what;
    return ends;
  };
  EXPECT_THAT(rounds_until(RoundEnd::kSample), Not(Contains(RoundEnd::kBadAnswer)));
  EXPECT_EQ(sample.X_DH.p_AB, Vec3(1, 2, 3));
  what = 1;
  std::vector<RoundEnd> ends = rounds_until(RoundEnd::kBadAnswer);
  // Answers arrive in order, so earlier good ones may precede the first bad one.
  ends.erase(ends.begin(), std::find(ends.begin(), ends.end(), RoundEnd::kBadAnswer));
  EXPECT_THAT(ends, Not(Contains(RoundEnd::kSample)));
  what = 2;
  ends = rounds_until(RoundEnd::kBadAnswer);
  EXPECT_LE(std::count(ends.begin(), ends.end(), RoundEnd::kSample), 1);  // the first answer with that number
  what = 3;
  rounds_until(RoundEnd::kSample);
}

TEST(BridgeDriver, ConnectsToThisMachineOnlyUnlessAllowed) {
  BridgeOptions options;
  options.address = "192.0.2.1";
  EXPECT_THROW(BridgeDriver{options}, Error);
  options.allow_remote = true;
  EXPECT_NO_THROW(BridgeDriver{options});
  options.address = "localhost";
  EXPECT_THROW(BridgeDriver{options}, Error);
  options = {};
  options.valid_ms = 0;
  EXPECT_THROW(BridgeDriver{options}, Error);
}

TEST(BridgeDriver, BadCommandsGoOutAsZero) {
  std::atomic<bool> all_good{true};
  GoodBridge good;
  Answerer other([&](std::span<const std::uint8_t> bytes) {
    const auto header = ReadBridgeHeader(bytes);
    if (header && header->kind == BridgeKind::kCommand) {
      const auto command = ReadBridgeCommand(bytes);
      if (!command || glm::length(command->f_D_N) > 5.0001) all_good = false;
    }
    std::vector<std::uint8_t> answer = good.Answer(bytes);
    return answer.empty() ? Packets{} : Packets{answer};
  });
  BridgeDriver driver(MakeOptions(other.port()));
  driver.Start(nullptr);
  DriverSample sample;
  for (const double x : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, 6.0}) {
    DriverCommand command;
    command.f_D_N = {x, 0, 0};
    command.tau_D_Nmm = {0, x, 0};
    command.p_D_mm = {0, 0, x};
    command.stiffness_N_per_mm = x;
    command.damping_Ns_per_mm = -x;
    EXPECT_EQ(ExchangeUntilAnswered(driver, command, sample), RoundEnd::kSample) << x;
  }
  EXPECT_TRUE(all_good);
}

/// A good bridge with a long delay: it answers each command `late` commands later.
class FarBridge {
 public:
  FarBridge() : answerer_([this](std::span<const std::uint8_t> bytes) { return Answer(bytes); }) {}
  std::uint16_t port() const { return answerer_.port(); }

  std::atomic<std::size_t> late{0};
  std::atomic<bool> late_now_and_then{false};  // one command in five is delayed by one command

 private:
  Packets Answer(std::span<const std::uint8_t> bytes) {
    const auto header = ReadBridgeHeader(bytes);
    std::vector<std::uint8_t> answer = good_.Answer(bytes);
    if (answer.empty()) return {};
    if (header->kind != BridgeKind::kCommand) return {answer};
    under_way_.push_back(std::move(answer));
    ++commands_;
    const std::size_t keep = late_now_and_then && commands_ % 5 == 0 ? 1 : late.load();
    Packets come;
    for (; under_way_.size() > keep; under_way_.pop_front()) come.push_back(std::move(under_way_.front()));
    return come;
  }

  GoodBridge good_;
  std::deque<std::vector<std::uint8_t>> under_way_;
  std::uint64_t commands_ = 0;
  Answerer answerer_;  // last member: its thread calls Answer()
};

TEST(BridgeDriver, ContinuousButOldAnswersEndTheForce) {
  FarBridge far;
  BridgeOptions options = MakeOptions(far.port());
  BridgeDriver driver(options);
  driver.Start(nullptr);
  ServoRound servo(driver.profile(), driver.traits(), {});
  servo.Open(0);
  ServoCommand command;
  double now_s = 0;
  const auto run = [&](BridgeDriver& with, int rounds) {
    for (int i = 0; i < rounds; ++i) {
      now_s += 0.01;
      ++command.sequence;
      command.made_at_s = now_s;
      command.command.f_D_N = {0, 0, 2};
      servo.Step(with, now_s, 0.01, command, true);
    }
    return servo.state();
  };
  ASSERT_EQ(run(driver, 200), ServoState::kEngaged);
  ASSERT_GT(glm::length(servo.sent_force_N()), 1.9);
  EXPECT_LE(driver.late_states(), servo.counts().no_answers);  // none, unless the machine stalls
  // From here on each round waits its full 10 ms without receiving its own answer, and receives the answer of six
  // rounds ago.
  far.late = 6;
  options.timeout_ms = 10;
  BridgeDriver impatient(options);
  driver.Stop();
  impatient.Start(nullptr);
  const std::uint64_t samples = servo.counts().samples;
  EXPECT_EQ(run(impatient, 30), ServoState::kSilent);
  EXPECT_EQ(glm::length(servo.sent_force_N()), 0);
  EXPECT_EQ(servo.counts().samples, samples);
  EXPECT_GE(servo.counts().no_answers, 25u);
  EXPECT_GT(impatient.late_states(), 0u);
  // Now without the delay again.
  far.late = 0;
  DriverSample sample;
  RoundEnd end = RoundEnd::kNoAnswer;
  for (int i = 0; i < 1000 && end != RoundEnd::kSample; ++i) end = impatient.Exchange({}, sample);
  EXPECT_EQ(end, RoundEnd::kSample);
  EXPECT_EQ(sample.X_DH.p_AB, Vec3(1, 2, 3));
}

/// A bridge that uses the client in C. While its servo loop hangs, only its answering thread runs. The clock of the
/// bridge advances by 10 ms with each command.
class HangingBridge {
 public:
  HangingBridge() : answerer_([this](std::span<const std::uint8_t> bytes) { return Answer(bytes); }) {}
  std::uint16_t port() const { return answerer_.port(); }

  std::atomic<bool> hangs{false};
  std::atomic<bool> was_pushed{false};  // true if a command would have made force since this was set to false

 private:
  Packets Answer(std::span<const std::uint8_t> bytes) {
    if (!begun_) {
      kerf_bridge_description description{};
      description.name = "made up";
      description.peak_force_n = 5;
      description.driven = 3;
      kerf_bridge_begin(&bridge_, &description);
      begun_ = true;
    }
    now_ns_ += 10'000'000;
    kerf_bridge_state state{};
    state.orientation_wxyz[0] = 1;
    state.homed = 1;
    state.ready = 1;
    if (!hangs) kerf_bridge_set_state(&bridge_, &state, now_ns_);
    std::vector<std::uint8_t> reply(KERF_BRIDGE_BYTES);
    const bool answers = kerf_bridge_take(&bridge_, bytes.data(), bytes.size(), 1, now_ns_, reply.data()) > 0;
    std::array<float, 3> force_N{};
    std::array<float, 3> torque_Nmm{};
    kerf_bridge_force(&bridge_, now_ns_, state.position_mm, torque_Nmm.data(), force_N.data(), torque_Nmm.data());
    if (force_N[0] != 0) was_pushed = true;
    return answers ? Packets{reply} : Packets{};
  }

  kerf_bridge bridge_{};
  bool begun_ = false;
  std::uint64_t now_ns_ = 1'000'000'000;
  Answerer answerer_;  // last member: its thread calls Answer()
};

TEST(BridgeDriver, APromptAnswerWithAFrozenPoseEndsTheForce) {
  HangingBridge far;
  BridgeDriver driver(MakeOptions(far.port()));
  driver.Start(nullptr);
  ServoRound servo(driver.profile(), driver.traits(), {});
  servo.Open(0);
  ServoCommand command;
  double now_s = 0;
  const auto run = [&](int rounds) {
    for (int i = 0; i < rounds; ++i) {
      now_s += 0.01;
      ++command.sequence;
      command.made_at_s = now_s;
      command.command.f_D_N = {2, 0, 0};
      servo.Step(driver, now_s, 0.01, command, true);
    }
    return servo.state();
  };
  ASSERT_EQ(run(200), ServoState::kEngaged);
  EXPECT_TRUE(far.was_pushed);
  far.hangs = true;
  run(10);  // five answers take 50 ms on the bridge's clock; then the gate closes within 20 ms
  EXPECT_EQ(servo.state(), ServoState::kHoming);
  EXPECT_EQ(servo.sent_force_N(), Vec3{0});
  // The gate stays closed after any number of answers, although the user agrees all the time.
  far.was_pushed = false;
  EXPECT_EQ(run(100), ServoState::kHoming);
  EXPECT_EQ(servo.sent_force_N(), Vec3{0});
  EXPECT_FALSE(far.was_pushed);
  EXPECT_LE(servo.counts().no_answers, 2u);  // none, unless the machine stalls
  far.hangs = false;
  EXPECT_EQ(run(200), ServoState::kEngaged);
  EXPECT_TRUE(far.was_pushed);
}

TEST(BridgeDriver, OccasionallyLateAnswersAreAccepted) {
  // Answers may be 1 s old and a round waits 0.1 s, so that late answers are still valid.
  test::RetryIfStalled(std::chrono::milliseconds(80), [](test::LongestGap& /*own*/) {
    FarBridge far;
    BridgeOptions options = MakeOptions(far.port());
    options.timeout_ms = 100;
    options.max_age_ms = 1000;  // allows for a very busy machine
    BridgeDriver driver(options);
    driver.Start(nullptr);
    DriverSample sample;
    EXPECT_EQ(driver.Exchange({}, sample), RoundEnd::kSample);  // the first round after the start
    far.late_now_and_then = true;
    int samples = 0;
    for (int i = 0; i < 20; ++i) samples += driver.Exchange({}, sample) == RoundEnd::kSample ? 1 : 0;
    EXPECT_GE(samples, 12);  // there are 16, unless the machine stalls
    // From here on, every answer belongs to the previous command; it is old, but not too old.
    far.late_now_and_then = false;
    far.late = 1;
    driver.Exchange({}, sample);
    samples = 0;
    for (int i = 0; i < 5; ++i) samples += driver.Exchange({}, sample) == RoundEnd::kSample ? 1 : 0;
    EXPECT_GE(samples, 3);
    EXPECT_EQ(driver.late_states(), 0u);
  });
  BridgeOptions options;
  options.max_age_ms = 0;
  EXPECT_THROW(BridgeDriver{options}, Error);
}

}  // namespace
}  // namespace kerf
