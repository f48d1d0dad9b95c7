// The bridge's packets: the C++ and C code write the same bytes and read each other's packets, damage is detected, and
// the force field matches its closed form.
#include "device/devices/bridge/bridge_packet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "kerf_bridge.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double Real(double limit) { return std::uniform_real_distribution<double>(-limit, limit)(random_); }
  /// Returns a vector with the precision of a packet.
  Vec3 Vector(double limit) { return {Single(limit), Single(limit), Single(limit)}; }
  double Positive(double limit) { return std::abs(Single(limit)); }
  std::uint32_t Word() { return static_cast<std::uint32_t>(random_()); }
  std::uint64_t Long() { return random_(); }
  Quat Turn() {
    std::normal_distribution<double> normal;
    return glm::normalize(Quat(normal(random_), normal(random_), normal(random_), normal(random_)));
  }

 private:
  /// Returns a value of at most 500 with few enough bits to be exact in single precision.
  double Single(double limit) { return std::round(32768 * Real(limit)) / 32768; }

  std::mt19937_64 random_;
};

BridgeHeader DrawHeader(Draw& draw) {
  BridgeHeader header;
  header.session = draw.Word();
  header.sequence = draw.Word();
  header.time_ns = draw.Long();
  header.answer_to = draw.Word();
  return header;
}

BridgeCommand DrawCommand(Draw& draw) {
  BridgeCommand command;
  command.f_D_N = draw.Vector(20);
  command.tau_D_Nmm = draw.Vector(300);
  command.p_D_mm = draw.Vector(150);
  command.stiffness_N_per_mm = draw.Positive(3);
  command.damping_Ns_per_mm = draw.Positive(0.03);
  command.valid_ms = 1 + draw.Word() % 1000;
  command.engaged = draw.Word() % 2 == 0;
  return command;
}

kerf_bridge_header ToC(const BridgeHeader& header) {
  kerf_bridge_header c{};
  c.version = header.version;
  c.session = header.session;
  c.sequence = header.sequence;
  c.time_ns = header.time_ns;
  c.answer_to = header.answer_to;
  return c;
}

void ToC(const Vec3& v, float* c) {
  for (int i = 0; i < 3; ++i) c[i] = static_cast<float>(v[i]);
}
Vec3 FromC(const float* c) {
  return {double{c[0]}, double{c[1]}, double{c[2]}};
}

kerf_bridge_command ToC(const BridgeCommand& command) {
  kerf_bridge_command c{};
  ToC(command.f_D_N, c.force_n);
  ToC(command.tau_D_Nmm, c.torque_nmm);
  ToC(command.p_D_mm, c.anchor_mm);
  c.stiffness_n_per_mm = static_cast<float>(command.stiffness_N_per_mm);
  c.damping_ns_per_mm = static_cast<float>(command.damping_Ns_per_mm);
  c.valid_ms = command.valid_ms;
  c.engaged = command.engaged ? 1 : 0;
  return c;
}

TEST(BridgePacket, CrcIsTheOneOfZipAndEthernet) {
  const std::string check = "123456789";  // the check value that every catalogue of CRCs lists
  const std::vector<std::uint8_t> bytes(check.begin(), check.end());
  EXPECT_EQ(CalcCrc32(bytes), 0xcbf43926u);
  EXPECT_EQ(kerf_bridge_crc32(bytes.data(), bytes.size()), 0xcbf43926u);
}

