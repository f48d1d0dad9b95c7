// Tests of kerf loop, unmodified, with emulated devices other than the Falcon, and with a Falcon that stops answering
// during a cut.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <optional>

#include "emulated_program.h"
#include "support/block_scene.h"
#include "support/forces_csv.h"
#include "support/running.h"
#include "support/session_files.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::At;
using test::ForceRow;
using test::ProgramResult;
using test::Running;
using testing::HasSubstr;
using testing::Not;

// A block on the right, into which the disc cuts sideways.
const std::string kBlockToTheRight =
    test::BlockToml({40, 4, 3}, 0.2) + test::SawToml(12, 2, 16) +
    test::StrokeToml({-26.5, 0, -1.5}, {-20, 0, -1.5}, 1.5, {0, 1, 0}) +
    "[force]\nlaw = \"hertz_chip\"\n[device]\nexpected_peak_N = 5.0\n[output]\npictures = false\n";
constexpr double kStart_mm = -26.5;
constexpr double kGap_mm = 0.5;

class SessionWithADevice : public test::EmulatedProgram {
 protected:
  std::string Command(const std::string& options, const std::string& arguments) const {
    return "'" KERF_EMULATE_USB "' --report report.json " + options + " -- '" KERF_PROGRAM "' " + arguments;
  }
  /// Expects that the tool followed the handle into the block and no farther, and that the recording replays
  /// identically.
  void ExpectCutToTheRight(Running& kerf) const {
    ASSERT_EQ(kerf.WaitForEnd(), 0) << kerf.err();
    const std::vector<ForceRow> rows = test::ReadForces(folder_ / "out/forces.csv");
    ASSERT_FALSE(rows.empty());
    EXPECT_NEAR(rows.front().at("handle_x_mm"), kStart_mm, 0.5);
    double largest_mm = kStart_mm;
    for (const ForceRow& row : rows) {
      largest_mm = std::fmax(largest_mm, row.at("tool_x_mm"));
      // The bone holds the tool back; it is never far ahead of the handle.
      ASSERT_LT(row.at("tool_x_mm"), row.at("handle_x_mm") + 0.2) << row.at("time_s");
    }
    EXPECT_GT(largest_mm, kStart_mm + kGap_mm + 0.2);
    EXPECT_GT(Json::parse(kerf.out())["removed_mm3"], 0.1);
    ExpectSameAgain();
    EXPECT_EQ(Report()["unknown_calls"], 0);
  }
  void ExpectSameAgain() const {
    const ProgramResult replay = Kerf("replay cut.kerf --verify");
    EXPECT_EQ(replay.code, 0) << replay.err;
    EXPECT_THAT(replay.out, HasSubstr("bit-identical to the recording"));
  }
};

TEST_F(SessionWithADevice, WoodenHapticsCutsAndOutputsForce) {
  Write("block.toml", kBlockToTheRight);
  // The hand moves to the right for seconds, so slowly at first that the handle counts as at rest. If the machine
  // stalls repeatedly, the force never becomes large, and the run is repeated.
  std::optional<Running> kerf;
  for (int tries = 0; tries < 5 && !Exists("felt"); ++tries) {
    kerf.reset();
    std::filesystem::remove(folder_ / "cut.kerf");
    kerf.emplace(folder_, At::kNoTerminal,
                 Command("--device wooden --hand line --radius 20 --period 40 --hand-model H4 --felt felt",
                         "loop block.toml --device wooden --seconds 300 --json -o out --record cut.kerf"));
    const auto late = std::chrono::steady_clock::now() + std::chrono::seconds(15);
    kerf->Until([&] { return Exists("felt") || std::chrono::steady_clock::now() > late; });
  }
  ASSERT_TRUE(Exists("felt")) << kerf->err();
  EXPECT_THAT(kerf->err(), HasSubstr("wooden: hold the handle still in the middle"));
  kerf->Signal(SIGINT);
  ExpectCutToTheRight(*kerf);
  const Json report = Report();
  EXPECT_GT(report["peak_force_N"], 0.5);
  EXPECT_LT(report["peak_force_N"], 5);  // the device's peak force
  EXPECT_EQ(report["currents_at_end_mA"], Json({0.0, 0.0, 0.0}));
}

