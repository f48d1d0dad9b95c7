// Tests of kerf loop with a device in the hand: through the bridge, and through Haply's service.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/devices_cli/far_side.h"
#include "device/drivers/haply_service.h"
#include "support/forces_csv.h"
#include "support/running.h"
#include "support/session_files.h"
#include "test_paths.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::AreSame;
using test::At;
using test::FarSide;
using test::ForceRow;
using test::ProgramResult;
using test::Running;
using test::WaitForProgress;
using testing::HasSubstr;
using testing::Not;

constexpr double kFelt_N = 0.05;
// Height of the disc's centre above the bar, and the gap between its teeth and the bar.
constexpr double kStart_mm = 6.5;
constexpr double kGap_mm = 0.5;
constexpr double kCut_mm = 1;
constexpr const char* kAsked = "is connected again";  // asks whether force may return, after a silence of half a second

class LoopInAHand : public test::ProgramTest {
 protected:
  LoopInAHand()
      : ProgramTest({{"bar.toml",
                      test::Slurp(KERF_SOURCE_DIR "/tests/support/cut_bar.toml") + "[output]\npictures = false\n"}}) {}
  static std::string Arguments(const std::string& device) {
    return "'" KERF_PROGRAM "' loop bar.toml --seconds 300 --json -o out --record cut.kerf --device " + device;
  }
  static int CountAsked(const Running& kerf) {
    int asked = 0;
    const std::string err = kerf.err();
    for (std::size_t at = 0; (at = err.find(kAsked, at)) != std::string::npos; ++at) ++asked;
    return asked;
  }
  /// Waits until `holds` returns true. If the machine stalls, the program asks for confirmation, and this function
  /// gives it.
  bool Until(Running& kerf, const std::function<bool()>& holds) {
    return kerf.Until([&] {
      if (const int asked = CountAsked(kerf); asked > agreed_) {
        agreed_ = asked;
        kerf.Type("\n");
      }
      return holds();
    });
  }
  /// Ends the program as Ctrl-C does. Expects that the tool followed the handle `lowered_mm` straight down through the
  /// bone, and that the recording replays identically. A handle that was coupled again continues from the tool, which
  /// the bone had held back: it then rises once, to the tool, though the hand only moves down.
  void ExpectCut(Running& kerf, double lowered_mm, double error_mm = 0) const {
    // The hand rests, and the tool cuts on towards it: for half a second or more at each call.
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(WaitForProgress(kerf, folder_ / "cut.kerf")) << kerf.err();
    kerf.Signal(SIGINT);
    ASSERT_EQ(kerf.WaitForEnd(), 0) << kerf.err();
    const std::vector<ForceRow> rows = test::ReadForces(folder_ / "out/forces.csv");
    // If the machine stalled at the start of the loop, the handle has no position until it is read.
    const bool at_once = !kerf.Said("does not answer");
    const auto read = std::find_if(rows.begin(), rows.end(),
                                   [=](const ForceRow& row) { return at_once || row.at("handle_z_mm") != 0; });
    ASSERT_NE(read, rows.end()) << kerf.err();
    // Positions are floats or decimals, and are written with five decimals.
    EXPECT_NEAR(read->at("handle_z_mm"), kStart_mm, 1e-4);
    // Motion of the handle while the machine is stalled is not read, and the tool does not follow that motion.
    const bool seen =
        !kerf.Said("bridge: answers again") && !kerf.Said("inverse3: answers again") && CountAsked(kerf) == meant_;
    double risen_mm = 0;
    for (auto row = read + 1; row != rows.end(); ++row) {
      const double by_mm = row->at("handle_z_mm") - (row - 1)->at("handle_z_mm");
      if (by_mm <= 1e-4) continue;
      risen_mm += by_mm;
      EXPECT_NEAR(row->at("handle_z_mm"), row->at("tool_z_mm"), 0.05) << row->at("time_s");
    }
    const double end_mm = kStart_mm - lowered_mm + risen_mm;
    EXPECT_GE(rows.back().at("handle_z_mm"), end_mm - 1e-4 - error_mm);
    EXPECT_LE(rows.back().at("handle_z_mm"), seen ? end_mm + 1e-4 + error_mm : kStart_mm - kGap_mm) << kerf.err();
    for (const ForceRow& row : rows) {
      ASSERT_NEAR(row.at("handle_x_mm"), 0, 1e-4);
      ASSERT_NEAR(row.at("handle_y_mm"), 0, 1e-4);
      // The bone holds the tool back; it is never far ahead of the handle.
      ASSERT_GT(row.at("tool_z_mm"), row.at("handle_z_mm") - 0.05) << row.at("time_s");
    }
    EXPECT_LT(rows.back().at("tool_z_mm"), kStart_mm - kGap_mm - 0.3 * kCut_mm);
    const Json json = Json::parse(kerf.out());
    EXPECT_GT(json["removed_mm3"], 0.1);
    EXPECT_GT(json["force"]["largest_N"], kFelt_N);
    EXPECT_EQ(json["bone_hash"], Json::parse(test::Slurp(folder_ / "out/loop.json"))["bone_hash"]);
    const ProgramResult replay = Kerf("replay cut.kerf --verify");
    EXPECT_EQ(replay.code, 0) << replay.err;
    EXPECT_THAT(replay.out, HasSubstr("bit-identical to the recording"));
  }

