// Report sizes from a HID report descriptor.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace kerf {

struct HidReportSizes {
  int input_bytes = 0;  // size of the longest input report, without its id
  int output_bytes = 0;
  bool has_ids = false;
};

/// Returns nullopt if the bytes are not a report descriptor.
std::optional<HidReportSizes> ReadHidReportSizes(std::span<const std::uint8_t> descriptor);

}  // namespace kerf
