// Tests of a scene with a simulated hand, in virtual time.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/core/cancelled.h"
#include "base/files/files.h"
#include "bone/mesh/meshfile.h"
#include "bone/vdb/bonefile.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/run/hand_motion.h"
#include "session/run/loop_session.h"
#include "session/run/make_bone.h"
#include "session/run/overall_progress.h"
#include "session/run/session_recorder.h"
#include "support/block_scene.h"
#include "support/far_apart.h"
#include "support/forces_csv.h"
#include "support/message_of.h"
#include "support/motion.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

const std::string kLoopScene = test::kBarToml + test::kThroughBarToml;

LoopOptions Virtual(double seconds) {
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = seconds;
  return options;
}

LoopSummary RunVirtual(const Scene& scene, double seconds) {
  return RunLoop(scene, Virtual(seconds), {});
}

TEST(RunLoop, CutsThroughAndRemovesTheKerf) {
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  const LoopSummary s = RunVirtual(scene, 6);
  // The volume is height x width x thickness of the disc. The disc moves sideways by a fraction of a voxel, which is a
  // tenth of the kerf's width.
  EXPECT_NEAR(s.removed_mm3, 3 * 4 * 0.5, 0.6);
  EXPECT_EQ(s.counts.ticks, 6000U);
  EXPECT_EQ(s.counts.missed, 0U);
  EXPECT_EQ(s.counts.not_finite + s.device_counts.not_finite, 0U);
  EXPECT_EQ(s.end, LoopEnd::kRequested);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_GT(s.leaves_sent, 0U);
  EXPECT_GE(s.strokes, 2);
  EXPECT_LE(s.force.largest_step_N, s.force.slew_bound_N);
  EXPECT_GT(s.force.largest_N, 0.01);
  // The energy supplied by hand and spindle went into the cut and into friction, or is in the springs.
  EXPECT_GT(s.cut_J, 0);
  EXPECT_GE(s.hand_J + s.spindle_J, s.cut_J + s.friction_J - 1e-6);
  // The energy balance of each tick is exact to within rounding: 1e-9 of a few joules over 6000 ticks.
  EXPECT_NEAR(s.hand_J + s.spindle_J, s.stored_J + s.cut_J + s.friction_J + s.damping_J + s.numerical_J, 1e-7);
  EXPECT_EQ(s.pieces.size(), 2U);
  EXPECT_TRUE(s.touched);
  EXPECT_FALSE(s.starts_in_bone);
  EXPECT_TRUE(s.warnings.empty());
}

TEST(ParseLoopAction, TakesTheSpeedsOfTheTool) {
  EXPECT_EQ(ParseLoopAction("1:rpm=90000").rpm, 90000);
  EXPECT_EQ(ParseLoopAction("1:rpm=0").rpm, 0);
  for (const char* speed : {"-7500", "-100001"}) {  // as in a scene, the direction is that of the tool
    EXPECT_THAT(test::MessageOf([speed] { ParseLoopAction(fmt::format("1:rpm={}", speed)); }),
                testing::StartsWith(fmt::format("\"1:rpm={0}\": rpm = {0} is below 1;", speed)));
  }
  EXPECT_THAT(test::MessageOf([] { ParseLoopAction("1:rpm=1680000"); }),
              testing::StartsWith("\"1:rpm=1680000\": rpm = 1680000 is above 100000;"));
  EXPECT_EQ(ParseLoopAction("1:rpm=1680000", CalcRateRange(PiezoInsert{})).rpm, 1.68e6);
  EXPECT_THROW(ParseLoopAction("1:rpm=4e6", CalcRateRange(PiezoInsert{})), Error);
  EXPECT_THROW(ParseLoopAction("1:rpm=fast"), Error);
}

TEST(RunLoop, ActionsSetASpeedThatKeepsTheSenseOfTheTool) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  for (const bool reverse : {false, true}) {
    scene.tool.reverse = reverse;
    std::vector<double> speeds;
    LoopOptions options = Virtual(0.03);
    for (const char* text : {"0.01:rpm=0", "0.02:rpm=500"}) options.undo.actions.push_back(ParseLoopAction(text));
    options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) {
      if (speeds.empty() || tick.in.rpm != speeds.back()) speeds.push_back(tick.in.rpm);
      EXPECT_FALSE(tick.in.rpm == 0 && std::signbit(tick.in.rpm));
    };
    RunLoop(scene, options, {});
    const double sign = reverse ? -1 : 1;
    EXPECT_EQ(speeds, (std::vector<double>{sign * scene.tool.rpm, 0, sign * 500}));
  }
}