TEST(BridgePacket, CommandsAreTheSameBytesInBothLanguages) {
  Draw draw(1);
  for (int i = 0; i < 20'000; ++i) {
    const BridgeHeader header = DrawHeader(draw);
    const BridgeCommand command = DrawCommand(draw);
    const BridgeBytes ours = WriteBridgeCommand(header, command);
    BridgeBytes theirs{};
    const kerf_bridge_header c_header = ToC(header);
    const kerf_bridge_command c_command = ToC(command);
    kerf_bridge_write_command(theirs.data(), &c_header, &c_command);
    ASSERT_EQ(ours, theirs);
    kerf_bridge_command read{};
    ASSERT_EQ(kerf_bridge_read_command(ours.data(), ours.size(), &read), 1);
    ASSERT_EQ(FromC(read.force_n), command.f_D_N);
    ASSERT_EQ(FromC(read.torque_nmm), command.tau_D_Nmm);
    ASSERT_EQ(FromC(read.anchor_mm), command.p_D_mm);
    ASSERT_EQ(double{read.stiffness_n_per_mm}, command.stiffness_N_per_mm);
    ASSERT_EQ(double{read.damping_ns_per_mm}, command.damping_Ns_per_mm);
    ASSERT_EQ(read.valid_ms, command.valid_ms);
    ASSERT_EQ(read.engaged != 0, command.engaged);
    const auto back = ReadBridgeCommand(theirs);
    ASSERT_TRUE(back);
    ASSERT_EQ(back->f_D_N, command.f_D_N);
    ASSERT_EQ(back->valid_ms, command.valid_ms);
  }
}

TEST(BridgePacket, StatesAreTheSameBytesInBothLanguages) {
  Draw draw(2);
  for (int i = 0; i < 20'000; ++i) {
    const BridgeHeader header = DrawHeader(draw);
    BridgeState state;
    state.X_DH = {draw.Turn(), draw.Vector(150)};
    state.buttons = draw.Word();
    state.actual_f_D_N = draw.Vector(20);
    state.homed = draw.Word() % 2 == 0;
    state.ready = draw.Word() % 2 == 0;
    kerf_bridge_state c{};
    ToC(state.X_DH.p_AB, c.position_mm);
    const Quat& q = state.X_DH.R_AB;
    c.orientation_wxyz[0] = static_cast<float>(q.w);
    ToC({q.x, q.y, q.z}, c.orientation_wxyz + 1);
    c.buttons = state.buttons;
    ToC(state.actual_f_D_N, c.made_force_n);
    c.homed = state.homed ? 1 : 0;
    c.ready = state.ready ? 1 : 0;
    const kerf_bridge_header c_header = ToC(header);
    BridgeBytes theirs{};
    kerf_bridge_write_state(theirs.data(), &c_header, &c);
    ASSERT_EQ(WriteBridgeState(header, state), theirs);
    const auto read = ReadBridgeState(theirs);
    ASSERT_TRUE(read);
    ASSERT_TRUE(IsValid(read->X_DH));
    ASSERT_EQ(read->X_DH.p_AB, state.X_DH.p_AB);
    ASSERT_NEAR(std::abs(glm::dot(read->X_DH.R_AB, q)), 1, 1e-12);  // the error of single precision, 1e-7, squared
    ASSERT_EQ(read->buttons, state.buttons);
    ASSERT_EQ(read->homed, state.homed);
    ASSERT_EQ(read->ready, state.ready);
    kerf_bridge_state again{};
    ASSERT_EQ(kerf_bridge_read_state(theirs.data(), theirs.size(), &again), 1);
    const auto header_read = ReadBridgeHeader(theirs);
    ASSERT_TRUE(header_read);
    ASSERT_EQ(header_read->sequence, header.sequence);
    ASSERT_EQ(header_read->answer_to, header.answer_to);
    ASSERT_EQ(header_read->time_ns, header.time_ns);
  }
}

TEST(BridgePacket, DescriptionsAndRefusalsAreTheSameBytesInBothLanguages) {
  Draw draw(3);
  const BridgeHeader header = DrawHeader(draw);
  const kerf_bridge_header c_header = ToC(header);
  const kerf_bridge_description c = {"touch", 3.5f, 0.5f, 10, 5, 0.25f, 0.004f, 75, 0.0625f, 1000, 6, 1, 1, 2};
  BridgeBytes theirs{};
  kerf_bridge_write_description(theirs.data(), &c_header, &c);
  const auto read = ReadBridgeDescription(theirs);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->name, "touch");
  EXPECT_EQ(read->peak_force_N, 3.5);
  EXPECT_EQ(read->rate_hz, 1000);
  EXPECT_EQ(read->driven, 6);
  EXPECT_EQ(read->buttons, 2);
  EXPECT_EQ(WriteBridgeDescription(header, *read), theirs);

  kerf_bridge_write_refusal(theirs.data(), &c_header, KERF_BRIDGE_BUSY, "another client");
  const auto refusal = ReadBridgeRefusal(theirs);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, BridgeReason::kBusy);
  EXPECT_EQ(refusal->text, "another client");
  EXPECT_EQ(WriteBridgeRefusal(header, *refusal), theirs);

  // A refusal whose text is too long is truncated.
  kerf_bridge_write_refusal(theirs.data(), &c_header, KERF_BRIDGE_BUSY, std::string(500, 'x').c_str());
  EXPECT_EQ(ReadBridgeRefusal(theirs).value_or(BridgeRefusal{}).text, std::string(79, 'x'));
}

