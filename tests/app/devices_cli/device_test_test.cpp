// kerf device test at a terminal and without one, with the far side of a bridge in the test.
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

/// A fifth of the far side's peak, which is the circle's force.
constexpr double kCircle_N = 0.2 * FarSide::kPeak_N;
constexpr int kMostTries = 5;

class DeviceTest : public test::ProgramTest {
 protected:
  /// A machine that stands still for more than a moment rightly fails a device: then all is done again.
  static bool FailedByStandingStill(Running& kerf) {
    return kerf.WaitForEnd() == 1 && (kerf.Said("was lost while it made force") ||
                                      kerf.Said("rounds had no good answer") || kerf.Said("samples came in"));
  }
  static std::string Arguments(const FarSide& far, const std::string& more) {
    return "'" KERF_PROGRAM "' device test bridge --bridge " + far.where() + " " + more;
  }
};

TEST_F(DeviceTest, AnyKeyEndsItAndTheForceWithIt) {
  std::optional<FarSide> far;
  std::optional<Running> kerf;
  bool pushed = false;
  for (int tries = 0; tries < kMostTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    far.emplace();
    kerf.emplace(folder_, At::kKeys, Arguments(*far, "--circle 60 --buttons 0"));
    ASSERT_TRUE(kerf->UntilSaid("leave the handle alone")) << kerf->err();
    // Keys come one by one, and are not shown.
    EXPECT_EQ(kerf->Settings().c_lflag & (ICANON | ECHO), 0U);
    ASSERT_TRUE(kerf->UntilSaid("take the handle loosely")) << kerf->err();
    EXPECT_EQ(far->felt().largest_N, 0.0);
    far->Press(1);  // agrees
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

TEST_F(DeviceTest, AKeyBeforeTheForceEndsItToo) {
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

/// The test of the far side to its end, with both buttons pressed.
void RunToTheEnd(Running& kerf, FarSide& far) {
  ASSERT_TRUE(kerf.UntilSaid("take the handle loosely")) << kerf.err();
  far.Press(2);  // agrees
  ASSERT_TRUE(kerf.Until([&] { return far.felt().engaged > 0; })) << kerf.err();
  far.Press(0);
  ASSERT_TRUE(kerf.UntilSaid("press each button (button 1, button 2)")) << kerf.err();
  far.Press(1);
  ASSERT_TRUE(kerf.UntilSaid("kerf: button button 1\n")) << kerf.err();
  far.Press(2);
  ASSERT_GE(kerf.WaitForEnd(), 0) << kerf.err();
}

TEST_F(DeviceTest, TellsInJsonWhatTheHandleDid) {
  constexpr double kNoise_mm = 0.05;
  std::optional<FarSide> far;
  std::optional<Running> kerf;
  for (int tries = 0; tries < kMostTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    far.emplace(kNoise_mm);
    kerf.emplace(folder_, At::kNowhere, Arguments(*far, "--circle 4 --buttons 60 --json"));
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
  // Half of the samples on either side: of n of them the standard deviation lies 1/(2n) below, and places are floats.
  const Json& still = json["still"];
  EXPECT_GT(still["samples"], 100) << still;
  EXPECT_NEAR(still["noise_mm"][0].get<double>(), kNoise_mm, 0.05 * kNoise_mm);
  EXPECT_NEAR(still["span_mm"][0].get<double>(), 2 * kNoise_mm, 1e-6);
  EXPECT_NEAR(still["least_step_mm"].get<double>(), 2 * kNoise_mm, 1e-6);
  for (const int axis : {1, 2}) {
    EXPECT_EQ(still["noise_mm"][axis], 0.0);
    EXPECT_EQ(still["span_mm"][axis], 0.0);
  }
  // What the program says that it sent is what was felt; the handle gave way to none of it.
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

// The example that users copy, as it is: its handle goes by the force.
TEST_F(DeviceTest, TellsInATableHowTheExamplesHandleWent) {
  constexpr double kSpring_N_per_mm = 0.2;  // of the example's hand
  constexpr double kExample_N = 0.2 * 3.3;
  std::optional<Running> example;
  std::optional<Running> kerf;
  for (int tries = 0; tries < kMostTries && (!kerf || FailedByStandingStill(*kerf)); ++tries) {
    kerf.reset();
    // A new one: the last one's handle swings on from where its force ended.
    example.reset();
    Write("port.txt", "");
    example.emplace(folder_, At::kNowhere, "'" KERF_BRIDGE_EXAMPLE "' 0 >port.txt 2>example.txt");
    ASSERT_TRUE(example->Until([&] { return test::Slurp(folder_ / "port.txt").ends_with('\n'); }));
    const std::string said = test::Slurp(folder_ / "port.txt");
    const std::string where = said.substr(said.find("127."));
    kerf.emplace(
        folder_, At::kNowhere,
        "'" KERF_PROGRAM "' device test bridge --circle 4 --buttons 0 --bridge " + where.substr(0, where.find('\n')));
  }
  ASSERT_EQ(kerf->WaitForEnd(), 0) << kerf->err();
  const std::string table = kerf->out();
  EXPECT_THAT(table, HasSubstr("bridge (example, up to 3.3 N)\n  homed     yes\n"));
  EXPECT_THAT(table, HasSubstr("noise 0.0000 0.0000 0.0000 mm"));
  EXPECT_THAT(table, HasSubstr("            no step: it stood quite still\n"));
  EXPECT_THAT(table, HasSubstr("  buttons   none of button 1, button 2\n"));
  EXPECT_THAT(table, Not(HasSubstr("FAULT")));
  const std::size_t force = table.find("  force     up to ");
  ASSERT_NE(force, std::string::npos) << table;
  double asked_N = 0;
  double sent_N = 0;
  double moved_mm = 0;
  double followed_percent = 0;
  ASSERT_EQ(std::sscanf(table.c_str() + force,
                        "  force     up to %lf N asked for, %lf N sent; the handle went %lf mm, %lf %% along the force",
                        &asked_N, &sent_N, &moved_mm, &followed_percent),
            4)
      << table;
  EXPECT_EQ(asked_N, 0.66);
  // The force goes round in 2 s, far slower than the hand swings: 0.2 N/mm and 0.15 kg make 5.8 Hz, so at rest to
  // (0.5 Hz / 5.8 Hz)^2 = 0.7 %, with the swing of the begin on top; the rest is what the machine lets it miss.
  EXPECT_NEAR(moved_mm, kExample_N / kSpring_N_per_mm, 0.15 * kExample_N / kSpring_N_per_mm);
  EXPECT_GT(followed_percent, 90);
}

/// Where the handle is said to be above the middle, mm, in the last line of those that tell it; NaN: in none.
double FindUp_mm(const std::string& text) {
  const std::size_t at = text.rfind("  up ");
  double up_mm = std::nan("");
  if (at != std::string::npos) std::sscanf(text.c_str() + at, "  up %lf", &up_mm);
  return up_mm;
}

/// For whoever waits for a handle that goes down in the hand: after a standstill of half a second the program, which
/// had it in the hand, waits for a button that was not pressed before.
void PressAgainIfAsked(FarSide& far, std::uint32_t button, const std::string& shown) {
  const std::size_t ready = shown.rfind("ready, ");
  if (far.felt().engaged == 0 || ready == std::string::npos) return;
  if (shown.find("in the hand", ready) != std::string::npos) return;
  if (shown.find("; buttons button", ready) != std::string::npos) far.Press(0);
  if (shown.find("; buttons none", ready) != std::string::npos) far.Press(button);
}

TEST_F(DeviceTest, WatchedAtATerminalItIsOneLineThatFollowsTheHandle) {
  FarSide far;
  Running kerf(folder_, At::kTerminal, Arguments(far, "--watch"));
  ASSERT_TRUE(kerf.Until([&] { return FindUp_mm(kerf.Shown()) == 0; })) << kerf.Shown();
  far.Press(2);  // agrees too, so that the far side lets the handle move
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
  // Places are written over each other.
  for (const char* end : {"; buttons none\x1b[?7h\r\n", "; buttons button 2\x1b[?7h\r\n"}) {
    EXPECT_THAT(shown, Not(HasSubstr(end)));
  }
  EXPECT_THAT(shown, HasSubstr("\r\x1b[K\x1b[?7lin the hand; right    +0.00  up "));
  EXPECT_THAT(shown, HasSubstr(" rounds, "));
  EXPECT_EQ(far.felt().largest_N, 0.0);
}

TEST_F(DeviceTest, WatchedWithoutATerminalEachTimeIsALine) {
  FarSide far;
  far.Press(0);
  Running kerf(folder_, At::kNowhere, Arguments(far, "--watch"));
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
    if (line.ends_with("; no answer")) continue;  // for half a second: the machine stood still
    if (line.starts_with("ready, ")) {
      EXPECT_THAT(line, HasSubstr(begin < unpressed ? " mm; buttons none" : " mm; buttons "));
    } else if (line.starts_with("in the hand; ")) {
      EXPECT_THAT(line, testing::EndsWith(" mm; buttons button 1"));
    }
  }
  EXPECT_GE(places.size(), 5U) << kerf.out();  // device, ready, in the hand, its places, rounds
  EXPECT_EQ(kerf.out().find('\x1b'), std::string::npos);
  EXPECT_EQ(kerf.out().find('\r'), std::string::npos);
}

}  // namespace
}  // namespace kerf
