// What the Falcon and the host say to each other once the firmware runs: 16 bytes each way, as characters.
//
//   '<'  12 nibbles: three numbers of 16 bits, the lowest nibble first, each nibble + 0x41  state + 0x41  reserved  '>'
//
// Source: libnifalcon, include/falcon/firmware/FalconFirmwareNovintSDK.h and its .cpp (revision f7c727a). There is no
// checksum and no number of the packet. What the format does show: length, the two brackets (which can't occur inside),
// nibbles and state out of range. What it can't: a nibble or a state that became another valid one, a whole packet that
// is lost, old or doubled. The driver looks for leaps for that reason. All is tick-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "device/devices/falcon/falcon_kinematics.h"

namespace kerf {

inline constexpr std::size_t kFalconPacketBytes = 16;
using FalconPacket = std::array<std::uint8_t, kFalconPacketBytes>;

/// Lamps of the grip, by libnifalcon's enum (a comment there has them otherwise). Colours not verified.
enum FalconLamp : std::uint8_t { kFalconGreen = 2, kFalconBlue = 4, kFalconRed = 8 };

struct FalconCommand {
  std::array<int, 3> motors{};  // -32768 to 32767
  bool homing = true;           // must be set in every packet, or the encoders' zero is not looked for
  std::uint8_t lamps = 0;
};

struct FalconReport {
  FalconCounts counts{};
  std::uint8_t buttons = 0;  // bit 0 plus (right), 1 forward, 2 centre, 3 minus (left)
  std::uint8_t homed = 0;    // a bit for each encoder; 7: all
};
inline constexpr std::uint8_t kFalconAllHomed = 7;

FalconPacket Pack(const FalconCommand& command) noexcept;
FalconPacket Pack(const FalconReport& report) noexcept;
/// None when a byte is not what can stand in its place. The reserved byte may be anything but a bracket.
std::optional<FalconCommand> UnpackCommand(const FalconPacket& packet) noexcept;
std::optional<FalconReport> UnpackReport(const FalconPacket& packet) noexcept;

/// Finds packets in a stream of bytes that may be damaged in any way. A packet that arrives whole is always found,
/// whatever came before it.
class FalconPacketStream {
 public:
  /// True when this byte ends what has the form of a packet, which is then in packet().
  bool Put(std::uint8_t byte) noexcept;
  const FalconPacket& packet() const { return packet_; }
  void Forget() { length_ = 0; }
  /// Bytes that were in no packet, so far.
  std::uint64_t lost_bytes() const { return lost_; }

 private:
  FalconPacket packet_{};
  std::size_t length_ = 0;  // of what began with '<'
  std::uint64_t lost_ = 0;
};

/// The bytes behind the status bytes of one packet from an FT232.
std::span<const std::uint8_t> CutFtdiStatus(std::span<const std::uint8_t> usb_packet) noexcept;

}  // namespace kerf