TEST(BridgePacket, AnyFlippedBitIsDetected) {
  Draw draw(4);
  const BridgeBytes good = WriteBridgeCommand(DrawHeader(draw), DrawCommand(draw));
  ASSERT_TRUE(ReadBridgeCommand(good));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    BridgeBytes bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    ASSERT_FALSE(ReadBridgeHeader(bad)) << bit;
    kerf_bridge_header header;
    ASSERT_EQ(kerf_bridge_read_header(bad.data(), bad.size(), &header), 0) << bit;
  }
  ASSERT_FALSE(ReadBridgeHeader(std::span(good).first(127)));
}

TEST(BridgePacket, CAndCppAcceptTheSameRandomPackets) {
  Draw draw(5);
  int taken = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    BridgeBytes bytes{};
    if (i % 2 == 0) {
      for (std::size_t b = 0; b < bytes.size(); b += 8) {
        const std::uint64_t word = draw.Long();
        std::memcpy(&bytes[b], &word, 8);
      }
    } else {
      bytes = i % 4 == 1 ? WriteBridgeCommand(DrawHeader(draw), DrawCommand(draw)) : WriteBridgeState({}, {});
      for (std::uint32_t n = draw.Word() % 3; n > 0; --n) {
        bytes[draw.Word() % 124] = static_cast<std::uint8_t>(draw.Word());
      }
    }
    // The checksum is usually correct; otherwise hardly any packet would reach the checks of the fields.
    if (draw.Word() % 8 != 0) {
      const std::uint32_t sum = CalcCrc32(std::span(bytes).first(124));
      std::memcpy(&bytes[124], &sum, 4);
    }
    const std::size_t count = draw.Word() % 16 == 0 ? draw.Word() % 129 : 128;
    const auto packet = std::span<const std::uint8_t>(bytes).first(count);
    const auto command = ReadBridgeCommand(packet);
    kerf_bridge_command c_command{};
    ASSERT_EQ(kerf_bridge_read_command(bytes.data(), count, &c_command) != 0, command.has_value());
    const auto state = ReadBridgeState(packet);
    kerf_bridge_state c_state{};
    ASSERT_EQ(kerf_bridge_read_state(bytes.data(), count, &c_state) != 0, state.has_value());
    if (i % 16 == 0) {
      ReadBridgeDescription(packet);
      ReadBridgeRefusal(packet);
    }
    if (command) {
      ++taken;
      ASSERT_LE(glm::length(command->f_D_N), 2e6);
      ASSERT_GE(command->stiffness_N_per_mm, 0);
      ASSERT_LE(command->valid_ms, 1000u);
    }
    ASSERT_TRUE(!state || IsValid(state->X_DH));
  }
  EXPECT_GT(taken, cases / 10);
}

TEST(BridgePacket, SequenceNumbersWrapAround) {
  EXPECT_TRUE(IsAfter(1, 0));
  EXPECT_FALSE(IsAfter(5, 5));
  EXPECT_TRUE(IsAfter(3, 0xfffffff0u));
  EXPECT_FALSE(IsAfter(0xfffffff0u, 3));
}