TEST(RunLoop, GivesTheSameBitsTwice) {
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  const LoopSummary a = RunVirtual(scene, 1);
  const LoopSummary b = RunVirtual(scene, 1);
  EXPECT_EQ(a.bone_hash, b.bone_hash);
  EXPECT_EQ(a.force_hash, b.force_hash);
  EXPECT_NE(a.force_hash, 0U);
  Scene other = scene;
  other.hand.model = "H3";
  EXPECT_NE(RunVirtual(other, 1).force_hash, a.force_hash);
}

// A caller who steps the session sees every tick once, and gets the same result as RunLoop().
TEST(LoopSession, StepsOneTickAtATimeInVirtualTime) {
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  std::uint64_t taken = 0;
  LoopOptions options = Virtual(0.5);
  options.watchers.take_tick = [&](const LoopTick&, std::span<const double>) { ++taken; };
  LoopSession session(scene, options, {});
  int steps = 0;
  while (session.Step()) ++steps;
  EXPECT_FALSE(session.Step());
  const LoopSummary s = session.Finish();
  // One step connects the hand and starts the loop; the last of the 500 ticks ends the session.
  EXPECT_EQ(steps, 500);
  EXPECT_EQ(s.counts.ticks, 500U);
  EXPECT_EQ(taken, 500U);
  EXPECT_EQ(s.force_hash, RunVirtual(scene, 0.5).force_hash);
}

TEST(RunLoop, DurationIsIndependentOfTheRate) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  for (const double rate_hz : {250.0, 4000.0}) {
    scene.loop.rate_hz = rate_hz;
    const LoopSummary s = RunVirtual(scene, 0.5);
    EXPECT_EQ(s.counts.ticks, static_cast<std::uint64_t>(std::lround(0.5 * rate_hz)));
    EXPECT_NEAR(s.simulated_s, 0.5, 1e-9);
  }
}

TEST(RunLoop, RunsLive) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  LoopOptions options;
  options.seconds = 0.3;
  const LoopSummary s = RunLoop(scene, options, {});
  EXPECT_EQ(s.end, LoopEnd::kRequested);
  EXPECT_GT(s.counts.ticks, 0U);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_FALSE(s.grants.scheduling.empty());
  EXPECT_FALSE(s.grants.memory.empty());
  EXPECT_EQ(s.tick.count, s.counts.ticks);
}

TEST(RunLoop, StopsOnRequest) {
  const std::atomic<bool> stop{true};
  LoopOptions options;
  options.seconds = 1000;
  options.stop = &stop;
  EXPECT_EQ(RunLoop(ParseScene(kLoopScene, "s.toml"), options, {}).end, LoopEnd::kRequested);
  options.virtual_time = true;
  EXPECT_LT(RunLoop(ParseScene(kLoopScene, "s.toml"), options, {}).counts.ticks, 10U);
}

TEST(RunLoop, LowersFidelityWhileTimeIsWastedAndRecovers) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  scene.loop.degrade = true;
  LoopOptions options = Virtual(9);
  options.burn_us = 1500;
  const LoopSummary s = RunLoop(scene, options, {});
  ASSERT_GE(s.fidelity_steps.size(), 2U);
  EXPECT_EQ(s.fidelity_steps[0].from, Fidelity::kFull);
  EXPECT_EQ(s.fidelity_steps[0].to, Fidelity::kCoarse);
  EXPECT_EQ(s.fidelity_steps.back().to, Fidelity::kFull);
  EXPECT_GT(s.counts.missed, 0U);
  EXPECT_LE(s.force.largest_step_N, s.force.slew_bound_N);
}

/// Returns only the first stroke of kLoopScene, which ends at z = 0.5.
Scene OneStroke(const std::string& hand) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  scene.path.strokes.resize(1);
  scene.hand.model = hand;
  return scene;
}

TEST(RunLoop, HandleAndToolStopAtTheStrokesEnd) {
  for (const char* hand : {"H1", "H2", "H3", "H4"}) {
    const Scene scene = OneStroke(hand);
    const LoopSummary s = RunVirtual(scene, 12);
    EXPECT_GE(s.passes, 1) << hand;  // it reached the end and returned at least once
    double lowest_mm = 1e9;
    for (const LoopRow& row : s.rows) lowest_mm = std::min({lowest_mm, row.p_WC_mm.z, row.p_WT_mm.z});
    EXPECT_LE(lowest_mm, 0.5 + 0.03 * scene.hand.lead_mm) << hand;
    // A damper stops the handle, not a wall, so it stops within some tenths of a millimetre.
    EXPECT_GE(lowest_mm, 0.5 - 0.3) << hand;
  }
}

