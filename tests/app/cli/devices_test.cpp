// Tests of kerf devices and kerf bench devices, run as programs, whatever is connected to this machine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;
using testing::StartsWith;

class DevicesCommand : public test::ProgramTest {};

TEST_F(DevicesCommand, WorksWithoutDevices) {
  const ProgramResult text = Kerf("devices");
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_EQ(text.err, "");
  const ProgramResult result = Kerf("devices --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["schema"], 1);
  EXPECT_TRUE(json["devices"].is_array());
  ASSERT_GE(json["known"].size(), 4U);
  for (const Json& known : json["known"]) {
    EXPECT_THAT(text.out, HasSubstr(known["kind"].get<std::string>()));
    EXPECT_EQ(known["makes_force"], known["kind"] != "spacemouse");
  }
}

TEST_F(DevicesCommand, PrintsValidUdevRules) {
  const ProgramResult result = Kerf("devices --udev-rules");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  std::istringstream lines(result.out);
  int rules = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    ++rules;
    EXPECT_THAT(line, StartsWith("SUBSYSTEM==\"usb\", "));
    EXPECT_THAT(line, HasSubstr("TAG+=\"uaccess\""));
  }
  EXPECT_GE(rules, 3);
  EXPECT_THAT(result.out, HasSubstr("sudo tee /etc/udev/rules.d/70-kerf.rules"));
  EXPECT_THAT(result.out, HasSubstr("\"0403\", ATTR{idProduct}==\"cb48\""));
}

TEST_F(DevicesCommand, ProfilesShowTheScalingOf28Newtons) {
  const ProgramResult result = Kerf("devices --profiles --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["expected_peak_N"], 28.0);
  bool seen = false;
  for (const Json& row : json["profiles"]) {
    if (row["profile"] != "omni") continue;
    seen = true;
    EXPECT_NEAR(row["scale"].get<double>(), 3.3 / 28, 1e-6);
    EXPECT_NEAR(row["friction_hides_below_N"].get<double>(), 0.26 * 28 / 3.3, 1e-6);
    EXPECT_NEAR(row["for_ever_share"].get<double>(), 0.88 / 3.3, 1e-6);
  }
  EXPECT_TRUE(seen);
  EXPECT_THAT(Kerf("devices --profiles").out, HasSubstr("0.118"));
  EXPECT_THAT(Kerf("devices --profiles --peak 14").out, HasSubstr("0.236"));
  EXPECT_THAT(Kerf("devices --profiles --markdown").out, StartsWith("| profile | "));
}

TEST_F(DevicesCommand, RefusesIncompatibleOptions) {
  for (const char* wrong : {"devices --peak 28", "devices --markdown", "devices --udev-rules --json",
                            "devices --profiles --udev-rules", "devices --profiles --peak 0", "devices x"}) {
    EXPECT_EQ(Kerf(wrong).code, 2) << wrong;
  }
}

TEST_F(DevicesCommand, BenchTimesModelsAndWritesTheReport) {
  const ProgramResult result = Kerf("bench devices --models-only --rounds 200 --json -o out.json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const Json json = Json::parse(Slurp(folder_ / "out.json"));
  ASSERT_EQ(json["exchanges"].size(), 3U);
  for (const Json& row : json["exchanges"]) {
    EXPECT_EQ(row["exchanges"], 200);
    EXPECT_EQ(row["samples"], 200);
    EXPECT_EQ(row["bad"], 0);
    EXPECT_EQ(row["way"], "in process");
    EXPECT_LE(row["p50_us"], row["p999_us"]);
  }
  EXPECT_EQ(Kerf("bench devices --rounds 1").code, 2);
  Write("short.bin", "no firmware");
  const ProgramResult firmware = Kerf("bench devices --falcon-firmware short.bin");
  EXPECT_EQ(firmware.code, 1);
  EXPECT_THAT(firmware.err, HasSubstr("short.bin: has 11 bytes and can't be Falcon firmware"));
}

}  // namespace
}  // namespace kerf
