#include "device/devices/hid/hid_report.h"

#include <algorithm>
#include <array>

namespace kerf {

std::optional<HidReportSizes> ReadHidReportSizes(std::span<const std::uint8_t> descriptor) {
  // Items as in the HID specification 1.11, 6.2.2: a prefix of size, type and tag, followed by 0, 1, 2 or 4 bytes.
  constexpr std::uint8_t kLongItem = 0xfe;
  constexpr std::uint8_t kInput = 0x80, kOutput = 0x90, kReportSize = 0x74, kReportId = 0x84, kReportCount = 0x94;
  constexpr std::uint64_t kMaxBits = 1 << 20;
  HidReportSizes sizes;
  std::array<std::array<std::uint64_t, 256>, 2> bits{};  // sizes of input and output reports, per report id
  std::uint64_t size = 0;
  std::uint64_t count = 0;
  std::size_t id = 0;
  for (std::size_t at = 0; at < descriptor.size();) {
    const std::uint8_t prefix = descriptor[at];
    if (prefix == kLongItem) return std::nullopt;  // the specification defines no long items
    const std::size_t bytes = (prefix & 3) == 3 ? 4 : prefix & 3;
    if (at + 1 + bytes > descriptor.size()) return std::nullopt;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{descriptor[at + 1 + i]} << (8 * i);
    at += 1 + bytes;
    const auto item = static_cast<std::uint8_t>(prefix & 0xfc);
    if (item == kReportSize) size = value;
    if (item == kReportCount) count = value;
    if (item == kReportId) {
      if (value == 0 || value > 255) return std::nullopt;
      id = static_cast<std::size_t>(value);
      sizes.has_ids = true;
    }
    if (item != kInput && item != kOutput) continue;
    std::uint64_t& sum = bits[item == kInput ? 0 : 1][id];
    if (size > kMaxBits || count > kMaxBits || size * count > kMaxBits) return std::nullopt;
    sum += size * count;
    if (sum > kMaxBits) return std::nullopt;
  }
  sizes.input_bytes = static_cast<int>((*std::max_element(bits[0].begin(), bits[0].end()) + 7) / 8);
  sizes.output_bytes = static_cast<int>((*std::max_element(bits[1].begin(), bits[1].end()) + 7) / 8);
  return sizes;
}

}  // namespace kerf