  int agreed_ = 0;  // number of confirmations given
  int meant_ = 0;   // number of questions that the test itself causes
};

TEST_F(LoopInAHand, CutsWithABridgeDevice) {
  FarSide far;
  Running kerf(folder_, At::kKeys, Arguments("bridge --bridge " + far.where()));
  ASSERT_TRUE(Until(kerf, [&] { return far.felt().engaged > 0; })) << kerf.err();
  ASSERT_TRUE(WaitForProgress(kerf, folder_ / "cut.kerf")) << kerf.err();
  EXPECT_EQ(far.felt().largest_N, 0.0);
  far.Lower(kGap_mm + kCut_mm);
  ASSERT_TRUE(Until(kerf, [&] { return far.felt().lowered_mm == kGap_mm + kCut_mm; })) << kerf.err();
  EXPECT_TRUE(Until(kerf, [&] { return far.felt().largest_N > kFelt_N; })) << kerf.err();
  EXPECT_THAT(kerf.err(), HasSubstr("hold the handle still in the middle"));
  ExpectCut(kerf, kGap_mm + kCut_mm);
  EXPECT_EQ(far.felt().now_N, 0.0);
}

TEST_F(LoopInAHand, CutsWithAnInverse3) {
  const Vec3 start_m{0.01, -0.12, 0.2};
  std::optional<test::HaplyService> service;
  try {
    service.emplace(test::HaplyService::Mood::kGood, false, 10001);
  } catch (const std::exception&) {
    GTEST_SKIP() << "another program listens at 127.0.0.1:10001, where Haply's service does";
  }
  Running kerf(folder_, At::kKeys, Arguments("inverse3"));
  ASSERT_TRUE(kerf.UntilSaid("hold the handle still in the middle")) << kerf.err();
  ASSERT_TRUE(kerf.UntilSaid("inverse3: in the hand") && WaitForProgress(kerf, folder_ / "cut.kerf")) << kerf.err();
  int before = service->forces();
  double lowered_mm = 0;
  double felt_N = 0;
  ASSERT_TRUE(Until(kerf,
                    [&] {
                      // The hand moves one step per received message, no faster than a real hand, however late the test
                      // is. It does not move while the program waits for confirmation.
                      const int now = service->forces();
                      const double step_mm = std::fmin(0.1, 0.002 * (now - std::exchange(before, now)));
                      const std::string err = kerf.err();
                      const std::size_t asked = err.rfind(kAsked);
                      if (asked == std::string::npos || err.rfind("in the hand") > asked) {
                        lowered_mm = std::fmin(lowered_mm + step_mm, kGap_mm + kCut_mm);
                      }
                      service->Put(start_m - Vec3{0, 0, 1e-3 * lowered_mm});
                      felt_N = std::fmax(felt_N, glm::length(service->force_N()));
                      return lowered_mm == kGap_mm + kCut_mm && felt_N > kFelt_N;
                    }))
      << felt_N << kerf.err();
  ExpectCut(kerf, kGap_mm + kCut_mm);
  EXPECT_EQ(service->force_N(), Vec3{0});
}

