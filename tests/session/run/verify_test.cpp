// Tests of a replay's comparisons other than forces and voxels (rows of states, hashes, events), and of its extent if
// steps are missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "base/files/files.h"
#include "session/run/run_loop.h"
#include "session/run/session_recorder.h"
#include "support/block_scene.h"
#include "support/folder.h"
#include "support/forge_recording.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

const std::string kVerifyScene = test::BlockToml({6, 4, 4}, 0.25) + test::SawToml(12, 0.5, 16) +
                                 test::StrokeToml({0, 0, 8.2}, {0, 0, 4.5}, 4, {1, 0, 0});

class Verifies : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  /// Records a session with a checkpoint, an undo, a redo and two spindle speeds.
  LoopSummary Record() const {
    LoopOptions options;
    options.virtual_time = true;
    options.seconds = 1.5;
    options.output.record = Path("a.kerf");
    for (const char* text : {"0.3:checkpoint=first", "0.8:rpm=0", "0.9:undo=first", "1:redo", "1.2:rpm=5000"}) {
      options.undo.actions.push_back(ParseLoopAction(text));
    }
    return RunLoop(ParseScene(kVerifyScene, "/tmp/s.toml"), options, {});
  }
  static Replayed Replay(const std::string& file) {
    RecordingReader recording(file);
    const RecordedScene recorded = OpenRecordedScene(recording, "");
    LoopOptions options;
    options.virtual_time = true;
    options.replay = {&recording, 1e9, false, true, 0};
    return *RunLoop(recorded.scene, options, {}).replayed;
  }
  /// Returns the divergence of b.kerf; empty if it replays as recorded.
  std::string Verify() const {
    const Replayed replayed = Replay(Path("b.kerf"));
    std::filesystem::remove(Path("b.kerf"));
    return replayed.divergence ? replayed.divergence->what : "";
  }
  std::string ForgeState(std::uint64_t step, const std::function<void(RecordedState&)>& change) const {
    test::ForgeSteps(Path("a.kerf"), Path("b.kerf"), [&](RecordedBlock& block) {
      for (RecordedState& state : block.states) {
        if (state.step == step) change(state);
      }
    });
    return Verify();
  }
  std::string ForgeEvent(const std::string& what, const std::function<void(Json&)>& change) const {
    test::ForgeRecording(Path("a.kerf"), Path("b.kerf"), [&](BlockKind kind, std::string& bytes) {
      if (kind != BlockKind::kEvent) return;
      Json event = Json::parse(bytes);
      if (event.at("what") == what) change(event);
      bytes = event.dump();
    });
    return Verify();
  }

  test::Folder own_;
  std::string folder_ = own_.path();
};

TEST_F(Verifies, EveryColumnOfEveryRowOfStates) {
  Record();
  test::ForgeSteps(Path("a.kerf"), Path("b.kerf"), [](RecordedBlock&) {});
  EXPECT_EQ(Verify(), "") << "a recording that was only rewritten is unchanged";
  // The value is changed by the smallest amount that a row can represent.
  EXPECT_THAT(ForgeState(999, [](RecordedState& s) { s.time_s += 1e-6; }), HasSubstr("time_s was recorded as 1 "));
  EXPECT_THAT(ForgeState(999, [](RecordedState& s) { s.p_WT_mm.x += 1e-3; }), HasSubstr("tool_x_mm was recorded as"));
  EXPECT_THAT(ForgeState(999, [](RecordedState& s) { s.p_WT_mm.z -= 1e-3; }), HasSubstr("tool_z_mm was recorded as"));
  EXPECT_THAT(ForgeState(1499, [](RecordedState& s) { s.f_N.y += 1e-3; }), HasSubstr("force_y_N was recorded as"));
  EXPECT_THAT(ForgeState(9, [](RecordedState& s) { s.removed_mm3 += 1e-3; }), HasSubstr("removed_total_mm3 was rec"));
  EXPECT_THAT(ForgeState(749, [](RecordedState& s) { s.engaged_teeth += 1e-3; }), HasSubstr("engaged_teeth was rec"));
}

