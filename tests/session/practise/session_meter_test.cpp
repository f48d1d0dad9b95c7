// Tests that a session is scored while it runs exactly as its recording is.
#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "base/files/files.h"
#include "kerf/error.h"
#include "small_exercise.h"

namespace kerf {
namespace {

class SessionMeterTest : public test::ResultFolderTest {
 protected:
  void SetUp() override {
    ResultFolderTest::SetUp();
    MakeFolder(folder_);
  }
};

struct Scored {
  ScoreSheet live;
  ScoreSheet replayed;
};

/// Runs an agent, scores the session as it runs, and then its recording.
Scored ScoreBothWays(const Scene& scene, const AgentParams& params, const std::string& file) {
  std::atomic<bool> done{false};
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = CalcAgentTime(params, scene);
  loop.output.log = LoopLog::kNone;
  loop.output.record = file;
  loop.output.scene_file = file + ".toml";
  loop.output.keep_bones = true;
  loop.stop = &done;
  loop.driver.make_hand = MakeAgent(params, scene, &done);
  SessionMeter meter(scene);
  loop.watchers.take_tick = [&](const LoopTick& tick, std::span<const double>) { meter.Take(tick); };
  const LoopSummary summary = RunLoop(scene, loop, {});
  EXPECT_TRUE(meter.is_complete());
  Scored scored;
  RecordingReader recording(file);
  const RegionDistance nerve(summary.before, Tissue::kCanal);
  scored.live = meter.Score(recording, summary.before, summary.after, &nerve);
  RecordingReader again(file);
  scored.replayed = ScoreRecording(again, {}, {});
  return scored;
}

TEST_F(SessionMeterTest, GivesTheSheetOfTheReplay) {
  for (const char* id : {"groove", "beside_canal"}) {
    const Scene scene = test::MakeSmallExercise(id);
    const Scored scored = ScoreBothWays(scene, MakeAgentParams("novice", 3), folder_ + "/" + id + ".kerf");
    EXPECT_GT(scored.live.Get("removed_mm3").value(), 0);
    EXPECT_TRUE(scored.live.total);
    EXPECT_TRUE(scored.replayed.warnings.empty());
    EXPECT_EQ(FormatSheetJson(scored.live), FormatSheetJson(scored.replayed));
    EXPECT_EQ(scored.live.steps_digest, scored.replayed.steps_digest);
    ASSERT_TRUE(scored.live.picture);
    EXPECT_EQ(*scored.live.picture, *scored.replayed.picture);
    EXPECT_EQ(FormatSheetHtml(scored.live), FormatSheetHtml(scored.replayed));
  }
}

TEST_F(SessionMeterTest, RefusesASessionWithMissingTicks) {
  const Scene scene = test::MakeSmallExercise("groove");
  const std::string file = folder_ + "/a.kerf";
  const Scored scored = ScoreBothWays(scene, MakeAgentParams("expert", 1), file);
  SessionMeter meter(scene);
  LoopTick tick;
  tick.number = 1;
  meter.Take(tick);
  EXPECT_TRUE(meter.is_complete());
  RecordingReader recording(file);
  const Bone bone;
  EXPECT_THROW(meter.Score(recording, bone, bone), Error);  // another number of ticks
  tick.number = 3;
  meter.Take(tick);
  EXPECT_FALSE(meter.is_complete());
}

}  // namespace
}  // namespace kerf