TEST(RunLoop, LowersACouplingAboveTheLoopsLimit) {
  Scene scene = OneStroke("H1");
  scene.coupling.params.stiffness_N_per_mm = 100;
  scene.loop.rate_hz = 250;
  const LoopSummary s = RunVirtual(scene, 6);
  EXPECT_TRUE(s.setup.fitted.lowered.by_loop);
  EXPECT_DOUBLE_EQ(s.setup.fitted.coupling.stiffness_N_per_mm,
                   kSampledFraction * s.setup.fitted.limits.sampled_stiffness_N_per_mm);
  // The coupling's maximum is 40 N, the force on a hand that is thrown about. The force on a leaning hand stays below
  // 20 N.
  EXPECT_LT(s.force.largest_simulated_N, 20);
  EXPECT_THAT(s.warnings, testing::Contains(testing::HasSubstr("lowered from 100 to 30 % of the limit of a loop")));
  const auto json = nlohmann::json::parse(FormatLoopJson(scene, s));
  EXPECT_TRUE(json["coupling"]["lowered_for_loop"]);
  EXPECT_EQ(json["coupling"]["asked_stiffness_N_per_mm"], 100);
  EXPECT_THAT(FormatLoopReport(scene, s, false), testing::HasSubstr("lowered from 100 to 30 % of the limit of a loop"));
}

// The bone is so soft that the tool yields to the spring within a tick, and the step dissipates most of the spring's
// energy.
TEST(RunLoop, WarnsIfTheTimeStepDissipatesTheEnergy) {
  Scene scene = ParseScene(kLoopScene, "bar.toml");
  EXPECT_LT(CalcNumericalFraction(RunVirtual(scene, 1)), 0.01);
  scene.material.kind = MaterialKind::kUniform;
  scene.material.E_GPa = 0.001;
  scene.force = ForceLaw("hertz_chip");  // depends on E
  scene.loop.rate_hz = 250;
  const LoopSummary summary = RunVirtual(scene, 1);
  EXPECT_GT(CalcNumericalFraction(summary), 0.1);
  EXPECT_THAT(summary.warnings, testing::Contains(testing::HasSubstr("lost to the time step at 250 Hz")));
}

TEST(RunLoop, WarnsAboutUnusualSettings) {
  const auto warnings = [](const Scene& scene) { return RunVirtual(scene, 0.05).warnings; };
  using testing::Contains;
  using testing::HasSubstr;
  Scene scene = OneStroke("H3");
  EXPECT_THAT(warnings(scene), testing::ElementsAre("the tool touched no bone"));
  scene.tool.rpm = 0;
  EXPECT_THAT(warnings(scene), Contains("rpm = 0: a stopped tool cuts nothing"));
  scene = OneStroke("H3");
  std::get<DiscSaw>(scene.tool.shape).thickness_mm = 0.1;
  EXPECT_THAT(warnings(scene), Contains(HasSubstr("thinner than a voxel")));
  scene = OneStroke("H3");
  scene.coupling.at = CouplingPoint::kGrip;
  EXPECT_THAT(warnings(scene), Contains(HasSubstr("the device omega_6 outputs no torques")));
  scene = OneStroke("H3");
  scene.path.strokes[0].start_mm = {0, 0, 2};
  EXPECT_THAT(warnings(scene), Contains(HasSubstr("set down inside the bone")));
  // A blade that points down at the block is not in it, although its reach is.
  scene.tool.shape = ReciprocatingBlade{};
  scene.path.strokes[0].start_mm = {0, 0, 12};
  EXPECT_THAT(warnings(scene), testing::Not(Contains(HasSubstr("set down inside the bone"))));
}

TEST(RunLoop, ReportsThePositionOfAMissingTableOfDevices) {
  const Scene scene = ParseScene(kLoopScene + "[device]\nprofile = \"mine\"\nfile = \"none.csv\"\n", "s.toml");
  const std::string message = test::MessageOf([&] { RunVirtual(scene, 1); });
  EXPECT_THAT(message, testing::HasSubstr("none.csv"));
  EXPECT_THAT(message, testing::StartsWith("s.toml:26:1: "));
}

std::string MessageOf(const Scene& scene, double seconds = 1) {
  return test::MessageOf([&] { RunVirtual(scene, seconds); });
}

