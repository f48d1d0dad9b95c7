// Packets between the Falcon's firmware and the host: 16 bytes in each direction, encoded as characters.
//
//   '<'  12 nibbles: three 16-bit numbers, lowest nibble first, each nibble + 0x41  state + 0x41  reserved  '>'
//
// Source: libnifalcon, include/falcon/firmware/FalconFirmwareNovintSDK.h and its .cpp (revision f7c727a). Packets have
// no checksum and no sequence number. These faults can be detected: a wrong length, wrong brackets (which cannot occur
// inside a packet), and nibbles or a state out of range. These cannot: a nibble or a state changed to another valid
// one, and a packet that is lost, old or repeated. The driver therefore checks for jumps. All functions are tick-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "device/devices/falcon/falcon_kinematics.h"

namespace kerf {

inline constexpr std::size_t kFalconPacketBytes = 16;
using FalconPacket = std::array<std::uint8_t, kFalconPacketBytes>;

/// Lamps of the grip, with the values of libnifalcon's enum (a comment there states others). The colours have not been
/// verified.
enum FalconLamp : std::uint8_t { kFalconGreen = 2, kFalconBlue = 4, kFalconRed = 8 };

struct FalconCommand {
  std::array<int, 3> motors{};  // -32768 to 32767
  bool homing = true;           // must be set in every packet; otherwise the encoders are not homed
  std::uint8_t lamps = 0;
};

struct FalconReport {
  FalconCounts counts{};
  std::uint8_t buttons = 0;  // bit 0: plus (right), bit 1: forward, bit 2: centre, bit 3: minus (left)
  std::uint8_t homed = 0;    // one bit per encoder; 7: all
};
inline constexpr std::uint8_t kFalconAllHomed = 7;

FalconPacket Pack(const FalconCommand& command) noexcept;
FalconPacket Pack(const FalconReport& report) noexcept;
/// Returns nullopt if a byte is invalid at its position. The reserved byte may be anything except a bracket.
std::optional<FalconCommand> UnpackCommand(const FalconPacket& packet) noexcept;
std::optional<FalconReport> UnpackReport(const FalconPacket& packet) noexcept;

/// Finds packets in a byte stream with arbitrary damage. A packet that arrives intact is always found, whatever
/// precedes it.
class FalconPacketStream {
 public:
  /// Returns true if this byte completes a well-formed packet, which is then in packet().
  bool Put(std::uint8_t byte) noexcept;
  const FalconPacket& packet() const { return packet_; }
  void Forget() { length_ = 0; }
  /// Number of bytes so far that did not belong to a packet.
  std::uint64_t lost_bytes() const { return lost_; }

 private:
  FalconPacket packet_{};
  std::size_t length_ = 0;  // bytes since '<'
  std::uint64_t lost_ = 0;
};

/// Returns the bytes after the status bytes in one packet from an FT232.
std::span<const std::uint8_t> CutFtdiStatus(std::span<const std::uint8_t> usb_packet) noexcept;

}  // namespace kerf