TEST_F(Verifies, MissingAndExtraRows) {
  Record();
  const auto forge = [&](const std::function<void(RecordedBlock&)>& change) {
    test::ForgeSteps(Path("a.kerf"), Path("b.kerf"), [&](RecordedBlock& block) {
      if (block.first_step == 900) change(block);
    });
    const Replayed replayed = Replay(Path("b.kerf"));
    std::filesystem::remove(Path("b.kerf"));
    return replayed.divergence;
  };
  const auto gone = forge([](RecordedBlock& block) { block.states.erase(block.states.begin()); });
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->step, 909u);
  EXPECT_THAT(gone->what, HasSubstr("row of states is missing"));
  const auto come = forge([](RecordedBlock& block) { block.states.front().step = 905; });
  ASSERT_TRUE(come);
  EXPECT_EQ(come->step, 905u);
  EXPECT_THAT(forge([](RecordedBlock& block) { block.hashes.clear(); })->what, HasSubstr("hashes are missing"));
}

TEST_F(Verifies, EveryEvent) {
  Record();
  EXPECT_EQ(ForgeEvent("undo", [](Json&) {}), "");
  EXPECT_THAT(ForgeEvent("checkpoint", [](Json& e) { e["number"] = 2; }), HasSubstr("\"checkpoint first\" at 0.300 s"));
  EXPECT_THAT(ForgeEvent("checkpoint", [](Json& e) { e["name"] = "other"; }), HasSubstr("has another name"));
  EXPECT_THAT(ForgeEvent("checkpoint", [](Json& e) { e["what"] = "undo"; }), HasSubstr("event"));
  EXPECT_THAT(ForgeEvent("undo", [](Json& e) { e["name"] = "start"; }), HasSubstr("has another name"));
  EXPECT_THAT(ForgeEvent("redo", [](Json& e) { e["number"] = 7; }), HasSubstr("has checkpoint 7"));
  EXPECT_THAT(ForgeEvent("redo", [](Json& e) { e["what"] = "taken up"; }), HasSubstr("event"));
  EXPECT_THAT(ForgeEvent("rpm", [](Json& e) { e["what"] = "coffee"; }), HasSubstr("unknown kind"));
  // An event's time is a sum of ticks and is compared to the last bit.
  EXPECT_THAT(ForgeEvent("rpm", [](Json& e) { e["time_s"] = std::nextafter(e["time_s"].get<double>(), 9); }),
              HasSubstr("belongs to"));
  EXPECT_THAT(ForgeEvent("undo", [](Json& e) { e["step"] = e["step"].get<int>() - 1; }), HasSubstr("belongs to"));
}

TEST_F(Verifies, ARecordingOfVersion1) {
  const std::string file =
      KERF_SOURCE_DIR "/tests/loop/record/data/version_1.kerf";  // of a tree with changes: its commit ends with "+"
  RecordingReader recording(file);
  EXPECT_EQ(recording.damage().state, RecordingState::kWhole);
  EXPECT_EQ(recording.steps(), 1500u);
  EXPECT_EQ(recording.events().size(), 5u);
  EXPECT_FALSE(recording.seal().is_chained);
  EXPECT_THAT(DescribeSeal(recording.seal(), {}), HasSubstr("not sealed"));
  EXPECT_EQ(recording.header().computation, 1);
  EXPECT_EQ(test::MessageOf([&] { Replay(file); }),
            file + ": the recording was made by kerf 0.1.0 of commit " + recording.header().commit.substr(0, 12) +
                "+, whose forces differ from those of this build; replay it with a build of that "
                "commit");
}

TEST_F(Verifies, ReplayEndsAtTheFirstGap) {
  Record();
  std::string bytes = ReadTextFile(Path("a.kerf"));
  BlockReader blocks(Path("a.kerf"));
  for (const BlockPlace& place : blocks.places()) {
    if (place.kind == BlockKind::kSteps && DecodeBlock(blocks.Read(place)).first_step == 550) {
      bytes[place.offset + place.packed_bytes / 2] ^= 4;
    }
  }
  std::ofstream(Path("b.kerf"), std::ios::binary) << bytes;
  RecordingReader recording(Path("b.kerf"));
  EXPECT_EQ(recording.damage().gaps.size(), 1u);
  EXPECT_EQ(recording.damage().whole_steps, 550u);
  EXPECT_EQ(recording.events().size(), 5u) << "events after the gap are read";
  const Replayed replayed = Replay(Path("b.kerf"));
  EXPECT_FALSE(replayed.divergence) << replayed.divergence->what;
  EXPECT_EQ(replayed.steps, 550u);
}

}  // namespace
}  // namespace kerf