TEST(RunLoop, RefusesSlabModeAndInvalidDurations) {
  Scene slab = ParseScene(kLoopScene, "s.toml");
  slab.simulation.mode = SceneMode::kSlab;
  EXPECT_EQ(MessageOf(slab),
            "[simulation] mode = \"slab\" can't be coupled to a handle; set mode = \"voxel\" for 'kerf loop'");
  EXPECT_EQ(MessageOf(ParseScene(kLoopScene, "s.toml"), 0),
            "loop: seconds = 0 is below 0.01; valid range 0.01 to 36000 s");
  EXPECT_EQ(MessageOf(ParseScene(kLoopScene, "s.toml"), 36'001),
            "loop: seconds = 36001 is above 36000; valid range 0.01 to 36000 s");
  // Without a folder, all rows would be kept in memory.
  EXPECT_EQ(MessageOf(ParseScene(kLoopScene, "s.toml"), 20'000),
            "20000000 ticks are too many to keep in memory (the maximum is 10000000); specify a folder");
}

using LoopReport = test::ResultFolderTest;

TEST_F(LoopReport, HasTheTimesOfALiveLoop) {
  LoopOptions options;
  options.seconds = 0.2;
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  const LoopSummary s = RunLoop(scene, options, {});
  const auto json = nlohmann::json::parse(FormatLoopJson(scene, s));
  EXPECT_EQ(json["lateness"]["count"], s.counts.ticks);
  std::uint64_t in_bars = 0;
  for (const auto& bar : json["tick_bars_us"]) in_bars += bar[2].get<std::uint64_t>();
  EXPECT_EQ(in_bars, s.counts.ticks);
  EXPECT_TRUE(json["force"]["noise_above_20_Hz_while_cutting_mN"].is_null());  // nothing was cut yet
}

TEST_F(LoopReport, ReducedPiecesAreSmallerAndWithinTheStatedError) {
  std::string text = kLoopScene;
  text.replace(text.find("voxel_mm = 0.2"), 14, "voxel_mm = 0.1");
  const Scene scene = ParseScene(text + "[output]\npictures = false\n", "s.toml");
  LoopOptions options = Virtual(0.1);
  options.output.keep_bones = true;
  LoopSummary s = RunLoop(scene, options, {});
  WriteLoopReport(scene, s, folder_);
  const TriangleMesh reduced = ReadMesh(folder_ + "/piece_1.stl");
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/loop.json"));
  EXPECT_EQ(json["surface_error_mm"], 0.02);
  EXPECT_EQ(json["pieces"][0]["triangles"], reduced.triangles.size());
  WriteLoopReport(scene, s, folder_, {}, 0);
  const TriangleMesh full = ReadMesh(folder_ + "/piece_1.stl");
  EXPECT_EQ(nlohmann::json::parse(ReadTextFile(folder_ + "/loop.json"))["surface_error_mm"], 0);
  EXPECT_LT(reduced.triangles.size(), full.triangles.size() / 2);
  EXPECT_LE(test::CalcLargestDistance(full, reduced, 0.05), 0.02 + 1e-5);
  EXPECT_LE(test::CalcLargestDistance(reduced, full, 0.05), 0.02 + 1e-5);
}

TEST_F(LoopReport, FilesAgreeWithTheSummary) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  Scene scene = ParseScene(kLoopScene, "s.toml");
  scene.output.forces_every_ticks = 3;
  LoopOptions options = Virtual(6);
  options.output.keep_bones = true;
  LoopSummary s = RunLoop(scene, options, {});
  WriteLoopReport(scene, s, folder_);
  for (const std::string& name : s.files) EXPECT_GT(fs::file_size(fs::path(folder_) / name), 100U) << name;
  EXPECT_THAT(s.files, testing::UnorderedElementsAre("report.md", "loop.json", "scene.toml", "forces.csv", "force.png",
                                                     "bone.vdb", "piece_1.stl", "piece_2.stl", "before.png",
                                                     "after.png", "cut.png", "apart.png"));
  EXPECT_EQ(ReadBone(folder_ + "/bone.vdb").CalcHash(), s.bone_hash);
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/loop.json"));
  EXPECT_EQ(json["ticks"]["count"], 6000);
  EXPECT_EQ(json["pieces"].size(), 2U);
  EXPECT_EQ(json["removed_mm3"], s.removed_mm3);
  EXPECT_TRUE(json["published"]["copy_is_bit_identical"]);
  for (const char* key : {"tick", "lateness", "stages", "tick_bars_us", "lateness_bars_us"}) {
    EXPECT_TRUE(json[key].is_null()) << key;  // not available in virtual time
  }
  EXPECT_EQ(json["removed_by_occupancy_mm3"], s.removed_by_occupancy_mm3);
  const std::vector<test::ForceRow> rows = test::ReadForces(folder_ + "/forces.csv");
  double removed_mm3 = 0;
  for (const test::ForceRow& row : rows) {
    EXPECT_EQ(row.size(), rows.front().size());
    removed_mm3 += row.at("removed_mm3");
  }
  EXPECT_EQ(rows.size(), 2000u);
  // The values are written with six digits.
  EXPECT_NEAR(removed_mm3, s.removed_by_occupancy_mm3, 1e-4 * removed_mm3);
  // A second run into the folder, with fewer results, removes the files that it no longer writes.
  scene.output.pieces = scene.output.pictures = false;
  LoopOptions brief = Virtual(0.1);
  brief.output.keep_bones = true;
  LoopSummary again = RunLoop(scene, brief, {});
  WriteLoopReport(scene, again, folder_);
  EXPECT_TRUE(fs::exists(folder_ + "/bone.vdb"));
  EXPECT_FALSE(fs::exists(folder_ + "/piece_2.stl"));
  EXPECT_FALSE(fs::exists(folder_ + "/apart.png"));
}

TEST(HandMotion, WaitsIfTheHandleIsHeldAndRepeatsThePathIfItIsFree) {
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  const Path path = MakePath(scene);
  SceneHand params;
  params.lead_mm = 3;
  {
    DeviceProfile free = FindDeviceProfile("ideal");
    SimulatedDevice device(free, FindHandModel("H4"), path.CalcPose(0, 0));
    HandMotion hand(device, path, params, Vec3{0});
    double lowest = 1e9;
    for (int tick = 0; tick < 16'000; ++tick) {
      hand.Advance(0.001);
      device.Elapse(0.001);
      lowest = std::min(lowest, device.p_WC_mm().z);
    }
    EXPECT_NEAR(lowest, 0.5, 0.5);  // end of the stroke, except for the lag of its last moment
    EXPECT_GE(hand.passes(), 2);
  }
  {
    // The handle is so heavy that it does not move.
    DeviceProfile held = FindDeviceProfile("ideal");
    held.mass_kg = 1e9;
    SimulatedDevice device(held, FindHandModel("H4"), path.CalcPose(0, 0));
    HandMotion hand(device, path, params, Vec3{0});
    for (int tick = 0; tick < 20'000; ++tick) {
      hand.Advance(0.001);
      device.Elapse(0.001);
    }
    EXPECT_EQ(hand.strokes(), 1);
    EXPECT_EQ(hand.passes(), 0);
  }
}

// An effect that only observes adds its columns and does not change the rest of the log. Its figures agree with the
// column.
TEST(LoopEffects, FragmentsAreFoundWhileItRuns) {
  const Scene plain = ParseScene(kLoopScene, "s.toml");
  const Scene scene = ParseScene(kLoopScene + "[effects.fragments]\n", "s.toml");
  const LoopSummary without = RunVirtual(plain, 6);
  const LoopSummary with = RunVirtual(scene, 6);
  const LoopSummary again = RunVirtual(scene, 6);
  // The effect does not change the force, and its results are reproducible.
  EXPECT_EQ(with.bone_hash, without.bone_hash);
  EXPECT_EQ(with.force_hash, without.force_hash);
  EXPECT_EQ(FragmentsJson(*with.fragments, false), FragmentsJson(*again.fragments, false));
  ASSERT_EQ(with.fragments->events.size(), 1u);
  ASSERT_EQ(with.pieces.size(), 2u);
  EXPECT_EQ(with.fragments->found.pieces.size(), 2u);
  const double time_s = with.fragments->events[0].time_s;
  EXPECT_GT(time_s, 0.5);
  EXPECT_LT(time_s, 6);
  // The event is in the log from the next row on.
  const auto& figures = with.effects.figures;
  std::size_t column = 0;
  while (figures[column].column() != "fragments_pieces") ++column;
  for (std::size_t i = 0; i < with.rows.size(); ++i) {
    const double pieces = with.effects.rows[i * figures.size() + column];
    EXPECT_EQ(pieces, with.rows[i].time_s > time_s + 1e-6 ? 2 : 1) << with.rows[i].time_s;
  }
  EXPECT_NE(FormatLoopReport(scene, with, false).find("- Fragments: one piece separated: "), std::string::npos);
}

const std::string kThroughThePiece = test::kBarToml + test::CutOffToml(1.2);

double Balance(const LoopSummary& s) {
  double mm3 = s.removed_mm3 + s.volume_after_mm3 - s.volume_before_mm3;
  for (const PieceOut& out : s.fragments->out) mm3 += out.volume_mm3;
  return mm3;
}

TEST(LoopEffects, APieceIsTakenOutWhileItRuns) {
  constexpr double kSeconds = 10;
  const LoopSummary held = RunVirtual(ParseScene(kThroughThePiece, "s.toml"), kSeconds);
  const Scene scene = ParseScene(kThroughThePiece + "pieces = \"deleted\"\n", "s.toml");
  const LoopSummary s = RunVirtual(scene, kSeconds);
  ASSERT_EQ(s.fragments->out.size(), 1u);
  const double gone_s = s.fragments->out[0].time_s;
  EXPECT_EQ(s.fragments->out[0].id, 2);
  EXPECT_LT(gone_s, kSeconds - 1);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_NEAR(Balance(s), 0, 1e-9 * s.volume_before_mm3);
  EXPECT_EQ(s.pieces.size(), 1u);
  // The tool is clear of the piece from before its removal starts until after it ends, so the force is unchanged until
  // then.
  double held_N = 0, largest_N = 0;
  ASSERT_EQ(held.rows.size(), s.rows.size());
  for (std::size_t i = 0; i < s.rows.size(); ++i) {
    if (s.rows[i].time_s <= gone_s) {
      ASSERT_EQ(s.rows[i].f_hand_N, held.rows[i].f_hand_N) << s.rows[i].time_s;
    } else {
      held_N = std::max(held_N, static_cast<double>(held.rows[i].thrust_N));
      largest_N = std::max(largest_N, static_cast<double>(s.rows[i].thrust_N));
    }
  }
  EXPECT_GT(held_N, 0.5);
  EXPECT_EQ(largest_N, 0);
  EXPECT_LE(s.force.largest_step_N, s.force.slew_bound_N);
  const LoopSummary again = RunVirtual(scene, kSeconds);
  EXPECT_EQ(again.force_hash, s.force_hash);
  EXPECT_EQ(again.bone_hash, s.bone_hash);
}

TEST(LoopEffects, PieceIsTakenOutInALiveLoop) {
  LoopOptions options;
  const test::EndsAfterMotion end(9, options);
  const LoopSummary s = RunLoop(ParseScene(kThroughThePiece + "pieces = \"moved\"\n", "s.toml"), options, {});
  // The piece is removed during the run or, on a busy machine, at its end.
  ASSERT_GE(s.fragments->out.size(), 1u);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_NEAR(Balance(s), 0, 1e-9 * s.volume_before_mm3);
  ASSERT_GE(s.pieces.size(), 2u);
  EXPECT_EQ(s.pieces[1].place, PieceFate::kMoved);
}

TEST(LoopEffects, PieceIsFoundSoonAfterSeparationInALiveLoop) {
  const Scene scene = ParseScene(kLoopScene + "[effects.fragments]\n", "s.toml");
  LoopOptions options;
  options.seconds = 6;
  constexpr double kMaxLate_ms = 2000;
  std::optional<double> late_ms;
  // A busy machine may cause a long delay, so there are up to three tries. Three long delays would be no coincidence.
  for (int tries = 0; tries < 3 && late_ms.value_or(kMaxLate_ms) >= kMaxLate_ms; ++tries) {
    const LoopSummary s = RunLoop(scene, options, {});
    ASSERT_TRUE(s.fragments.has_value());
    ASSERT_LE(s.fragments->events.size(), 1u);
    late_ms = s.fragments->max_delay_ms;
  }
  ASSERT_TRUE(late_ms.has_value());
  // An upper bound of the delay, measured from the previous look at the bone, 50 ms earlier.
  EXPECT_GT(*late_ms, 1e3 / scene.loop.rate_hz);
  EXPECT_LT(*late_ms, kMaxLate_ms);
}

TEST(LoopEffects, AddTheirColumnsAndFigures) {
  const Scene plain = ParseScene(kLoopScene, "s.toml");
  const LoopSummary none = RunVirtual(plain, 0.1);
  EXPECT_TRUE(none.effects.empty());
  EXPECT_EQ(FormatLoopJson(plain, none).find("\"effects\""), std::string::npos);
  EXPECT_NE(FormatLoopCsv(none).find("fidelity,status\n"), std::string::npos);

  // Both runs have the effects that heat requires.
  const std::string needed = kLoopScene + "[effects.tangential_force]\n";
  const Scene warm = ParseScene(needed + "[effects.heat]\n", "s.toml");
  const LoopSummary without = RunVirtual(ParseScene(needed, "s.toml"), 2);
  const LoopSummary with = RunVirtual(warm, 2);
  EXPECT_NE(FormatLoopReport(warm, with, false).find("- Effect: heat: "), std::string::npos);
  ASSERT_EQ(with.effects.on, (std::vector<std::string>{"tangential_force", "heat"}));
  const auto figures = std::span(with.effects.figures).subspan(without.effects.figures.size());
  ASSERT_FALSE(figures.empty());
  const std::string columns = with.effects.Header();
  EXPECT_EQ(columns.substr(without.effects.Header().size(), 6), ",heat_");

  std::istringstream long_log(FormatLoopCsv(with));
  std::istringstream short_log(FormatLoopCsv(without));
  std::vector<double> last(figures.size());
  std::vector<double> largest(figures.size(), -1e300);
  std::size_t lines = 0;
  for (std::string wide, narrow; std::getline(short_log, narrow); ++lines) {
    ASSERT_TRUE(std::getline(long_log, wide));
    ASSERT_EQ(wide.substr(0, narrow.size()), narrow) << lines;
    std::istringstream more(wide.substr(narrow.size()));
    if (lines == 0) continue;
    for (std::size_t i = 0; i < figures.size(); ++i) {
      char comma = 0;
      more >> comma >> last[i];
      largest[i] = std::max(largest[i], last[i]);
    }
    EXPECT_EQ(more.peek(), EOF);
  }
  EXPECT_EQ(lines, with.counts.ticks + 1);
  const auto json = nlohmann::json::parse(FormatLoopJson(warm, with));
  for (std::size_t i = 0; i < figures.size(); ++i) {
    SCOPED_TRACE(figures[i].column());
    // The values agree to the six digits of the log.
    EXPECT_NEAR(figures[i].last, last[i], 1e-5 * std::abs(last[i]));
    EXPECT_NEAR(figures[i].largest, largest[i], 1e-5 * std::abs(largest[i]));
    EXPECT_EQ(json["effects"]["heat"][figures[i].name]["last"], figures[i].last);
  }
  // The bone became warmer.
  EXPECT_GT(figures[0].largest, figures[0].smallest);
}

TEST_F(LoopReport, SessionThatContinuesInMemoryEqualsOneThatReadsTheFile) {
  fs::create_directories(folder_);
  const Scene scene = ParseScene(kLoopScene + "[material]\nkind = \"uniform\"\nE_GPa = 12\n", "s.toml");
  LoopOptions options = Virtual(2);
  options.output.keep_bones = true;
  const LoopSummary whole = RunLoop(scene, options, {});
  options.output.keep_bones = false;
  options.output.keep_last = true;
  LoopSummary first = RunLoop(scene, options, {});
  EXPECT_GT(whole.removed_mm3, 0);
  EXPECT_EQ(first.after.CalcHash(), whole.after.CalcHash());
  EXPECT_EQ(first.force_hash, whole.force_hash);
  EXPECT_TRUE(first.piece_bones.empty());

  Scene next = scene;
  next.bone.source = BoneSource::kFile;
  next.bone.file = folder_ + "/bone-2.vdb";
  LoopOptions in_memory = Virtual(4);
  in_memory.output.record = folder_ + "/memory.kerf";
  int reads = 0;
  in_memory.read_bone = [&](const ReadBoneOptions& read) {
    ++reads;
    return CopyAsStored(first.after, read);
  };
  const LoopSummary a = RunLoop(next, in_memory, {});
  EXPECT_EQ(reads, 1);
  EXPECT_FALSE(fs::exists(next.bone.file));
  WriteBone(first.after, next.bone.file);
  const LoopSummary b = RunLoop(next, Virtual(4), {});
  EXPECT_GT(a.removed_mm3, 0);
  EXPECT_EQ(a.force_hash, b.force_hash);
  EXPECT_EQ(a.bone_hash, b.bone_hash);
  // The recording refers to the file, which was written later.
  RecordingReader recording(in_memory.output.record);
  const RecordedScene recorded = OpenRecordedScene(recording, "");
  LoopOptions replay = Virtual(1);
  replay.replay.recording = &recording;
  replay.replay.verify = true;
  const LoopSummary again = RunLoop(recorded.scene, replay, {});
  ASSERT_TRUE(again.replayed);
  EXPECT_FALSE(again.replayed->divergence);
  EXPECT_EQ(again.bone_hash, a.bone_hash);
}

// The bone is that of the same run until then, and the recording replays.
TEST_F(LoopReport, ExceptionInsideTheLoopLeavesTheBone) {
  const Scene scene = ParseScene(kLoopScene, "s.toml");
  LoopOptions options = Virtual(3);
  options.output.keep_last = true;
  fs::create_directories(folder_);
  options.output.record = folder_ + "/failed.kerf";
  options.watchers.take_tick = [](const LoopTick& tick, std::span<const double>) {
    if (tick.time_s > 2) throw Error("the window is gone");
  };
  EXPECT_THROW(RunLoop(scene, options, {}), Error);
  options.output.keep_on_failure = true;
  options.output.record = folder_ + "/kept.kerf";
  const LoopSummary s = RunLoop(scene, options, {});
  EXPECT_EQ(s.failure, "the window is gone");
  const Bone whole = MakeSceneBone(scene, {});
  EXPECT_LT(s.after.CalcVolume(), whole.CalcVolume() - 1);
  EXPECT_NE(s.after.CalcHash(), whole.CalcHash());
  ASSERT_TRUE(s.recorded);
  EXPECT_EQ(s.recorded->failure, "");
  RecordingReader recording(options.output.record);
  EXPECT_TRUE(recording.damage().whole_s > 1.9) << recording.damage().whole_s;
}

TEST_F(LoopReport, FewSpareLeavesThatAreSuppliedDoWhatManyDo) {
  // A tick of this scene takes fewer than kFew leaves, and the cut many more.
  constexpr int kFew = 32;
  fs::create_directories(folder_);
  Scene scene = ParseScene(kLoopScene, "s.toml");
  scene.bone.block.voxel_mm = 0.1;
  const LoopSummary many = RunLoop(scene, Virtual(2), {});
  LoopOptions options = Virtual(2);
  options.spare_leaves = kFew;
  options.output.record = folder_ + "/few.kerf";
  const LoopSummary few = RunLoop(scene, options, {});
  EXPECT_FALSE(few.leaves_used_up_s);
  EXPECT_EQ(few.bone_hash, many.bone_hash);
  RecordingReader recording(options.output.record);
  LoopOptions again = Virtual(2);
  again.spare_leaves = kFew;
  again.replay.recording = &recording;
  again.replay.verify = true;
  const LoopSummary replayed = RunLoop(scene, again, {});
  ASSERT_TRUE(replayed.replayed);
  EXPECT_FALSE(replayed.replayed->divergence);
  EXPECT_FALSE(replayed.leaves_used_up_s);
  EXPECT_EQ(replayed.bone_hash, many.bone_hash);
}

TEST_F(LoopReport, ContinuedSessionNamesTheStageThatRepeatsItsRecording) {
  fs::create_directories(folder_);
  LoopOptions first = Virtual(1);
  first.output.record = folder_ + "/first.kerf";
  RunLoop(ParseScene(kLoopScene, "s.toml"), first, {});
  RecordingReader recording(first.output.record);
  const RecordedScene recorded = OpenRecordedScene(recording, "");
  LoopOptions options = Virtual(1);
  options.replay.recording = &recording;
  options.replay.until_s = recording.duration_s();
  options.replay.continues = true;
  std::vector<std::string> expected;  // with their share of the progress
  for (const ExpectedStage& stage : ListLoopStages(recorded.scene, options, false)) expected.push_back(stage.name);

  std::vector<std::string> stages;
  std::map<std::string, double> last;
  RunLoop(recorded.scene, options, [&](const std::string& stage, double fraction) {
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
    last[stage] = fraction;
  });
  EXPECT_THAT(stages, testing::ElementsAre("making the bone", "preparing the session", "repeating the recording",
                                           "cutting", "separating the pieces"));
  EXPECT_THAT(stages, testing::IsSupersetOf(expected));
  EXPECT_EQ(last["repeating the recording"], 1);
  EXPECT_EQ(last["cutting"], 1);
}

TEST_F(LoopReport, CancelledWhileTheBoneIsMadeLeavesNoRecording) {
  Scene scene = ParseScene(kLoopScene, "s.toml");
  scene.bone.source = BoneSource::kMandible;
  scene.bone.mandible.voxel_mm = 0.8;
  for (const double until : {0.0, 0.5, 0.9, 2.0}) {
    LoopOptions options = Virtual(0.01);
    options.output.record = fmt::format("{}/{}.kerf", folder_, until);
    const auto cancel = [&](const std::string& stage, double fraction) {
      if (fraction >= until || stage == "preparing the session") throw Cancelled();
    };
    EXPECT_THROW(LoopSession(scene, options, cancel), Cancelled);
    EXPECT_FALSE(fs::exists(options.output.record));
  }
}

TEST(DescribeRemoved, NamesCoarseVoxelsOnlyWithoutUndo) {
  LoopSummary s;
  s.removed_mm3 = 1;
  s.removed_by_occupancy_mm3 = 1;
  EXPECT_EQ(DescribeRemoved(s), "1.000 mm3");
  s.removed_by_occupancy_mm3 = 3;
  EXPECT_THAT(DescribeRemoved(s), testing::HasSubstr("coarse voxels"));
  s.undo.emplace();
  EXPECT_THAT(DescribeRemoved(s), testing::HasSubstr("coarse voxels"));
  s.undo->restores = 1;
  EXPECT_EQ(DescribeRemoved(s),
            "1.000 mm3 of the bone are gone at the end; the ticks removed 3.000 mm3, including what was undone");
}

}  // namespace
}  // namespace kerf
