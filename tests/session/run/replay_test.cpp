// Tests that a replay is bit-identical, or reports the first tick that differs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/files/files.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "device/devices/profiles.h"
#include "device/devices/simulated_device.h"
#include "kerf/error.h"
#include "session/run/hand_motion.h"
#include "session/run/run_loop.h"
#include "session/run/run_scene.h"
#include "session/run/run_slab_scene.h"
#include "support/block_scene.h"
#include "support/folder.h"
#include "support/forge_recording.h"
#include "support/motion.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// The saw cuts off an end, moves away from it, and returns.
const std::string kPiece = test::CutOffToml(1.2) + "pieces = \"hidden\"\n";

class Replays : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  static Scene MakeScene(const std::string& path, const std::string& more = "") {
    return ParseScene(test::kBarToml + path + more, "/tmp/s.toml");
  }
  LoopOptions Record(const std::string& name, double seconds, bool live = false) const {
    LoopOptions options;
    options.virtual_time = !live;
    options.seconds = seconds;
    options.output.record = Path(name);
    options.output.scene_file = "/tmp/s.toml";
    return options;
  }
  static Replayed Replay(RecordingReader& recording, bool verify = true, double until_s = 1e9) {
    const RecordedScene recorded = OpenRecordedScene(recording, "");
    LoopOptions options;
    options.virtual_time = true;
    options.replay = {&recording, until_s, false, verify, 0};
    return *RunLoop(recorded.scene, options, {}).replayed;
  }
  Replayed Replay(const std::string& name) const {
    RecordingReader recording(Path(name));
    return Replay(recording);
  }
  void ExpectSame(const std::string& name, std::uint64_t ticks) const {
    const Replayed replayed = Replay(name);
    EXPECT_FALSE(replayed.divergence) << replayed.divergence->what << " at " << replayed.divergence->time_s;
    EXPECT_EQ(replayed.steps, ticks);
  }
  /// Writes the same recording with one step changed.
  void Tamper(const std::string& from, const std::string& to, std::uint64_t step,
              const std::function<void(RecordedStep&)>& change) const {
    test::ForgeSteps(Path(from), Path(to), [&](RecordedBlock& block) {
      const std::uint64_t at = step - block.first_step;
      if (step >= block.first_step && at < block.steps.size()) change(block.steps[at]);
    });
  }
  test::Folder own_;
  std::string folder_ = own_.path();
};

TEST_F(Replays, LoopIsIdentical) {
  const Scene scene = MakeScene(test::kThroughBarToml);
  const LoopSummary s = RunLoop(scene, Record("a.kerf", 6), {});
  EXPECT_GT(s.removed_mm3, 5);
  ASSERT_TRUE(s.recorded);
  EXPECT_EQ(s.recorded->failure, "");
  EXPECT_EQ(s.recorded->steps, 6000u);
  // The requirement is at most 1 MB per minute.
  EXPECT_LT(static_cast<double>(s.recorded->bytes), 1e6 * 6 / 60);
  ExpectSame("a.kerf", 6000);
  RecordingReader recording(Path("a.kerf"));
  ASSERT_TRUE(recording.end()->bone_hash);
  EXPECT_EQ(*recording.end()->bone_hash, s.bone_hash);
  // Recording does not change the results.
  LoopOptions without = Record("", 6);
  without.output.record = "";
  const LoopSummary plain = RunLoop(scene, without, {});
  EXPECT_EQ(plain.force_hash, s.force_hash);
  EXPECT_EQ(plain.bone_hash, s.bone_hash);
}

