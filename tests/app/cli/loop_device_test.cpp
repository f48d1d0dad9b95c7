// Tests of kerf loop --device without a real device: simulated devices and refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "support/block_scene.h"
#include "support/forces_csv.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::MakeBlockScene;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

/// The disc moves straight down onto the block and into it, with its axis along x.
constexpr char kScript[] =
    "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
    "0,0,0,7.8,0.70710678118654757,0,0.70710678118654757,0\n"
    "0.5,0,0,7.3,0.70710678118654757,0,0.70710678118654757,0\n"
    "1.5,0,0,5.3,0.70710678118654757,0,0.70710678118654757,0\n";

class LoopDevices : public test::ProgramTest {
 protected:
  LoopDevices() : ProgramTest({{"s.toml", MakeBlockScene()}, {"script.csv", kScript}}) {}
  Json Loop(const std::string& arguments) const {
    const ProgramResult result = Kerf("loop s.toml --virtual --json " + arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? Json::parse(result.out) : Json();
  }
  /// Expects exit code 2 for wrong usage or 1 for a failure, with one message and no result.
  void ExpectFailure(int code, const std::string& arguments, const std::string& part) const {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, code) << arguments;
    EXPECT_THAT(result.err, HasSubstr(part)) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
};

TEST_F(LoopDevices, PlayedRecordingGivesABitIdenticalBone) {
  const Json recorded = Loop("--seconds 3 --record a.kerf -o first");
  const Json played = Loop("--seconds 3 --device recording:a.kerf -o second");
  EXPECT_GT(recorded.at("removed_mm3"), 0.1);
  for (const char* key : {"bone_hash", "force_hash", "removed_mm3"}) EXPECT_EQ(recorded.at(key), played.at(key)) << key;
  EXPECT_EQ(Slurp(folder_ / "first/forces.csv"), Slurp(folder_ / "second/forces.csv"));
  // At another rate the path is the same, but the values are not bit-identical.
  const Json faster = Loop("--seconds 3 --rate-hz 2000 --device recording:a.kerf");
  EXPECT_NE(recorded.at("force_hash"), faster.at("force_hash"));
  EXPECT_NEAR(recorded.at("removed_mm3").get<double>(), faster.at("removed_mm3").get<double>(),
              0.05 * recorded.at("removed_mm3").get<double>());
}

TEST_F(LoopDevices, ScriptFollowsItsTable) {
  const Json json = Loop("--seconds 2 --device script:script.csv -o out");
  EXPECT_GT(json.at("removed_mm3"), 0.1);
  const std::vector<test::ForceRow> rows = test::ReadForces(folder_ / "out/forces.csv");
  ASSERT_EQ(rows.size(), 2000U);
  double largest_N = 0;
  double largest_lag_mm = 0;
  for (const test::ForceRow& row : rows) {
    const double time_s = row.at("time_s");
    const double handle_z_mm = row.at("handle_z_mm");
    const double wanted_mm = time_s < 0.5 ? 7.8 - time_s : std::max(5.3, 7.3 - 2 * (time_s - 0.5));
    ASSERT_NEAR(handle_z_mm, wanted_mm, 1e-5) << time_s;  // five decimals are written
    ASSERT_EQ(row.at("handle_x_mm"), 0);
    largest_N = std::max(largest_N, row.at("device_z_N"));
    largest_lag_mm = std::max(largest_lag_mm, row.at("tool_z_mm") - handle_z_mm);
  }
  // The bone pushes back upwards through the coupling's spring.
  EXPECT_GT(largest_N, 0.05);
  EXPECT_GT(largest_lag_mm, 0.05);
  EXPECT_NEAR(json.at("force").at("largest_N").get<double>(), largest_N, 0.5 * largest_N);
  EXPECT_EQ(json.at("bone_hash"), Loop("--seconds 2 --device script:script.csv").at("bone_hash"));
}

// The script does not follow the scene's path, so the report counts no strokes along it.
TEST_F(LoopDevices, OnlyAHandThatFollowsThePathHasStrokes) {
  Loop("--seconds 2 --record path.kerf");
  Loop("--seconds 2 --device script:script.csv --record script.kerf");
  ASSERT_EQ(Kerf("replay path.kerf -o path").code, 0);
  ASSERT_EQ(Kerf("replay script.kerf -o script").code, 0);
  EXPECT_THAT(Slurp(folder_ / "path/report.md"), HasSubstr("times through the path."));
  EXPECT_THAT(Slurp(folder_ / "script/report.md"), testing::Not(HasSubstr("through the path")));
  EXPECT_EQ(Json::parse(Slurp(folder_ / "script/loop.json")).at("hand_strokes"), 0);
}

TEST_F(LoopDevices, DeviceNoneDoesNotMoveAndRemovesNothing) {
  const Json json = Loop("--seconds 0.5 --device none -o out");
  EXPECT_EQ(json.at("removed_mm3"), 0.0);
  const std::vector<test::ForceRow> rows = test::ReadForces(folder_ / "out/forces.csv");
  ASSERT_EQ(rows.size(), 500U);
  for (const test::ForceRow& row : rows) {
    ASSERT_EQ(Vec3(row.at("handle_x_mm"), row.at("handle_y_mm"), row.at("handle_z_mm")), Vec3(0, 0, 7.8));
  }
  // This also works in real time.
  EXPECT_EQ(Kerf("loop s.toml --seconds 0.1 --device none").code, 0);
}

TEST_F(LoopDevices, TruncatedRecordingIsPlayedToItsEndWithAWarning) {
  ASSERT_EQ(Kerf("loop s.toml --virtual --seconds 3 --record a.kerf").code, 0);
  const std::string whole = Slurp(folder_ / "a.kerf");
  Write("cut.kerf", whole.substr(0, whole.size() * 2 / 3));
  const ProgramResult played = Kerf("loop s.toml --virtual --seconds 0.2 --device recording:cut.kerf");
  EXPECT_EQ(played.code, 0);
  EXPECT_THAT(played.err, HasSubstr("the handle does not move in the missing parts"));
  Write("head.kerf", whole.substr(0, 40));
  ExpectFailure(1, "loop s.toml --virtual --device recording:head.kerf", "head.kerf: ");
}

TEST_F(LoopDevices, RefusesInputThatCannotBePlayed) {
  ExpectFailure(1, "loop s.toml --virtual --device script:no.csv", "no.csv: there is no such file");
  ExpectFailure(1, "loop s.toml --virtual --device recording:no.kerf", "no.kerf: there is no such file");
  ExpectFailure(1, "loop s.toml --virtual --device recording:s.toml", "s.toml: is not a kerf recording");
  ExpectFailure(2, "loop s.toml --virtual --device script:", "\"script:\" must be followed by a file name");
  ExpectFailure(2, "loop s.toml --virtual --device recording:", "must be followed by a file name");
  std::string text = kScript;
  text.replace(text.find("7.3"), 3, "nan");
  Write("nan.csv", text);
  ExpectFailure(1, "loop s.toml --virtual --device script:nan.csv",
                "nan.csv:3:9: z_mm = \"nan\" is not a finite number");
  ASSERT_EQ(Kerf("run s.toml -o run --record run.kerf").code, 0);
  ExpectFailure(1, "loop s.toml --virtual --device recording:run.kerf", "which has no handle");
  ExpectFailure(2, "loop s.toml --virtual --device none --motion-scale 2", "apply to a real device only");
  ExpectFailure(2, "loop s.toml --virtual --device none --left-handed", "apply to a real device only");
  ExpectFailure(2, "loop s.toml --virtual --device none --bridge 127.0.0.1", "apply to a real device only");
  ExpectFailure(2, "loop s.toml --device igtl", "\"igtl\" requires --igtl");
  ExpectFailure(2, "loop s.toml --motion-scale 2", "--motion-scale requires --device");
  ExpectFailure(2, "loop s.toml --bridge 127.0.0.1", "--bridge requires --device");
  ExpectFailure(2, "loop s.toml --wooden w.toml", "--wooden requires --device");
  ExpectFailure(2, "loop s.toml --falcon-firmware f.bin", "--falcon-firmware: requires --device falcon");
  ExpectFailure(2, "loop s.toml --virtual --device none --falcon-firmware f.bin", "requires --device falcon");
}

TEST_F(LoopDevices, RefusesInvalidDevices) {
  ExpectFailure(2, "loop s.toml --device flacon", "no device is called \"flacon\"; the nearest is \"falcon\"");
  ExpectFailure(2, "loop s.toml --virtual --device flacon", "the nearest is \"falcon\"");
  ExpectFailure(2, "loop s.toml --virtual --device falcon", "--virtual: can't be used with a real device");
  ExpectFailure(2, "loop s.toml --device falcon --motion-scale 0", "--motion-scale");
  ExpectFailure(2, "loop s.toml --device ''", "--device: must not be empty");
  ExpectFailure(2, "loop s.toml --device bridge --bridge ''", "--bridge: must not be empty");
  ExpectFailure(2, "loop s.toml --device wooden --wooden ''", "--wooden: must not be empty");
  ExpectFailure(2, "device test flacon", "NAME: no device is called \"flacon\"; the nearest is \"falcon\"");
  ExpectFailure(2, "loop s.toml --device falcon --bridge 127.0.0.1",
                "--bridge: is for the device \"bridge\", not for \"falcon\"");
  ExpectFailure(2, "device test wooden@1-2 --falcon-firmware f.bin",
                "--falcon-firmware: is for the device \"falcon\", not for \"wooden\"");
  ExpectFailure(2, "rehearse --device script:s.csv", "--device: \"script:s.csv\" works only with 'kerf loop'");
  const ProgramResult other = KerfWithin("KERF_FALCON_FIRMWARE=nofile", "loop s.toml --device spacemouse");
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err, testing::Not(HasSubstr("nofile")));
  ExpectFailure(2, "rehearse --device spacemouse --wooden w.toml", "--wooden: is for the device \"wooden\"");
  Write("firmware.bin", "0123456789");
  ExpectFailure(1, "loop s.toml --device falcon --falcon-firmware firmware.bin", "firmware.bin: has 10 bytes");
  ExpectFailure(2, "loop s.toml --device bridge --bridge 127.0.0.1:0", "the port '0' is not a number from 1 to 65535");
  ExpectFailure(2, "loop s.toml --device bridge --bridge 127.0.0.1:99999", "is not a number from 1 to 65535");
  ExpectFailure(2, "loop s.toml --device bridge --bridge 127.0.0.1:", "is not a number from 1 to 65535");
  ExpectFailure(1, "loop s.toml --device bridge --bridge 192.0.2.7:4000", "192.0.2.7 is not this machine");
  ExpectFailure(2, "loop s.toml --device bridge --bridge-elsewhere", "--bridge-elsewhere requires --bridge");
  Write("w.toml", "gears = 3\n");
  ExpectFailure(1, "loop s.toml --device wooden --wooden w.toml",
                "w.toml:1:1: unknown key \"gears\" in the file; the nearest valid key is \"gear\"");
  for (const char* device : {"none", "script:script.csv"}) {
    ExpectFailure(2, std::string("device test ") + device, "must be a connected device");
  }
  ExpectFailure(2, "device test flacon", "the nearest is \"falcon\"");
  ExpectFailure(2, "device test falcon --force 0.5", "valid range 0.01 to 0.2");
}

}  // namespace
}  // namespace kerf
