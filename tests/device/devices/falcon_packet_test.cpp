// The Falcon's packets: packing and unpacking, and damaged packets.
#include "device/devices/falcon/falcon_packet.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <deque>
#include <random>
#include <vector>

#include "device/devices/falcon/falcon_usb.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(FalconPacket, HasTheDocumentedBytes) {
  // The motor values are 0x1234, -1 and 0, with homing on and the green lamp: nibbles from the lowest up, each plus
  // 0x41.
  const FalconPacket packet = Pack(FalconCommand{.motors = {0x1234, -1, 0}, .homing = true, .lamps = kFalconGreen});
  const FalconPacket expected = {'<',  0x45, 0x44, 0x43, 0x42, 0x50, 0x50, 0x50,
                                 0x50, 0x41, 0x41, 0x41, 0x41, 0x44, 0x41, '>'};
  EXPECT_EQ(packet, expected);
}

RC_GTEST_PROP(FalconPacket, RoundTripIsExact, ()) {
  const auto number = rc::gen::inRange(-32768, 32768);
  const FalconReport report = {{*number, *number, *number},
                               static_cast<std::uint8_t>(*rc::gen::inRange(0, 16)),
                               static_cast<std::uint8_t>(*rc::gen::inRange(0, 8))};
  const std::optional<FalconReport> back = UnpackReport(Pack(report));
  RC_ASSERT(back.has_value());
  RC_ASSERT(back->counts == report.counts && back->buttons == report.buttons && back->homed == report.homed);
  const FalconCommand command = {
      {*number, *number, *number}, *rc::gen::arbitrary<bool>(), static_cast<std::uint8_t>(2 * *rc::gen::inRange(0, 8))};
  const std::optional<FalconCommand> there = UnpackCommand(Pack(command));
  RC_ASSERT(there.has_value());
  RC_ASSERT(there->motors == command.motors && there->homing == command.homing && there->lamps == command.lamps);
}

TEST(FalconPacket, NumbersAreClampedTo16Bits) {
  EXPECT_EQ(UnpackCommand(Pack(FalconCommand{.motors = {100000, -100000, 5}}))->motors,
            (std::array<int, 3>{32767, -32768, 5}));
}

TEST(FalconPacket, EveryByteIsChecked) {
  const FalconPacket good = Pack(FalconReport{{1, -2, 300}, 5, 7});
  ASSERT_TRUE(UnpackReport(good));
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (int value = 0; value < 256; ++value) {
      FalconPacket packet = good;
      packet[at] = static_cast<std::uint8_t>(value);
      bool valid = value == good[at];
      if (at >= 1 && at <= 12) valid = value >= 0x41 && value <= 0x50;
      if (at == 13) valid = value >= 0x41 && value <= 0x41 + 0x7f;
      if (at == 14) valid = value != '<' && value != '>';
      ASSERT_EQ(UnpackReport(packet).has_value(), valid) << at << " " << value;
    }
  }
}

TEST(FalconPacket, StatusBytesAreCutOff) {
  const Bytes bytes = {1, 0x60, 7, 8};
  for (std::size_t count = 0; count <= bytes.size(); ++count) {
    const auto rest = CutFtdiStatus(std::span(bytes).first(count));
    EXPECT_EQ(rest.size(), count < kFtdiStatusBytes ? 0 : count - kFtdiStatusBytes);
  }
}

FalconReport DrawReport(std::mt19937_64& random) {
  const auto number = [&] { return static_cast<int>(random() % 65536) - 32768; };
  return {{number(), number(), number()},
          static_cast<std::uint8_t>(random() % 16),
          static_cast<std::uint8_t>(random() % 8)};
}

