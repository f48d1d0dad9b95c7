// Waits for a session with a device.
#pragma once

#include <filesystem>
#include <string>

#include "support/running.h"

namespace kerf::test {

/// Waits until the loop has run for a while, as shown by the growth of its recording. Returns false if the program ends
/// first.
inline bool WaitForProgress(Running& kerf, const std::filesystem::path& recording) {
  const auto bytes = [&recording] {
    std::error_code none_yet;
    const std::uintmax_t size = std::filesystem::file_size(recording, none_yet);
    return none_yet ? 0 : size;
  };
  for (int i = 0; i < 2; ++i) {  // the first growth may be due to earlier work
    if (!kerf.Until([&, before = bytes()] { return bytes() > before; })) return false;
  }
  return true;
}

}  // namespace kerf::test