TEST_F(Replays, LoopAt4kHzIsIdentical) {
  const Scene scene = MakeScene(test::kThroughBarToml, "[loop]\nrate_hz = 4000.0\n");
  const LoopSummary s = RunLoop(scene, Record("a.kerf", 3), {});
  EXPECT_EQ(s.recorded->steps, 12'000u);
  EXPECT_LT(static_cast<double>(s.recorded->bytes), 1e6 * 3 / 60);  // the requirement
  ExpectSame("a.kerf", 12'000);
  Tamper("a.kerf", "b.kerf", 6800, [](RecordedStep& step) { step.X.p_AB.z -= 1e-3; });
  EXPECT_EQ(Replay("b.kerf").divergence->step, 6800u);
}

TEST_F(Replays, LiveLoopIsIdentical) {
  const LoopSummary s = RunLoop(MakeScene(test::kThroughBarToml), Record("a.kerf", 4, true), {});
  EXPECT_EQ(s.recorded->steps, s.counts.ticks);
  ExpectSame("a.kerf", s.counts.ticks);
}

// Because of artificial delays, ticks are missed, and the loop switches to coarser ticks and back.
TEST_F(Replays, MissedTicksAndChangedFidelitiesAreIdentical) {
  LoopOptions options = Record("a.kerf", 5);
  options.burn_us = 1500;
  const LoopSummary s = RunLoop(MakeScene(test::kThroughBarToml, "[loop]\ndegrade = true\n"), options, {});
  EXPECT_GT(s.counts.missed, 10u);
  EXPECT_GT(s.fidelity_step_count, 0);
  ExpectSame("a.kerf", s.counts.ticks);
}

TEST_F(Replays, RemovalOfAPieceIsRepeated) {
  const LoopSummary s = RunLoop(MakeScene(kPiece), Record("a.kerf", 10), {});
  ASSERT_EQ(s.fragments->out.size(), 1u);
  EXPECT_LT(s.fragments->out[0].time_s, 9);
  ExpectSame("a.kerf", 10'000);
  // The report is unchanged.
  RecordingReader recording(Path("a.kerf"));
  LoopOptions again;
  again.virtual_time = true;
  again.replay = {&recording, 1e9, false, true, 0};
  const LoopSummary replayed = RunLoop(MakeScene(kPiece), again, {});
  ASSERT_EQ(replayed.fragments->events.size(), s.fragments->events.size());
  // The tolerance is the rounding of a sum of ten thousand milliseconds.
  EXPECT_NEAR(replayed.fragments->events[0].time_s, s.fragments->events[0].time_s, 1e-9);
  ASSERT_EQ(replayed.fragments->out.size(), 1u);
  EXPECT_EQ(replayed.fragments->out[0].id, s.fragments->out[0].id);
  EXPECT_NEAR(replayed.fragments->out[0].time_s, s.fragments->out[0].time_s, 1e-9);
  EXPECT_EQ(replayed.fragments->out[0].volume_mm3, s.fragments->out[0].volume_mm3);
  EXPECT_EQ(replayed.force_hash, s.force_hash);
}

TEST_F(Replays, LiveRemovalOfAPieceIsRepeated) {
  LoopOptions options = Record("a.kerf", 0, true);
  const test::EndsAfterMotion end(9, options);
  const LoopSummary s = RunLoop(MakeScene(kPiece), options, {});
  // The piece is removed during the run or, on a busy machine, at its end.
  ASSERT_GE(s.fragments->out.size(), 1u);
  ExpectSame("a.kerf", s.counts.ticks);
}

/// Requests an undo of everything after `at_s` seconds. done() is true once the undo is complete, however long the
/// machine takes; it ends the loop.
class UndoesAllAndEnds final : public SessionController {
 public:
  explicit UndoesAllAndEnds(double at_s) : at_s_(at_s) {}
  void Begin(const LoopInitialState& /*beginning*/) override {}
  void TakeLeaf(const LeafMessage& /*leaf*/) override {}
  std::optional<LoopAction> NextAction() override {
    if (std::exchange(is_first_, false)) return std::nullopt;  // the loop has not started yet
    const auto now = std::chrono::steady_clock::now();
    if (!began_) began_ = now;  // the loop's own clock started earlier
    if (asked_ || std::chrono::duration<double>(now - *began_).count() < at_s_) return std::nullopt;
    asked_ = true;
    return ParseLoopAction("0:undo=start");
  }
  void Done(const LoopAction& /*action*/, const std::string& failure, std::optional<double>) override {
    EXPECT_EQ(failure, "");
    done_ = true;
  }
  const std::atomic<bool>& done() const { return done_; }

 private:
  double at_s_;
  bool is_first_ = true;
  std::optional<std::chrono::steady_clock::time_point> began_;
  bool asked_ = false;
  std::atomic<bool> done_{false};
};

TEST_F(Replays, UndoAndRedoAreRepeated) {
  for (const bool live : {false, true}) {
    const std::string name = live ? "live.kerf" : "virtual.kerf";
    LoopOptions options = Record(name, live ? 300 : 5, live);
    for (const char* text : {"1:checkpoint=a", "2.2:checkpoint=b", "3:undo", "3.3:undo=a"}) {
      options.undo.actions.push_back(ParseLoopAction(text));
    }
    UndoesAllAndEnds peer(4.6);
    if (live) {
      options.watchers.peer = &peer;
      options.stop = &peer.done();
    } else {
      options.undo.actions.push_back(ParseLoopAction("4.6:undo=start"));
    }
    const LoopSummary s = RunLoop(MakeScene(test::kThroughBarToml), options, {});
    EXPECT_EQ(peer.done(), live);
    EXPECT_EQ(s.undo->restores, 3u) << (s.warnings.empty() ? "" : s.warnings.back());
    ExpectSame(name, s.counts.ticks);
    RecordingReader recording(Path(name));
    EXPECT_EQ(recording.events().size(), 5u);
  }
}

/// Begins with the spindle off, as a window does, and ends after some ticks.
class BeginsWithTheSpindleOff final : public SessionController {
 public:
  void Begin(const LoopInitialState& /*beginning*/) override {}
  void TakeLeaf(const LeafMessage& /*leaf*/) override {}
  std::optional<LoopAction> NextAction() override {
    if (std::exchange(asked_, true)) return std::nullopt;
    return LoopAction{.at_s = 0, .kind = LoopAction::Kind::kSpindle, .rpm = 0, .name = "0"};
  }
  void Done(const LoopAction& /*action*/, const std::string& failure, std::optional<double>) override {
    EXPECT_EQ(failure, "");
  }

 private:
  bool asked_ = false;
};

TEST_F(Replays, TheFirstActionsOfAPeerApplyToTheFirstTick) {
  for (const bool live : {false, true}) {
    LoopOptions options = Record(live ? "live.kerf" : "virtual.kerf", live ? 300 : 0.1, live);
    BeginsWithTheSpindleOff peer;
    std::atomic<bool> stop{false};
    options.watchers.peer = &peer;
    options.stop = &stop;
    int ticks = 0, turning = 0;
    options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double> /*channels*/) {
      turning += tick.in.rpm != 0 ? 1 : 0;
      stop = ++ticks >= 50;
    };
    RunLoop(MakeScene(test::kThroughBarToml), options, {});
    EXPECT_GE(ticks, 50);
    EXPECT_EQ(turning, 0);
  }
}

// With a stopped spindle, nothing is cut after the undo, and redo restores the bone.
TEST_F(Replays, RedoWithTheSpindleStopped) {
  LoopOptions options = Record("a.kerf", 4);
  for (const char* text : {"1:checkpoint=a", "2.5:rpm=0", "3:undo=a", "3.5:redo"}) {
    options.undo.actions.push_back(ParseLoopAction(text));
  }
  const LoopSummary s = RunLoop(MakeScene(test::kThroughBarToml), options, {});
  EXPECT_EQ(s.undo->restores, 2u) << (s.warnings.empty() ? "" : s.warnings.back());
  ExpectSame("a.kerf", 4000);
}

// The session is continued several times. The replay passes through each point of continuation unchanged.
TEST_F(Replays, ContinuedRecordingCanBeContinued) {
  const Scene scene = MakeScene(test::kThroughBarToml, "[simulation]\ncarve_interval_ticks = 16\n");
  RunLoop(scene, Record("0.kerf", 2.11), {});
  for (int i = 0; i < 3; ++i) {
    RecordingReader recording(Path(std::to_string(i) + ".kerf"));
    LoopOptions options = Record(std::to_string(i + 1) + ".kerf", 0.2);
    options.replay = {&recording, 1e9, true, true, 0};
    const LoopSummary s = RunLoop(scene, options, {});
    EXPECT_FALSE(s.replayed->divergence) << i;
  }
  ExpectSame("3.kerf", 2710);
}

TEST_F(Replays, ManyActionsAtOneMoment) {
  LoopOptions options = Record("a.kerf", 3);
  for (int i = 0; i < 100; ++i) options.undo.actions.push_back(ParseLoopAction("1.5:checkpoint=c" + std::to_string(i)));
  for (const char* text : {"1.5:undo=c99", "2:undo=c3", "2.99:undo"})
    options.undo.actions.push_back(ParseLoopAction(text));
  const LoopSummary s = RunLoop(MakeScene(test::kThroughBarToml), options, {});
  EXPECT_EQ(s.undo->restores, 3u) << (s.warnings.empty() ? "" : s.warnings.back());
  ExpectSame("a.kerf", 3000);
}

TEST_F(Replays, ContinuesAfterAnUndo) {
  const Scene scene = MakeScene(test::kThroughBarToml);
  LoopOptions options = Record("a.kerf", 3);
  for (const char* text : {"1:checkpoint=a", "2:undo=a"}) options.undo.actions.push_back(ParseLoopAction(text));
  RunLoop(scene, options, {});
  RecordingReader recording(Path("a.kerf"));
  LoopOptions further = Record("b.kerf", 1);
  further.replay = {&recording, 1e9, true, true, 0};
  // The checkpoint still exists after the continuation.
  further.undo.actions.push_back(ParseLoopAction("3.5:undo=a"));
  const LoopSummary s = RunLoop(scene, further, {});
  EXPECT_EQ(s.undo->restores, 2u) << (s.warnings.empty() ? "" : s.warnings.back());  // the recorded one, and this
  ExpectSame("b.kerf", 4000);
}

TEST_F(Replays, FirstDifferingTickIsReported) {
  RunLoop(MakeScene(test::kThroughBarToml), Record("a.kerf", 3), {});
  // One tick of the cut is changed by a micrometre, which the spring alone turns into a millinewton.
  Tamper("a.kerf", "b.kerf", 1700, [](RecordedStep& step) { step.X.p_AB.z -= 1e-3; });
  Replayed replayed = Replay("b.kerf");
  ASSERT_TRUE(replayed.divergence);
  EXPECT_EQ(replayed.divergence->step, 1700u);
  EXPECT_NEAR(replayed.divergence->time_s, 1.701, 1e-9);
  EXPECT_THAT(replayed.divergence->what, HasSubstr("forces"));
  // Only the hash of a voxel is changed.
  Tamper("a.kerf", "c.kerf", 1500, [](RecordedStep& step) { step.bone_check ^= 1; });
  replayed = Replay("c.kerf");
  ASSERT_TRUE(replayed.divergence);
  EXPECT_EQ(replayed.divergence->step, 1500u);
  EXPECT_EQ(replayed.divergence->what, "the voxels");
  // Without `verify`, the replay continues to the end.
  RecordingReader reader(Path("c.kerf"));
  EXPECT_EQ(Replay(reader, false).steps, 3000u);
}

TEST_F(Replays, AnotherBoneIsRefused) {
  RunLoop(MakeScene(test::kThroughBarToml), Record("a.kerf", 0.5), {});
  for (const char* more : {"[material]\nkind = \"uniform\"\nE_GPa = 12.0\n"}) {
    RecordingReader reader(Path("a.kerf"));
    LoopOptions options;
    options.virtual_time = true;
    options.replay.recording = &reader;
    EXPECT_THAT(test::MessageOf([&] { RunLoop(MakeScene(test::kThroughBarToml, more), options, {}); }),
                HasSubstr("is not the one"));
  }
}

TEST_F(Replays, ContinuesFromAnyTime) {
  const Scene scene = MakeScene(test::kThroughBarToml);
  RunLoop(scene, Record("long.kerf", 4), {});
  RunLoop(scene, Record("short.kerf", 2.5), {});
  const auto go_on = [&](const std::string& from, const std::string& to) {
    RecordingReader recording(Path(from));
    LoopOptions options = Record(to, 1.5);
    options.replay = {&recording, 2.5, true, true, 0};
    return RunLoop(scene, options, {});
  };
  const LoopSummary a = go_on("long.kerf", "a.kerf");
  const LoopSummary b = go_on("short.kerf", "b.kerf");
  EXPECT_EQ(a.replayed->steps, 2500u);
  EXPECT_EQ(a.counts.ticks, 4000u);
  EXPECT_GT(a.removed_mm3, 1);
  EXPECT_EQ(a.bone_hash, b.bone_hash);
  EXPECT_EQ(a.force_hash, b.force_hash);
  // There is no step in the force at the transition between the two hands.
  EXPECT_LE(a.force.largest_step_N, a.force.slew_bound_N);
  ExpectSame("a.kerf", 4000);
}

struct HandAtRest final : HandDriver {
  void Advance(double) noexcept override {}
};

// A recording in which another hand held the handle 12 mm above the path's start: the scene's hand takes kJoin_s for
// that way. Twice the mean speed allows for the hand's spring, and the encoder adds a step.
TEST_F(Replays, HandContinuesWhereAnotherHandWas) {
  const Scene scene = MakeScene(test::kThroughBarToml, "[force]\nlaw = \"hertz_chip\"\n");
  const Pose X_start = MakePath(scene).CalcPose(0, 0);
  LoopOptions options = Record("other.kerf", 0.5);
  options.driver.make_hand = [&](SimulatedDevice& device, const LoopSetup&, const Vec3&, double) {
    device.Place({X_start.R_AB, X_start.p_AB + Vec3(0, 0, 12)});
    return std::make_unique<HandAtRest>();
  };
  RunLoop(scene, options, {});
  RecordingReader recording(Path("other.kerf"));
  options = Record("a.kerf", 2.5);
  options.replay = {&recording, 1e9, true, true, 0};
  double largest_mm = 0;
  std::optional<Vec3> before;
  options.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) {
    if (before) largest_mm = std::max(largest_mm, glm::distance(tick.X_WH.p_AB, *before));
    before = tick.X_WH.p_AB;
  };
  const LoopSummary s = RunLoop(scene, options, {});
  EXPECT_LE(largest_mm, 2 * 12 / kJoin_s * 0.001 + s.setup.profile.resolution_mm);
  EXPECT_LT(glm::distance(*before, X_start.p_AB), 2);
  EXPECT_GT(s.removed_mm3, 0.1);
  ExpectSame("a.kerf", 3000);
}

TEST_F(Replays, RunAlongAPathIsIdentical) {
  const Scene scene = MakeScene(test::kThroughBarToml, "[output]\npictures = false\n");
  const RunSummary s = RunScene(scene, Path("out"), {}, {}, {Path("a.kerf"), "/tmp/s.toml", nullptr});
  RecordingReader recording(Path("a.kerf"));
  // The tool is set down for each of the two strokes, which is a step without a tick.
  EXPECT_EQ(recording.steps(), s.ticks + 2);
  const RecordedScene recorded = OpenRecordedScene(recording, "");
  RunReplay whole(recording, 1e9, true);
  const Replayed replayed = ReplayScene(recorded.scene, whole, [](const std::string&, double) {});
  EXPECT_FALSE(replayed.divergence);
  EXPECT_EQ(replayed.bone_hash, s.hash_after);
  RunReplay part(recording, 1.0, true);
  const Replayed half = ReplayScene(recorded.scene, part, [](const std::string&, double) {});
  EXPECT_EQ(half.steps, 1001u);
  EXPECT_FALSE(half.divergence);
}

TEST_F(Replays, SlabModeIsIdentical) {
  const Scene scene = MakeScene(R"(
[[path.stroke]]
start_mm = [0.0, 0.0, 7.7]
end_mm = [0.0, 0.0, 5.0]
feed_mm_per_s = 3.0
disc_normal = [1.0, 0.0, 0.0]
[simulation]
mode = "slab"
[slab]
direction = [0.0, 0.0, -1.0]
[output]
pictures = false
)");
  const SlabSummary s = RunSlabScene(scene, Path("out"), {}, {Path("a.kerf"), "/tmp/s.toml", nullptr});
  RecordingReader recording(Path("a.kerf"));
  EXPECT_EQ(recording.steps(), s.ticks);
  RunReplay replay(recording, 1e9, true);
  EXPECT_FALSE(
      ReplayScene(OpenRecordedScene(recording, "").scene, replay, [](const std::string&, double) {}).divergence);
  Tamper("a.kerf", "b.kerf", 500, [](RecordedStep& step) { step.X.p_AB.z -= 1e-6; });
  RecordingReader other(Path("b.kerf"));
  RunReplay tampered(other, 1e9, true);
  const Replayed replayed = ReplayScene(scene, tampered, [](const std::string&, double) {});
  ASSERT_TRUE(replayed.divergence);
  EXPECT_EQ(replayed.divergence->step, 500u);
}

// The inputs are part of the recording: the files may change or be deleted.
TEST_F(Replays, InputFilesAreRecorded) {
  WriteTextFile(Path("path.csv"),
                "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,7.7,0.70710678118,0,0.70710678118,0\n"
                "2,0,0,5,0.70710678118,0,0.70710678118,0\n");
  WriteTextFile(Path("s.toml"), test::kBarToml + "[path]\nfile = \"path.csv\"\n[output]\npictures = false\n");
  const Scene scene = ReadScene(Path("s.toml"));
  RunScene(scene, Path("out"), {}, {}, {Path("a.kerf"), Path("s.toml"), nullptr});
  fs::remove(Path("path.csv"));
  RecordingReader recording(Path("a.kerf"));
  const RecordedScene recorded = OpenRecordedScene(recording, "");
  RunReplay replay(recording, 1e9, true);
  const Replayed replayed = ReplayScene(recorded.scene, replay, [](const std::string&, double) {});
  EXPECT_FALSE(replayed.divergence);
  EXPECT_GT(replayed.steps, 1999u);
}

// The device loses ticks, reports nonsense, freezes and does not accept its force.
TEST_F(Replays, FaultsOfTheDeviceAreRepeated) {
  const DeviceProfile profile = FindDeviceProfile("falcon");
  CoupledParams params;
  params.tool = DiscSaw{.diameter_mm = 12, .thickness_mm = 0.5, .teeth = 16};
  BlockParams block;
  block.size_mm = {8, 4, 3};
  block.voxel_mm = 0.2;
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  const Pose X_start{glm::angleAxis(1.5707963267948966, glm::dvec3(0, 1, 0)), {0, 0, 7.6}};
  struct NoReader final : TickObserver {
    void Enter(TickStage) noexcept override {}
  } no_reader;
  std::vector<TickToRecord> ticks;
  {
    CoupledSimulation simulation(bone, params, X_start);
    SimulatedDevice device(profile, FindHandModel("H3"), X_start);
    device.SetIntention({X_start, {0, 0, -3}, {}});
    GuardedDevice guarded(device);
    StepBody body(simulation, guarded, {});
    ChangedHash hash;
    body.set_hash(&hash);
    for (int i = 0; i < 2500; ++i) {
      DeviceFaults faults;
      faults.read_fails = i % 301 > 290;
      faults.not_a_number = i % 211 == 7;
      faults.frozen = i % 150 > 140;
      faults.write_fails = i % 401 > 395;
      device.SetFaults(faults);
      if (i % 500 == 250) body.RampIn();
      if (i == 700) body.SetFidelity(Fidelity::kCoarse);
      if (i == 1100) body.SetFidelity(Fidelity::kSlab);
      if (i == 1500) body.SetFidelity(Fidelity::kFull);
      if (i == 1700) body.set_rpm(0);
      if (i == 1800) body.set_rpm(-6000);
      LoopTick tick;
      body.Tick(i % 97 == 0 ? 0.004 : 0.001, no_reader, tick);
      body.ClearChanged(body.changed_count());
      ticks.push_back(MakeTickToRecord(tick));
    }
    EXPECT_GT(hash.leaves(), 10u);
  }
  {
    RecordingHeader header;
    header.voxel_mm = 0.2;
    header.state_every_steps = 1'000'000'000;  // none is written here
    header.hash_every_steps = 1'000'000'000;
    RecordingWriter writer(Path("a.kerf"), header, {});
    for (const TickToRecord& tick : ticks) writer.Add(tick.step, 0);
  }
  // The recording is replayed, except for steps that were not flushed after the last block.
  RecordingReader recording(Path("a.kerf"));
  EXPECT_EQ(recording.steps(), 2250u);
  CoupledSimulation simulation(bone, params, X_start);
  SimulatedDevice behind(profile, FindHandModel("H3"), X_start);
  ReplayDevice device(profile);
  device.set_device(behind);
  GuardedDevice guarded(device);
  StepBody step_body(simulation, guarded, {});
  ChangedHash hash;
  step_body.set_hash(&hash);
  ReplayBody body(step_body, simulation, device, recording, 1e9, [](const RecordedStep&) {});
  while (body.Prepare()) {
    LoopTick tick;
    body.Tick(1, no_reader, tick);
    body.ClearChanged(body.changed_count());
  }
  EXPECT_EQ(body.steps().step(), 2250u);
  const std::optional<Divergence>& divergence = body.steps().divergence();
  EXPECT_FALSE(divergence) << divergence->step << divergence->what;
}

}  // namespace
}  // namespace kerf
