#include "device/devices/falcon/falcon_packet.h"

#include <algorithm>

#include "device/devices/falcon/falcon_usb.h"

namespace kerf {
namespace {

constexpr std::uint8_t kOpen = '<';
constexpr std::uint8_t kClose = '>';
constexpr std::uint8_t kBase = 0x41;
constexpr std::size_t kState = 13;
constexpr std::size_t kReserved = 14;

FalconPacket PackNumbers(const std::array<int, 3>& numbers, unsigned state) {
  FalconPacket packet{};
  packet.fill(kBase);
  packet.front() = kOpen;
  packet.back() = kClose;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto bits = static_cast<unsigned>(std::clamp(numbers[i], -32768, 32767)) & 0xffffU;
    for (std::size_t k = 0; k < 4; ++k) {
      packet[1 + 4 * i + k] = static_cast<std::uint8_t>(kBase + ((bits >> (4 * k)) & 0xfU));
    }
  }
  packet[kState] = static_cast<std::uint8_t>(kBase + state);
  return packet;
}

struct Numbers {
  std::array<int, 3> numbers{};
  unsigned state = 0;
};

std::optional<Numbers> UnpackNumbers(const FalconPacket& packet, unsigned max_state) {
  if (packet.front() != kOpen || packet.back() != kClose) return std::nullopt;
  if (packet[kReserved] == kOpen || packet[kReserved] == kClose) return std::nullopt;
  Numbers all;
  for (std::size_t i = 0; i < 3; ++i) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const unsigned nibble = packet[1 + 4 * i + k] - unsigned{kBase};
      if (nibble > 0xf) return std::nullopt;
      bits |= nibble << (4 * k);
    }
    all.numbers[i] = static_cast<std::int16_t>(bits);
  }
  all.state = packet[kState] - unsigned{kBase};
  if (all.state > max_state) return std::nullopt;
  return all;
}

}  // namespace

FalconPacket Pack(const FalconCommand& command) noexcept {
  return PackNumbers(command.motors, (command.homing ? 1U : 0U) | (command.lamps & 0xeU));
}

FalconPacket Pack(const FalconReport& report) noexcept {
  return PackNumbers(report.counts, (report.buttons & 0xfU) | (report.homed & 7U) << 4);
}

std::optional<FalconCommand> UnpackCommand(const FalconPacket& packet) noexcept {
  const std::optional<Numbers> all = UnpackNumbers(packet, 0xf);
  if (!all) return std::nullopt;
  return FalconCommand{all->numbers, (all->state & 1U) != 0, static_cast<std::uint8_t>(all->state & 0xeU)};
}

std::optional<FalconReport> UnpackReport(const FalconPacket& packet) noexcept {
  const std::optional<Numbers> all = UnpackNumbers(packet, 0x7f);
  if (!all) return std::nullopt;
  return FalconReport{all->numbers, static_cast<std::uint8_t>(all->state & 0xfU),
                      static_cast<std::uint8_t>(all->state >> 4)};
}

bool FalconPacketStream::Put(std::uint8_t byte) noexcept {
  if (byte == kOpen) {
    lost_ += length_;
    packet_[0] = byte;
    length_ = 1;
    return false;
  }
  if (length_ == 0) {
    ++lost_;
    return false;
  }
  if ((length_ + 1 == kFalconPacketBytes) != (byte == kClose)) {
    lost_ += length_ + 1;
    length_ = 0;
    return false;
  }
  packet_[length_++] = byte;
  if (length_ < kFalconPacketBytes) return false;
  length_ = 0;
  return true;
}

std::span<const std::uint8_t> CutFtdiStatus(std::span<const std::uint8_t> usb_packet) noexcept {
  return usb_packet.subspan(std::min(usb_packet.size(), kFtdiStatusBytes));
}

}  // namespace kerf
