#include "base/core/byte_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {

std::pair<std::string, std::string> FormatBytePair(double needed, double available) {
  const double larger = std::max(needed, available);
  const auto [unit_bytes, unit] = larger >= 1e9   ? std::pair(1e9, "GB")
                                  : larger >= 1e6 ? std::pair(1e6, "MB")
                                                  : std::pair(1e3, "kB");
  std::pair<std::string, std::string> text;
  for (int digits = 1; digits <= 9; ++digits) {
    text = {fmt::format("{:.{}f} {}", needed / unit_bytes, digits, unit),
            fmt::format("{:.{}f} {}", available / unit_bytes, digits, unit)};
    if (text.first != text.second) break;
  }
  return text;
}

}  // namespace kerf