TEST(FalconPacket, PacketsDamagedOnceEach) {
  // At most one fault per packet: a byte dropped, a byte doubled, the end cut off, the whole packet lost or doubled,
  // bytes inserted before it, or a byte changed to one that is invalid there. All of these can be detected: every
  // accepted packet was sent, and every undamaged packet is accepted, whatever preceded it.
  std::mt19937_64 random(11);
  FalconPacketStream stream;
  std::int64_t damaged = 0;
  std::int64_t accepted = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    const FalconPacket sent = Pack(DrawReport(random));
    Bytes bytes(sent.begin(), sent.end());
    const auto at = static_cast<std::ptrdiff_t>(random() % bytes.size());
    std::size_t max_found = 1;
    bool whole = true;
    switch (random() % 14) {
      case 0:
        bytes.erase(bytes.begin() + at);
        whole = false;
        break;
      case 1:
        // If a bracket is doubled, the packet is still valid with either copy.
        bytes.insert(bytes.begin() + at, bytes[static_cast<std::size_t>(at)]);
        whole = at == 0 || at == 15;
        break;
      case 2:
        bytes.resize(static_cast<std::size_t>(at));
        whole = false;
        break;
      case 3:
        bytes.clear();
        whole = false;
        break;
      case 4:
        bytes.insert(bytes.end(), sent.begin(), sent.end());
        max_found = 2;
        break;
      case 5:
        for (std::uint64_t k = random() % 40; k > 0; --k) bytes.insert(bytes.begin(), std::uint8_t(random() % 60));
        break;
      case 6:
        bytes[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(at == 14 ? '>' : random() % 0x41);
        whole = bytes[static_cast<std::size_t>(at)] == sent[static_cast<std::size_t>(at)];
        break;
      default:
        break;
    }
    std::size_t found = 0;
    for (const std::uint8_t byte : bytes) {
      if (!stream.Put(byte) || !UnpackReport(stream.packet())) continue;
      ++found;
      ASSERT_EQ(stream.packet(), sent) << i;
    }
    ASSERT_LE(found, max_found) << i;
    // A bracket left over from the previous packet may replace a missing one.
    ASSERT_TRUE(found > 0 || !whole) << i;
    damaged += whole ? 0 : 1;
    accepted += found > 0 ? 1 : 0;
  }
  EXPECT_GT(damaged, 0.3 * cases);
  EXPECT_GT(accepted, 0.6 * cases);
}

TEST(FalconPacket, PacketsDamagedInAnyWay) {
  // There may be any number of faults: bytes changed to any value, packets cut or merged. An accepted packet then has
  // the right form, but may never have been sent, because a nibble that was changed to another valid one cannot be
  // detected. The stream resynchronises at once: of two good packets in a row, both are accepted, whatever preceded
  // them.
  std::mt19937_64 random(12);
  FalconPacketStream stream;
  std::int64_t forged = 0;
  std::int64_t accepted = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    const FalconPacket sent = Pack(DrawReport(random));
    Bytes bytes(sent.begin(), sent.end());
    const bool good = i % 4 >= 2;
    for (std::uint64_t faults = good ? 0 : random() % 6; faults > 0 && !bytes.empty(); --faults) {
      const auto at = static_cast<std::ptrdiff_t>(random() % bytes.size());
      switch (random() % 4) {
        case 0:
          bytes.erase(bytes.begin() + at);
          break;
        case 1:
          bytes.insert(bytes.begin() + at, static_cast<std::uint8_t>(random()));
          break;
        case 2:
          bytes.resize(static_cast<std::size_t>(at));
          break;
        default:
          bytes[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(random());
          break;
      }
    }
    bool found = false;
    for (const std::uint8_t byte : bytes) {
      if (!stream.Put(byte)) continue;
      ASSERT_EQ(stream.packet().front(), '<');
      ASSERT_EQ(stream.packet().back(), '>');
      const std::optional<FalconReport> report = UnpackReport(stream.packet());
      if (!report) continue;
      ++accepted;
      // The reserved byte is not checked.
      FalconPacket again = Pack(*report);
      again[14] = stream.packet()[14];
      ASSERT_EQ(again, stream.packet());
      if (stream.packet() == sent) {
        found = true;
      } else {
        ++forged;
      }
    }
    ASSERT_TRUE(found || !good) << i;
  }
  EXPECT_GT(accepted, 0.5 * cases);
  // Some forged packets are accepted, which is why the driver checks for jumps.
  EXPECT_GT(forged, 0);
  EXPECT_LT(forged, accepted / 20);
}

TEST(FalconPacket, CountsLostBytes) {
  FalconPacketStream stream;
  const FalconPacket packet = Pack(FalconReport{{1, 2, 3}, 0, 7});
  const auto put = [&](std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) stream.Put(byte);
  };
  put(packet);
  EXPECT_EQ(stream.lost_bytes(), 0U);
  put(std::span(packet).first(9));
  put(packet);
  EXPECT_EQ(stream.lost_bytes(), 9U);
  put(std::span(packet).last(5));
  EXPECT_EQ(stream.lost_bytes(), 14U);
}

}  // namespace
}  // namespace kerf