TEST(BridgeField, IsTheClosedForm) {
  BridgeCommand command;
  command.f_D_N = {0, 0, 2};
  command.p_D_mm = {0, 0, 10};
  command.stiffness_N_per_mm = 0.5;
  command.damping_Ns_per_mm = 0.01;
  const Vec3 rest{0};
  EXPECT_EQ(CalcFieldForce(command, {7, 9, 10}, rest, 0), Vec3(0, 0, 2));   // sideways motion has no effect
  EXPECT_EQ(CalcFieldForce(command, {0, 0, 8}, rest, 0), Vec3(0, 0, 3));    // deeper inside the wall
  EXPECT_EQ(CalcFieldForce(command, {0, 0, 12}, rest, 0), Vec3(0, 0, 1));   // outwards
  EXPECT_EQ(CalcFieldForce(command, {0, 0, 15}, rest, 0), rest);            // the wall does not pull
  EXPECT_EQ(CalcFieldForce(command, {0, 0, -90}, rest, 8), Vec3(0, 0, 8));  // limited to the device's peak
  EXPECT_EQ(CalcFieldForce(command, {0, 0, 15}, {100, 0, 0}, 0), Vec3(-1, 0, 0));
  command.f_D_N = rest;
  EXPECT_EQ(CalcFieldForce(command, {0, 0, -90}, rest, 8), rest);
}

TEST(BridgeField, IsTheSameInC) {
  Draw draw(6);
  for (int i = 0; i < 100'000; ++i) {
    const BridgeCommand command = DrawCommand(draw);
    const kerf_bridge_command c = ToC(command);
    const Vec3 x = draw.Vector(150);
    const Vec3 v = draw.Vector(500);
    const double peak_N = i % 2 == 0 ? 0 : draw.Positive(20);
    float x_c[3], v_c[3], f_c[3];
    ToC(x, x_c);
    ToC(v, v_c);
    kerf_bridge_field(&c, x_c, v_c, static_cast<float>(peak_N), f_c);
    const Vec3 f = CalcFieldForce(command, x, v, peak_N);
    ASSERT_LT(glm::length(FromC(f_c) - f), 1e-6 * (1 + glm::length(f)));  // the C version uses single precision
    ASSERT_TRUE(peak_N == 0 || glm::length(f) <= peak_N * (1 + 1e-12));
  }
}

/// The client's side of a session, without a socket.
struct Client {
  explicit Client(float peak_N = 10, float peak_Nmm = 100) {
    const kerf_bridge_description d = {"made up", peak_N, 0, peak_Nmm, 0, 1, 0.01f, 75, 0.05f, 1000, 6, 1, 0, 2};
    kerf_bridge_begin(&bridge, &d);
  }
  std::size_t Take(const BridgeBytes& bytes, std::uint64_t from = 1) {
    reply.fill(0);
    return kerf_bridge_take(&bridge, bytes.data(), bytes.size(), from, now_ns, reply.data());
  }
  Vec3 Force() {
    const float zero[3] = {0, 0, 0};
    float f[3], tau[3];
    kerf_bridge_force(&bridge, now_ns, zero, zero, f, tau);
    torque = FromC(tau);
    return FromC(f);
  }

  kerf_bridge bridge{};
  std::uint64_t now_ns = 1'000'000'000;
  BridgeBytes reply{};
  Vec3 torque{0};
};

BridgeHeader MakeHeader(std::uint32_t session, std::uint32_t sequence) {
  BridgeHeader header;
  header.session = session;
  header.sequence = sequence;
  return header;
}

BridgeCommand MakePush() {
  BridgeCommand command;
  command.f_D_N = {1, 0, 0};
  command.tau_D_Nmm = {0, 200, 0};
  command.engaged = true;
  command.valid_ms = 50;
  return command;
}

TEST(BridgeClient, AnswersAHelloAndThenEachCommand) {
  Client client;
  ASSERT_EQ(client.Take(WriteBridgeHello(MakeHeader(7, 1))), 128u);
  ASSERT_TRUE(ReadBridgeDescription(client.reply));
  EXPECT_EQ(client.Force(), Vec3{0});
  ASSERT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 2), MakePush())), 128u);
  ASSERT_TRUE(ReadBridgeState(client.reply));
  EXPECT_EQ(ReadBridgeHeader(client.reply).value_or(BridgeHeader{}).answer_to, 2u);
  EXPECT_EQ(client.Force(), Vec3(1, 0, 0));
  EXPECT_LT(glm::length(client.torque - Vec3(0, 100, 0)), 1e-4);  // limited to its peak
}

