// Cuts through a bar with an emulated Falcon and the unmodified program. This tests hand, USB, homing, force and bone
// together.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "emulated_program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::HasSubstr;
using testing::Not;

// Settings of the device that are only for the simulated hand; kerf determines them itself.
constexpr char kDevice[] = R"(
[device]
profile = "falcon"
delay_ticks = 2
)";
// The blade of 0.5 mm cuts through 3 x 4 mm. The hand yields sideways as far as its spring allows, and voxels of 0.2 mm
// resolve the walls, so at most one more voxel on either side is removed.
constexpr double kKerf_mm3 = 0.5 * 3 * 4;
constexpr double kMaxKerf_mm3 = (0.5 + 2 * 0.2) * 3 * 4;
constexpr int kMaxTries = 5;

class CutWithAFalcon : public test::EmulatedProgram {
 protected:
  /// Runs until Ctrl-C after 9 s of the hand's motion, however long the machine takes for that.
  ProgramResult Cut(const std::string& options) {
    WriteFirmware();
    const std::string bar = test::Slurp(KERF_SOURCE_DIR "/tests/support/cut_bar.toml");
    Write("bar.toml", bar);
    // The path is deeper than necessary, because motion of the hand while the program is stalled does not move the
    // tool.
    constexpr char kEnd[] = "end_mm = [0.0, 0.0, 0.5]";
    std::string deeper = bar;
    Write("hand.toml", deeper.replace(bar.find(kEnd), sizeof(kEnd) - 1, "end_mm = [0.0, 0.0, -1.5]") + kDevice);
    // After each stall the device outputs no force for a moment, perhaps just when the force is largest. The run is
    // then repeated.
    ProgramResult result;
    for (int tries = 0; tries < kMaxTries; ++tries) {
      std::filesystem::remove(folder_ / "cut.kerf");
      result = KerfWith(
          "--firmware firmware.bin --scene hand.toml --interrupt-on-way 9 " + options,
          "loop bar.toml --device falcon --falcon-firmware firmware.bin --record cut.kerf --json --seconds 500");
      if (result.code != 0) break;
      const Json json = Json::parse(result.out);
      if (!HasStalled(json) || IsAllSent(json)) break;
    }
    return result;
  }

  static bool HasStalled(const Json& json) {
    const Json& served = json["served"];
    return served["silences"] != 0 || served["loop_stood_still"] != 0 || served["round_stood_still"] != 0;
  }
  static bool IsAllSent(const Json& json) {
    return json["served"]["largest_sent_N"].get<double>() >= 0.97 * json["force"]["largest_N"].get<double>();
  }

  /// Expects a complete cut within the limit of force, no force at the end, and a bit-identical replay.
  void ExpectCutThrough(const ProgramResult& result) const {
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(result.out);
    EXPECT_EQ(json["pieces"].size(), 2U) << json["pieces"];
    const double removed_mm3 = json["removed_mm3"];
    EXPECT_GT(removed_mm3, 0.9 * kKerf_mm3);
    EXPECT_LT(removed_mm3, kMaxKerf_mm3);
    const Json report = Report();
    EXPECT_TRUE(report["homed"]);
    EXPECT_FALSE(report["homing_bit_was_off"]);
    EXPECT_EQ(report["unknown_calls"], 0);
    EXPECT_EQ(report["motors_at_end"], Json({0, 0, 0}));
    // The force of the motors is the one that the loop requested and the gate passed, except for one motor count (5 mN)
    // and the change of leverage while the handle moves for a round or two.
    EXPECT_EQ(json["served"]["leaps"], 0) << json["served"];
    EXPECT_GT(json["served"]["rounds"], 1000);
    const double asked_N = json["force"]["largest_N"];
    const double sent_N = json["served"]["largest_sent_N"];
    EXPECT_GT(asked_N, 0.1);
    EXPECT_LE(sent_N, asked_N * (1 + 1e-6));
    // On a machine that stalled in every try, the largest force may not have reached the motors.
    EXPECT_TRUE(IsAllSent(json) || HasStalled(json)) << json["served"];
    const double felt_N = report["peak_force_N"];
    EXPECT_LE(felt_N, 0.005 + 1.03 * sent_N) << json["served"];
    EXPECT_TRUE(felt_N >= 0.97 * sent_N - 0.005 || HasStalled(json)) << felt_N << json["served"];
    const ProgramResult replay = Kerf("replay cut.kerf --verify");
    EXPECT_EQ(replay.code, 0) << replay.err;
    EXPECT_THAT(replay.out, HasSubstr("bit-identical to the recording"));
  }
};

TEST_F(CutWithAFalcon, CutsThroughTheBar) {
  const ProgramResult result = Cut("");
  ExpectCutThrough(result);
  EXPECT_EQ(Report()["uploads"], 1);
  EXPECT_THAT(result.err, HasSubstr("pull the Falcon's grip all the way out"));
  EXPECT_THAT(result.err, Not(HasSubstr("is gone")));
}

// From 0.5 mm above the bar, the hand needs 0.3 s to reach it and at least 2 s more to cut through. It has cut 1.45 mm
// of the bar's 3 mm when it waits for the device to be unplugged; it cuts the rest afterwards.
TEST_F(CutWithAFalcon, ContinuesAfterUnpluggingWhenTheUserConfirms) {
  const ProgramResult result = Cut("--unplug-on-way 1.3 --plug-in-later 1.5");
  ExpectCutThrough(result);
  const Json report = Report();
  EXPECT_EQ(report["uploads"], 2);
  EXPECT_NEAR(report["unplugged_on_way_s"].get<double>(), 1.3, 0.01);  // to one step of the hand
  EXPECT_GT(report["way_s"].get<double>(), 8.9);
  EXPECT_THAT(result.err, HasSubstr("is gone: no force"));
  EXPECT_THAT(result.err, HasSubstr("is connected again; press a button"));
}

/// A Falcon pushes upwards while the program receives signals.
class ForceOfAFalcon : public test::EmulatedProgram {
 protected:
  ProgramResult Signal(const std::string& signals) const {
    Write("push.sh", "'" KERF_PROGRAM
                     "' device test falcon --up --buttons 0 2> said.txt & kerf=$!\n"
                     "until [ -e felt ]; do kill -0 $kerf && sleep 0.1 || exit 1; done; rm felt\n"
                     "for signal in " +
                         signals + "; do kill -$signal $kerf; done; wait $kerf\n");
    return KerfWithin("'" KERF_EMULATE_USB "' --report report.json --felt felt --firmware-there --homed -- sh push.sh",
                      "");
  }
  bool IsLost() const {
    return test::Slurp(folder_ / "said.txt").find("was lost during the force test") != std::string::npos;
  }
};

TEST_F(ForceOfAFalcon, EndsHoweverTheProgramEnds) {
  for (const std::string signals : {"TERM", "TERM TERM", "HUP TERM", "SEGV", "USR1", "XCPU"}) {
    ProgramResult result;
    Json report;
    for (int tries = 0; tries < kMaxTries; ++tries) {
      result = Signal(signals);
      report = Report();
      // If the machine stalled before the force was large, the program has ended by itself, which is correct.
      if (report["peak_force_N"] > 0.5 || !IsLost()) break;
    }
    EXPECT_NE(result.code, 0) << signals;
    EXPECT_GT(report["peak_force_N"], 0.5) << signals;
    EXPECT_EQ(report["motors_at_end"], Json({0, 0, 0})) << signals;
  }
}

}  // namespace
}  // namespace kerf
