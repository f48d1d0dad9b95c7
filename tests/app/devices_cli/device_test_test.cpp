// Tests of kerf device test with and without a terminal. The test itself implements the far side of a bridge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "app/devices_cli/far_side.h"
#include "support/running.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::AreSame;
using test::At;
using test::FarSide;
using test::Running;
using testing::HasSubstr;
using testing::Not;

/// Force of the circle: a fifth of the far side's peak force.
constexpr double kCircle_N = 0.2 * FarSide::kPeak_N;
constexpr int kDeviceTestTries = 5;

class DeviceTest : public test::ProgramTest {
 protected:
  /// Returns true if a device failed because the machine stalled. That result is correct, and the run is then repeated.
  static bool FailedByStandingStill(Running& kerf) {
    return kerf.WaitForEnd() == 1 && (kerf.Said("was lost during the force test") ||
                                      kerf.Said("rounds had no valid answer") || kerf.Said("samples arrived in"));
  }
  static std::string Arguments(const FarSide& far, const std::string& more) {
    return "'" KERF_PROGRAM "' device test bridge --bridge " + far.where() + " " + more;
  }
};

TEST_F(DeviceTest, AnyKeyEndsTheTestAndTheForce) {
  std::optional<FarSide> far;
  std::optional<Running> kerf;
  bool pushed = false;
  for (int tries = 0; tries < kDeviceTestTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    far.emplace();
    kerf.emplace(folder_, At::kKeys, Arguments(*far, "--circle 60 --buttons 0"));
    ASSERT_TRUE(kerf->UntilSaid("leave the handle alone")) << kerf->err();
    // Keys are delivered one by one and not echoed.
    EXPECT_EQ(kerf->Settings().c_lflag & (ICANON | ECHO), 0U);
    ASSERT_TRUE(kerf->UntilSaid("hold the handle loosely")) << kerf->err();
    EXPECT_EQ(far->felt().largest_N, 0.0);
    far->Press(1);  // confirms
    pushed = kerf->Until([&] { return far->felt().now_N > 0.5 * kCircle_N; });
    if (pushed) kerf->Type("x");
  }
  ASSERT_TRUE(pushed) << kerf->err();
  EXPECT_EQ(kerf->WaitForEnd(), 1);
  EXPECT_EQ(far->FeltByNow().now_N, 0.0);
  EXPECT_LE(far->felt().largest_N, 1.001 * kCircle_N);
  EXPECT_THAT(kerf->err(), HasSubstr("kerf: the test was stopped\n"));
  EXPECT_THAT(kerf->out(), HasSubstr("  stopped   by a key\n"));
  EXPECT_TRUE(AreSame(kerf->Settings(), kerf->SettingsBefore()));
  EXPECT_THAT(kerf->Shown(), Not(HasSubstr("x")));
}

TEST_F(DeviceTest, KeyBeforeTheForceEndsTheTest) {
  FarSide far;
  Running kerf(folder_, At::kKeys, Arguments(far, "--json"));
  ASSERT_TRUE(kerf.UntilSaid("leave the handle alone")) << kerf.err();
  kerf.Type(" ");
  EXPECT_EQ(kerf.WaitForEnd(), 1);
  const Json json = Json::parse(kerf.out());
  EXPECT_EQ(json["stopped"], true);
  EXPECT_EQ(json["ok"], false);
  EXPECT_EQ(json["force"]["tried"], false);
  EXPECT_EQ(far.felt().largest_N, 0.0);
}

/// Runs the test of the far side to its end, with both buttons pressed.
void RunToTheEnd(Running& kerf, FarSide& far) {
  ASSERT_TRUE(kerf.UntilSaid("hold the handle loosely")) << kerf.err();
  far.Press(2);  // confirms
  ASSERT_TRUE(kerf.Until([&] { return far.felt().engaged > 0; })) << kerf.err();
  far.Press(0);
  ASSERT_TRUE(kerf.UntilSaid("press each button (button 1, button 2)")) << kerf.err();
  far.Press(1);
  ASSERT_TRUE(kerf.UntilSaid("kerf: button button 1\n")) << kerf.err();
  far.Press(2);
  ASSERT_GE(kerf.WaitForEnd(), 0) << kerf.err();
}