TEST(BridgeClient, ForceIsZeroWithoutNewCommands) {
  Client client;
  client.Take(WriteBridgeHello(MakeHeader(7, 1)));
  client.Take(WriteBridgeCommand(MakeHeader(7, 2), MakePush()));
  client.now_ns += 50'000'000;
  EXPECT_EQ(client.Force(), Vec3(1, 0, 0));
  client.now_ns += 1;
  EXPECT_EQ(client.Force(), Vec3{0});
  EXPECT_EQ(client.torque, Vec3{0});
}

TEST(BridgeClient, OldDuplicateAndForeignPacketsChangeNothing) {
  Client client;
  client.Take(WriteBridgeHello(MakeHeader(7, 1)));
  client.Take(WriteBridgeCommand(MakeHeader(7, 5), MakePush()));
  BridgeCommand other = MakePush();
  other.f_D_N = {-5, 0, 0};
  EXPECT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 5), other)), 0u);  // a duplicate
  EXPECT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 4), other)), 0u);  // an old command
  other.f_D_N.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 6), other)), 0u);
  EXPECT_EQ(client.Force(), Vec3(1, 0, 0));
  EXPECT_EQ(client.bridge.dropped, 3u);
  // A command of another session or from another sender is refused and has no effect.
  other = MakePush();
  other.f_D_N = {9, 0, 0};
  ASSERT_EQ(client.Take(WriteBridgeCommand(MakeHeader(8, 9), other)), 128u);
  EXPECT_EQ(ReadBridgeRefusal(client.reply).value_or(BridgeRefusal{}).reason, BridgeReason::kNoSession);
  ASSERT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 9), other), 2), 128u);
  EXPECT_EQ(ReadBridgeRefusal(client.reply).value_or(BridgeRefusal{}).reason, BridgeReason::kNoSession);
  EXPECT_EQ(client.Force(), Vec3(1, 0, 0));
}

TEST(BridgeClient, ASecondClientHasToWaitUntilTheFirstIsSilent) {
  Client client;
  client.Take(WriteBridgeHello(MakeHeader(7, 1)));
  ASSERT_EQ(client.Take(WriteBridgeHello(MakeHeader(8, 1)), 2), 128u);
  EXPECT_EQ(ReadBridgeRefusal(client.reply).value_or(BridgeRefusal{}).reason, BridgeReason::kBusy);
  client.now_ns += 2'000'000'000;
  ASSERT_EQ(client.Take(WriteBridgeHello(MakeHeader(8, 1)), 2), 128u);
  EXPECT_TRUE(ReadBridgeDescription(client.reply));
}

TEST(BridgeClient, ReportsItsVersionToOtherVersions) {
  Client client;
  BridgeHeader header = MakeHeader(7, 1);
  header.version = 2;
  ASSERT_EQ(client.Take(WriteBridgeHello(header)), 128u);
  const auto refusal = ReadBridgeRefusal(client.reply);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->reason, BridgeReason::kVersion);
  EXPECT_EQ(refusal->version, 1);
}

TEST(BridgeClient, AByeEndsTheForceAtOnce) {
  Client client;
  client.Take(WriteBridgeHello(MakeHeader(7, 1)));
  client.Take(WriteBridgeCommand(MakeHeader(7, 2), MakePush()));
  EXPECT_EQ(client.Take(WriteBridgeBye(MakeHeader(7, 3))), 0u);
  EXPECT_EQ(client.Force(), Vec3{0});
}