// Checks the messages of the driver's thread at a stall. Force returns only after the user, when asked, confirms with
// Enter.
TEST_F(LoopInAHand, ForceReturnsAfterEnterWhenTheDeviceAnswersAgain) {
  constexpr int kMaxTries = 5;
  std::optional<FarSide> its;
  std::optional<Running> session;
  std::chrono::steady_clock::time_point mute_since;
  const auto mute_for = [&] { return std::chrono::steady_clock::now() - mute_since; };
  const auto asked_already = [&] { return session->Said(kAsked); };
  // If the machine stalled for half a second before the device was mute, the program has already asked. The test is
  // then repeated.
  for (int tries = 0; tries < kMaxTries && (!session || asked_already()); ++tries) {
    session.reset();
    its.emplace();
    std::filesystem::remove(folder_ / "cut.kerf");
    session.emplace(folder_, At::kKeys, Arguments("bridge --bridge " + its->where()));
    ASSERT_TRUE(session->Until([&] { return its->felt().engaged > 0; })) << session->err();
    ASSERT_TRUE(WaitForProgress(*session, folder_ / "cut.kerf")) << session->err();
    its->Lower(kGap_mm + kCut_mm);
    ASSERT_TRUE(session->Until([&] { return its->felt().now_N > kFelt_N || asked_already(); })) << session->err();

    its->SetMute(true);
    mute_since = std::chrono::steady_clock::now();
    ASSERT_TRUE(session->UntilSaid("bridge: does not answer: no force")) << session->err();
    // Messages about earlier answers have been printed by then.
    ASSERT_TRUE(session->Until([&] { return its->felt().now_N == 0 && mute_for() > std::chrono::milliseconds(300); }));
  }
  FarSide& far = *its;
  Running& kerf = *session;
  ASSERT_FALSE(kerf.Said(kAsked)) << kerf.err();
  far.ForgetLargest();
  kerf.Type("\n");  // before the program asks
  // The program allows a silence of half a second without asking.
  kerf.Until([&] { return mute_for() > std::chrono::seconds(1); });
  EXPECT_FALSE(kerf.Said(kAsked));
  far.SetMute(false);
  ASSERT_TRUE(kerf.UntilSaid("is connected again; press a button on it, or agree here to enable the force again"))
      << kerf.err();
  const FarSide::Felt asked = far.felt();
  ASSERT_TRUE(kerf.Until([&] { return far.felt().commands > asked.commands + 500; }));
  EXPECT_EQ(far.felt().engaged, asked.engaged);
  EXPECT_EQ(far.felt().largest_N, 0.0);

  agreed_ = meant_ = 1;
  kerf.Type("\n");
  ASSERT_TRUE(Until(kerf, [&] {
    const std::string err = kerf.err();
    return err.find("bridge: in the hand; the force rises slowly", err.find(kAsked)) != std::string::npos;
  })) << kerf.err();
  ASSERT_TRUE(WaitForProgress(kerf, folder_ / "cut.kerf")) << kerf.err();
  const double end_mm = far.felt().lowered_mm + kCut_mm;
  far.Lower(kCut_mm);
  EXPECT_TRUE(Until(kerf, [&] { return far.felt().largest_N > kFelt_N; })) << kerf.err();
  ASSERT_TRUE(Until(kerf, [&] { return far.felt().lowered_mm >= end_mm; })) << kerf.err();
  EXPECT_THAT(kerf.err(), Not(HasSubstr("is gone")));
  ExpectCut(kerf, end_mm, FarSide::kStep_mm);  // one step without an answer
  EXPECT_TRUE(AreSame(kerf.Settings(), kerf.SettingsBefore()));
}

}  // namespace
}  // namespace kerf