TEST_F(DeviceTest, JsonReportsTheHandlesMotion) {
  constexpr double kNoise_mm = 0.05;
  std::optional<FarSide> far;
  std::optional<Running> kerf;
  for (int tries = 0; tries < kDeviceTestTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    far.emplace(kNoise_mm);
    kerf.emplace(folder_, At::kNoTerminal, Arguments(*far, "--circle 4 --buttons 60 --json"));
    ASSERT_NO_FATAL_FAILURE(RunToTheEnd(*kerf, *far));
  }
  ASSERT_EQ(kerf->WaitForEnd(), 0) << kerf->err();
  EXPECT_LT(kerf->err().find("kerf: button button 1\n"), kerf->err().find("kerf: button button 2\n"));
  const Json json = Json::parse(kerf->out());
  EXPECT_EQ(json["ok"], true) << json;
  EXPECT_EQ(json["stopped"], false);
  EXPECT_EQ(json["homed"], true);
  EXPECT_EQ(json["device"], "bridge");
  EXPECT_EQ(json["profile"], "omega_3");
  EXPECT_EQ(json["peak_force_N"], FarSide::kPeak_N);
  EXPECT_EQ(json["buttons"], "button 1, button 2");
  EXPECT_EQ(json["faults"], Json::array());
  // About half of the samples are on either side. With n samples the standard deviation is lower by a fraction 1/(2n),
  // and positions are floats.
  const Json& still = json["still"];
  EXPECT_GT(still["samples"], 100) << still;
  EXPECT_NEAR(still["noise_mm"][0].get<double>(), kNoise_mm, 0.05 * kNoise_mm);
  EXPECT_NEAR(still["span_mm"][0].get<double>(), 2 * kNoise_mm, 1e-6);
  EXPECT_NEAR(still["least_step_mm"].get<double>(), 2 * kNoise_mm, 1e-6);
  for (const int axis : {1, 2}) {
    EXPECT_EQ(still["noise_mm"][axis], 0.0);
    EXPECT_EQ(still["span_mm"][axis], 0.0);
  }
  // The force that was felt is the one that is reported as sent. The handle did not move under it.
  const Json& force = json["force"];
  EXPECT_EQ(force["tried"], true);
  EXPECT_NEAR(force["asked_N"].get<double>(), kCircle_N, 1e-3 * kCircle_N);
  EXPECT_NEAR(far->felt().largest_N, force["sent_N"].get<double>(), 0.01 * kCircle_N);
  EXPECT_LE(force["moved_mm"].get<double>(), 2 * kNoise_mm + 1e-6);
  EXPECT_LE(json["round_us"]["p50"], json["round_us"]["p99"]);
  EXPECT_GT(json["round_us"]["p50"], 0);
  EXPECT_GT(json["rounds"]["all"], 1000);
  EXPECT_EQ(json["rounds"]["bad_answer"], 0);
  EXPECT_EQ(far->FeltByNow().now_N, 0.0);
}

// This is the example program that users copy, unchanged. Its handle moves under the force.
TEST_F(DeviceTest, TableReportsTheMotionOfTheExamplesHandle) {
  constexpr double kSpring_N_per_mm = 0.2;  // stiffness of the example's hand
  constexpr double kExample_N = 0.2 * 3.3;
  std::optional<Running> example;
  std::optional<Running> kerf;
  for (int tries = 0; tries < kDeviceTestTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    // A new example is started, because the handle of the last one still swings after its force has ended.
    example.reset();
    Write("port.txt", "");
    example.emplace(folder_, At::kNoTerminal, "'" KERF_BRIDGE_EXAMPLE "' 0 >port.txt 2>example.txt");
    ASSERT_TRUE(example->Until([&] { return test::Slurp(folder_ / "port.txt").ends_with('\n'); }));
    const std::string said = test::Slurp(folder_ / "port.txt");
    const std::string where = said.substr(said.find("127."));
    kerf.emplace(
        folder_, At::kNoTerminal,
        "'" KERF_PROGRAM "' device test bridge --circle 4 --buttons 0 --bridge " + where.substr(0, where.find('\n')));
  }
  ASSERT_EQ(kerf->WaitForEnd(), 0) << kerf->err();
  const std::string table = kerf->out();
  EXPECT_THAT(table, HasSubstr("bridge (example, up to 3.3 N)\n  homed     yes\n"));
  EXPECT_THAT(table, HasSubstr("noise 0.0000 0.0000 0.0000 mm"));
  EXPECT_THAT(table, HasSubstr("            no step: the handle did not move\n"));
  EXPECT_THAT(table, HasSubstr("  buttons   none of button 1, button 2\n"));
  EXPECT_THAT(table, Not(HasSubstr("FAULT")));
  const std::size_t force = table.find("  force     up to ");
  ASSERT_NE(force, std::string::npos) << table;
  double asked_N = 0;
  double sent_N = 0;
  double moved_mm = 0;
  double followed_percent = 0;
  ASSERT_EQ(
      std::sscanf(table.c_str() + force,
                  "  force     up to %lf N requested, %lf N sent; the handle moved %lf mm, %lf %% along the force",
                  &asked_N, &sent_N, &moved_mm, &followed_percent),
      4)
      << table;
  EXPECT_EQ(asked_N, 0.66);
  // The force completes a rotation in 2 s, far slower than the hand oscillates: 0.2 N/mm and 0.15 kg give 5.8 Hz. So
  // the motion is quasi-static to (0.5 Hz / 5.8 Hz)^2 = 0.7 %, plus the oscillation from the start. The rest of the
  // tolerance is for rounds that the machine misses.
  EXPECT_NEAR(moved_mm, kExample_N / kSpring_N_per_mm, 0.15 * kExample_N / kSpring_N_per_mm);
  EXPECT_GT(followed_percent, 90);
}