TEST(BridgeClient, ClockReadJustBeforeTheLockStillGivesForce) {
  Client client;
  constexpr std::uint64_t kReceived_ns = 5'000'000'000;
  client.now_ns = kReceived_ns;
  client.Take(WriteBridgeHello(MakeHeader(7, 1)));
  client.Take(WriteBridgeCommand(MakeHeader(7, 2), MakePush()));
  for (const std::uint64_t before_ns : {1u, 20'000u, 60'000'000u, 999'999'999u}) {
    client.now_ns = kReceived_ns - before_ns;
    EXPECT_EQ(client.Force(), Vec3(1, 0, 0)) << before_ns;
    EXPECT_GT(client.torque.y, 99) << before_ns;
  }
  // No wait for a lock takes this long: the time is from another clock, or the clock was set back.
  for (const std::uint64_t before_ns : {std::uint64_t{1'000'000'000}, kReceived_ns}) {
    client.now_ns = kReceived_ns - before_ns;
    EXPECT_EQ(client.Force(), Vec3{0}) << before_ns;
    EXPECT_EQ(client.torque, Vec3{0}) << before_ns;
  }
}

TEST(BridgeClient, StaleStateIsNotReady) {
  Client client;
  constexpr std::uint64_t kMeasured_ns = 5'000'000'000;
  std::uint32_t sequence = 0;
  const auto ask = [&](std::uint64_t now_ns) {
    client.now_ns = now_ns;
    EXPECT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, ++sequence), MakePush())), 128u);
    return ReadBridgeState(client.reply).value_or(BridgeState{});
  };
  client.now_ns = kMeasured_ns;
  client.Take(WriteBridgeHello(MakeHeader(7, ++sequence)));
  EXPECT_FALSE(ask(kMeasured_ns).ready);  // no state yet
  EXPECT_EQ(ReadBridgeHeader(client.reply).value_or(BridgeHeader{}).time_ns, 0u);
  kerf_bridge_state state{};
  state.position_mm[1] = 4;
  state.orientation_wxyz[0] = 1;
  state.homed = 1;
  state.ready = 1;
  kerf_bridge_set_state(&client.bridge, &state, kMeasured_ns);
  // The answering thread may have read the clock before it got the lock.
  for (const std::uint64_t before_ns : {999'999'999u, 1u})
    EXPECT_TRUE(ask(kMeasured_ns - before_ns).ready) << before_ns;
  for (const std::uint64_t age_ns : {0u, 1'000'000u, 50'000'000u})
    EXPECT_TRUE(ask(kMeasured_ns + age_ns).ready) << age_ns;
  // If the state is frozen or has a time from another clock, the pose is reported unchanged, with its own time.
  for (const std::uint64_t now_ns :
       {kMeasured_ns + 50'000'001, kMeasured_ns + 3'600'000'000'000, kMeasured_ns - 1'000'000'000, std::uint64_t{0}}) {
    const BridgeState reported = ask(now_ns);
    EXPECT_FALSE(reported.ready) << now_ns;
    EXPECT_TRUE(reported.homed) << now_ns;
    EXPECT_EQ(reported.X_DH.p_AB, Vec3(0, 4, 0)) << now_ns;
    EXPECT_EQ(ReadBridgeHeader(client.reply).value_or(BridgeHeader{}).time_ns, kMeasured_ns) << now_ns;
  }
  // The servo loop continues.
  kerf_bridge_set_state(&client.bridge, &state, kMeasured_ns + 60'000'000);
  EXPECT_TRUE(ask(kMeasured_ns + 70'000'000).ready);
}

TEST(BridgeClient, PeakOfZeroGivesNoForce) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto push = [](Client& client) {
    client.Take(WriteBridgeHello(MakeHeader(7, 1)));
    EXPECT_EQ(client.Take(WriteBridgeCommand(MakeHeader(7, 2), MakePush())), 128u);
  };
  for (const float none : {0.0f, -0.0f, -5.0f, kNan, kInfinity, -kInfinity, 2e6f}) {
    Client handle(none);
    push(handle);
    EXPECT_EQ(handle.Force(), Vec3{0}) << none;
    EXPECT_EQ(handle.torque, Vec3{0}) << none;
    Client wrist(10, none);
    push(wrist);
    EXPECT_EQ(wrist.Force(), Vec3(1, 0, 0)) << none;
    EXPECT_EQ(wrist.torque, Vec3{0}) << none;
  }
  // Even a very small peak is a limit.
  Client weak(1e-3f, 1e-3f);
  push(weak);
  EXPECT_NEAR(glm::length(weak.Force()), 1e-3, 1e-9);  // rounding of single precision
  EXPECT_NEAR(glm::length(weak.torque), 1e-3, 1e-9);
}

}  // namespace
}  // namespace kerf