TEST_F(SessionWithADevice, ASpaceMouseCuts) {
  Write("block.toml", kBlockToTheRight);
  // The hand moves half of the cap's range to the right in ten seconds.
  Running kerf(folder_, At::kNoTerminal,
               Command("--device spacemouse --hand line --radius 10 --period 20",
                       "loop block.toml --device spacemouse --seconds 2.5 --json -o out --record cut.kerf"));
  ExpectCutToTheRight(kerf);
}

class StallOfAFalcon : public SessionWithADevice {
 protected:
  void SetUp() override {
    SessionWithADevice::SetUp();
    // The bone is large enough for eight seconds of cutting, and the device outputs the whole force.
    const std::string block = test::BlockToml({8, 8, 9}, 0.25) + test::SawToml(24, 2, 16) +
                              test::StrokeToml({0, 0, 12.5}, {0, 0, 4}, 1, {1, 0, 0}) + R"([hand]
model = "H4"
[output]
pictures = false
[device]
profile = "falcon"
expected_peak_N = 5.0
)";
    Write("block.toml", block);
    Write("hand.toml", block + "delay_ticks = 2\n");
  }
  std::string MakeCommand(int silent_at_s) const {
    return Command("--firmware-there --homed --scene hand.toml --leaves-buttons --felt felt --silent-at " +
                       std::to_string(silent_at_s) + " --loud-at " + std::to_string(silent_at_s + 1.5),
                   "loop block.toml --device falcon --seconds 300 --json -o out --record cut.kerf");
  }
};

TEST_F(StallOfAFalcon, EndsTheForceUntilTheUserConfirms) {
  // The tool must be in the bone before the device stops answering; on a slow machine this takes longer.
  std::optional<Running> kerf;
  for (int at_s = 4; at_s < 16; at_s = at_s * 3 / 2) {
    kerf.reset();
    for (const char* file : {"cut.kerf", "felt"}) std::filesystem::remove(folder_ / file);
    kerf.emplace(folder_, At::kKeys, MakeCommand(at_s));
    const auto late = std::chrono::steady_clock::now() + std::chrono::seconds(at_s + 6);
    kerf->Until([&] { return kerf->Said("is connected again") || std::chrono::steady_clock::now() > late; });
    if (Exists("felt") && kerf->Said("falcon: does not answer: no force")) break;
  }
  ASSERT_TRUE(kerf->UntilSaid("is connected again; press a button on it, or agree here to enable the force again"))
      << kerf->err();
  // The hand presses no button, so Enter is accepted as the answer. If the machine stalls, the device may not answer at
  // that moment. Enter then has no effect, and a user presses it again.
  EXPECT_THAT(kerf->err(), testing::EndsWith("to enable the force again\n"));
  const auto is_in_the_hand = [&] {
    const std::string err = kerf->err();
    return err.find("in the hand", err.find("is connected again")) != std::string::npos;
  };
  for (int tries = 0; tries < 10 && !is_in_the_hand(); ++tries) {
    kerf->Type("\n");
    test::WaitUntil(is_in_the_hand, std::chrono::seconds(5));
  }
  ASSERT_TRUE(is_in_the_hand()) << kerf->err();
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(test::WaitForProgress(*kerf, folder_ / "cut.kerf")) << kerf->err();
  kerf->Signal(SIGINT);
  ASSERT_EQ(kerf->WaitForEnd(), 0) << kerf->err();
  EXPECT_THAT(kerf->err(), HasSubstr("falcon: does not answer: no force"));
  EXPECT_THAT(kerf->err(), Not(HasSubstr("is gone")));

  // There is force, then none while the device was silent (by the machine's clock) and until the confirmation, and then
  // force again.
  double since_s = -1;
  double longest_s = 0;
  for (const ForceRow& row : test::ReadForces(folder_ / "out/forces.csv")) {
    if (row.at("device_x_N") == 0 && row.at("device_y_N") == 0 && row.at("device_z_N") == 0) continue;
    if (since_s >= 0) longest_s = std::fmax(longest_s, row.at("time_s") - since_s);
    since_s = row.at("time_s");
  }
  EXPECT_GT(longest_s, 1) << Report() << kerf->out().substr(0, 300);
  const Json json = Json::parse(kerf->out());
  EXPECT_GE(json["served"]["silences"], 1);
  EXPECT_GT(json["removed_mm3"], 0.1);
  const Json report = Report();
  EXPECT_GT(report["peak_force_N"], 0);
  EXPECT_EQ(report["motors_at_end"], Json({0, 0, 0}));
  EXPECT_EQ(report["unknown_calls"], 0);
  ExpectSameAgain();
}

}  // namespace
}  // namespace kerf