/// Returns the height of the handle above the middle, mm, from the last line that contains it; NaN if there is none.
double FindUp_mm(const std::string& text) {
  const std::size_t at = text.rfind("  up ");
  double up_mm = std::nan("");
  if (at != std::string::npos) std::sscanf(text.c_str() + at, "  up %lf", &up_mm);
  return up_mm;
}

/// Presses the button again while the program waits for a handle that moves down in the hand. After a stall of half a
/// second the program no longer regards the handle as held, and waits for a button that was not pressed before.
void PressAgainIfAsked(FarSide& far, std::uint32_t button, const std::string& shown) {
  const std::size_t ready = shown.rfind("ready, ");
  if (far.felt().engaged == 0 || ready == std::string::npos) return;
  if (shown.find("in the hand", ready) != std::string::npos) return;
  if (shown.find("; buttons button", ready) != std::string::npos) far.Press(0);
  if (shown.find("; buttons none", ready) != std::string::npos) far.Press(button);
}

TEST_F(DeviceTest, WatchOnATerminalUpdatesOneLine) {
  FarSide far;
  Running kerf(folder_, At::kTerminal, Arguments(far, "--watch"));
  ASSERT_TRUE(kerf.Until([&] { return FindUp_mm(kerf.Shown()) == 0; })) << kerf.Shown();
  far.Press(2);  // also confirms, so that the far side moves the handle
  EXPECT_TRUE(kerf.Until([&] { return kerf.Shown().find("; buttons button 2") != std::string::npos; })) << kerf.Shown();
  far.Lower(2.5);
  EXPECT_TRUE(kerf.Until([&] {
    PressAgainIfAsked(far, 2, kerf.Shown());
    return FindUp_mm(kerf.Shown()) == -2.5;
  })) << kerf.Shown();
  kerf.Type("q");
  EXPECT_EQ(kerf.WaitForEnd(), 0);
  EXPECT_TRUE(AreSame(kerf.Settings(), kerf.SettingsBefore()));
  const std::string shown = kerf.Shown();
  EXPECT_THAT(shown, HasSubstr("bridge (omega_3, up to 12 N)\x1b[?7h\r\n"));
  // Position lines overwrite each other.
  for (const char* end : {"; buttons none\x1b[?7h\r\n", "; buttons button 2\x1b[?7h\r\n"}) {
    EXPECT_THAT(shown, Not(HasSubstr(end)));
  }
  EXPECT_THAT(shown, HasSubstr("\r\x1b[K\x1b[?7lin the hand; right    +0.00  up "));
  EXPECT_THAT(shown, HasSubstr(" rounds, "));
  EXPECT_EQ(far.felt().largest_N, 0.0);
}

TEST_F(DeviceTest, WatchWithoutATerminalPrintsSeparateLines) {
  FarSide far;
  far.Press(0);
  Running kerf(folder_, At::kNoTerminal, Arguments(far, "--watch"));
  ASSERT_TRUE(kerf.Until([&] { return FindUp_mm(kerf.out()) == 0; })) << kerf.out();
  const std::size_t unpressed = kerf.out().size();
  far.Press(1);
  far.Lower(3);
  EXPECT_TRUE(kerf.Until([&] {
    PressAgainIfAsked(far, 1, kerf.out());
    return FindUp_mm(kerf.out()) == -3;
  })) << kerf.out();
  kerf.Signal(SIGINT);
  EXPECT_EQ(kerf.WaitForEnd(), 0);
  std::istringstream lines(kerf.out());
  std::set<std::string> places;
  std::size_t begin = 0;
  for (std::string line; std::getline(lines, line); begin += line.size() + 1) {
    places.insert(line);
    if (line.ends_with("; no answer")) continue;  // for half a second: the machine stalled
    if (line.starts_with("ready, ")) {
      EXPECT_THAT(line, HasSubstr(begin < unpressed ? " mm; buttons none" : " mm; buttons "));
    } else if (line.starts_with("in the hand; ")) {
      EXPECT_THAT(line, testing::EndsWith(" mm; buttons button 1"));
    }
  }
  EXPECT_GE(places.size(), 5U) << kerf.out();  // device, ready, in the hand, its positions, rounds
  EXPECT_EQ(kerf.out().find('\x1b'), std::string::npos);
  EXPECT_EQ(kerf.out().find('\r'), std::string::npos);
}

}  // namespace
}  // namespace kerf
