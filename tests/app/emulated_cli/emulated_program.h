// Runs the unmodified program on a machine with emulated devices.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "support/program.h"
#include "test_paths.h"

namespace kerf::test {

class EmulatedProgram : public ProgramTest {
 protected:
  /// Runs `kerf` with these options under emulate_usb, which writes a report of the device.
  ProgramResult KerfWith(const std::string& options, const std::string& arguments) const {
    return KerfWithin("'" KERF_EMULATE_USB "' --report report.json " + options + " -- ", arguments);
  }
  nlohmann::json Report() const { return nlohmann::json::parse(Slurp(folder_ / "report.json")); }
  /// Writes bytes in place of a Falcon's firmware, which is not available here.
  void WriteFirmware() const {
    std::string firmware(7324, '\0');
    for (std::size_t i = 0; i < firmware.size(); ++i) firmware[i] = static_cast<char>(i * 7 + i / 251);
    Write("firmware.bin", firmware);
  }
};

}  // namespace kerf::test
