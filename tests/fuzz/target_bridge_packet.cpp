#include <algorithm>

#include "device/devices/bridge/bridge_packet.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(bridge_packet) {
  std::vector<std::uint8_t> packet(bytes.begin(), bytes.end());
  // Reads the packet as it is, and with the correct checksum, which a fuzzer would not find.
  for (const bool repaired : {false, true}) {
    if (repaired && packet.size() == kBridgeBytes) {
      const std::uint32_t sum = CalcCrc32(std::span(packet).first(kBridgeBytes - 4));
      for (std::size_t i = 0; i < 4; ++i) packet[kBridgeBytes - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
    }
    const auto header = ReadBridgeHeader(packet);
    if (!header) continue;
    const auto same = [&packet](const BridgeBytes& written) {
      return std::equal(written.begin(), written.end(), packet.begin());
    };
    if (const auto state = ReadBridgeState(packet)) {
      if (!IsValid(state->X_DH)) Finding("an invalid pose");
    }
    if (const auto command = ReadBridgeCommand(packet)) {
      const auto again = ReadBridgeCommand(WriteBridgeCommand(*header, *command));
      if (!again || again->f_D_N != command->f_D_N || again->valid_ms != command->valid_ms) {
        Finding("a command changes when it is written and read back");
      }
      const Vec3 f = CalcFieldForce(*command, {1, 2, 3}, {4, 5, 6}, 3);
      if (!(f.x * f.x + f.y * f.y + f.z * f.z <= 9.0001)) Finding("a force above the peak");
    }
    if (const auto description = ReadBridgeDescription(packet)) {
      const auto again = ReadBridgeDescription(WriteBridgeDescription(*header, *description));
      if (!again || again->name != description->name) Finding("a description changes when it is written and read back");
    }
    if (const auto refusal = ReadBridgeRefusal(packet)) {
      if (header->version == kBridgeVersion && !ReadBridgeRefusal(WriteBridgeRefusal(*header, *refusal))) {
        Finding("a written refusal can't be read back");
      }
    }
    if (header->kind == BridgeKind::kHello && header->version == kBridgeVersion && same(WriteBridgeHello(*header)) &&
        !ReadBridgeHeader(WriteBridgeBye(*header))) {
      Finding("a written bye can't be read back");
    }
  }
}

}  // namespace kerf::fuzz
