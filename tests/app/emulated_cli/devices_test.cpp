// The unmodified program on a machine with emulated devices.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "emulated_program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::HasSubstr;

class EmulatedDevices : public test::EmulatedProgram {
 protected:
  /// Returns the device that `kerf devices` finds; there must be exactly one.
  Json Find(const std::string& options) const {
    const ProgramResult result = KerfWith(options, "devices --json");
    EXPECT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(result.out);
    EXPECT_EQ(json["devices"].size(), 1U);
    EXPECT_EQ(Report()["unknown_calls"], 0);
    return json["devices"].empty() ? Json() : json["devices"][0];
  }
};

TEST_F(EmulatedDevices, AreFoundAndReady) {
  for (const std::string kind : {"falcon", "wooden", "spacemouse"}) {
    const Json found = Find("--firmware-there --device " + kind);
    EXPECT_EQ(found["kind"], kind);
    EXPECT_EQ(found["device"], kind);
    EXPECT_EQ(found["state"], "ready") << found;
    EXPECT_EQ(found["node"], "/dev/bus/usb/001/004");
    EXPECT_THAT(found["where"].get<std::string>(), HasSubstr("1-1 ("));
  }
}

TEST_F(EmulatedDevices, EachProblemHasARemedy) {
  struct Case {
    const char* options;
    const char* state;
    const char* problem;
    const char* remedy;
  };
  for (const Case& c :
       {Case{"", "no_firmware", "no firmware", "--falcon-firmware FILE"},
        Case{"--no-permission", "no_permission", "/dev/bus/usb/001/004 can't be opened", "kerf devices --udev-rules"},
        Case{"--driver cdc_acm", "busy", "the kernel driver cdc_acm uses it", "1-1:1.0/driver/unbind"},
        Case{"--driver ftdi_sio", "no_firmware", "no firmware", "--falcon-firmware FILE"},
        Case{"--device wooden --driver usbhid --driver-holds", "busy", "usbhid", "unbind"},
        Case{"--device wooden --silent-at 0", "failed", "no reports", "plug it in again"}}) {
    const Json found = Find(c.options);
    EXPECT_EQ(found["state"], c.state) << c.options;
    EXPECT_THAT(found["problem"].get<std::string>(), HasSubstr(c.problem)) << c.options;
    EXPECT_THAT(found["remedy"].get<std::string>(), HasSubstr(c.remedy)) << c.options;
  }
  const ProgramResult text = KerfWith("", "devices");
  EXPECT_THAT(text.out, HasSubstr("no firmware"));
  EXPECT_THAT(text.out, HasSubstr("--falcon-firmware FILE"));
}

// The bench uploads the firmware; only the answers are checked.
TEST_F(EmulatedDevices, BenchExchangesThroughLibusb) {
  WriteFirmware();
  // The hand is at rest, and the timeout is a second per exchange, so no exchange fails even if the machine stalls.
  const ProgramResult result =
      KerfWith("--firmware firmware.bin --hand still --no-homing",
               "bench devices --rounds 1000 --timeout-ms 1000 --falcon-firmware firmware.bin --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json row = Json::parse(result.out)["exchanges"].back();
  EXPECT_EQ(row["device"], "falcon");
  EXPECT_EQ(row["way"], "libusb");
  EXPECT_EQ(row["failure"], "");
  EXPECT_EQ(row["exchanges"], 1000);
  EXPECT_EQ(row["bad"], 0);
  EXPECT_EQ(row["no_answer"], 0);
  EXPECT_EQ(row["samples"], 1000);
  const Json report = Report();
  EXPECT_EQ(report["uploads"], 1);
  EXPECT_EQ(report["firmware_bytes"], 7324);
  EXPECT_EQ(report["peak_force_N"], 0.0);
  EXPECT_EQ(report["homing_bit_was_off"], false);
}

TEST_F(EmulatedDevices, UnpluggingDuringTheMeasurementIsReported) {
  const ProgramResult result =
      KerfWith("--firmware-there --homed --unplug-after 200", "bench devices --rounds 100000 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json row = Json::parse(result.out)["exchanges"].back();
  EXPECT_EQ(row["failure"], "the device was unplugged");
  EXPECT_GT(row["samples"], 0);
}

TEST_F(EmulatedDevices, TheProgramsExitCodeIsPassedOn) {
  EXPECT_EQ(KerfWith("", "devices --nonsense").code, 2);
  EXPECT_EQ(KerfWithin("'" KERF_EMULATE_USB "' -- sh -c 'kill -TERM $$' ", "").code, 128 + 15);
  EXPECT_EQ(KerfWithin("'" KERF_EMULATE_USB "' -- /no/such/program ", "").code, 127);
  EXPECT_EQ(KerfWithin("'" KERF_EMULATE_USB "' --device violin -- ", "").code, 2);
}

}  // namespace
}  // namespace kerf
