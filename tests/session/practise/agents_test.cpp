// Tests of the scores with synthetic surgeons.
#include "session/practise/agents.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/files/files.h"
#include "kerf/error.h"
#include "session/score/review_figures.h"
#include "small_exercise.h"

namespace kerf {
namespace {

class Agents : public test::ResultFolderTest {
 protected:
  ScoreSheet Score(const Scene& scene, const AgentParams& params) {
    MakeFolder(folder_);
    return test::ScoreAgent(scene, params, fmt::format("{}/{}.kerf", folder_, number_++));
  }

 private:
  int number_ = 0;
};

/// Returns an agent without any error.
AgentParams Perfect() {
  AgentParams params;
  params.name = "perfect";
  params.tremor_mm = 0;
  params.pause_s = 2;
  params.correction_Hz = 0.8;
  return params;
}

class Ranking : public Agents, public testing::WithParamInterface<const char*> {};

// A single novice may have the wanted feed by chance: at one seed it is 2.5 or 4.6 mm/s, depending on the voxel. So
// each measure ranks the agents by its mean over the seeds, and the total by every seed.
TEST_P(Ranking, EachScoredMeasureRanksNoviceIntermediateAndExpert) {
  const Scene scene = test::MakeSmallExercise(GetParam());
  constexpr int kSeeds = 3;
  ScoreSheet sheets[kSeeds][3];
  for (std::size_t seed = 0; seed < kSeeds; ++seed) {
    auto& of_seed = sheets[seed];
    for (std::size_t i = 0; i < 3; ++i) of_seed[i] = Score(scene, MakeAgentParams(AgentNames()[i], seed + 1));
    for (std::size_t i = 1; i < 3; ++i) {
      EXPECT_TRUE(of_seed[i].warnings.empty());
      EXPECT_GT(of_seed[i].total.value(), of_seed[i - 1].total.value()) << AgentNames()[i] << " seed " << seed + 1;
    }
    // The best and the worst agent differ in the skill that each exercise tests.
    EXPECT_GT(of_seed[2].total.value(), 60);
    EXPECT_LT(of_seed[0].total.value(), 50);
  }
  for (const Goal& goal : GoalsOf(scene.exercise.kind)) {
    // Up to the goal, there is no error.
    const auto beyond = [&](std::size_t agent) {
      double sum = 0;
      for (const auto& of_seed : sheets) {
        const ScoreSheet& sheet = of_seed[agent];
        sum += std::max(std::abs(sheet.Get(goal.key).value()) - RowOf(sheet, goal.key).goal, 0.0);
      }
      return sum / kSeeds;
    };
    for (std::size_t i = 1; i < 3; ++i) {
      const double worse = beyond(i - 1);
      const double better = beyond(i);
      // If the worse agent does not make this error at all, the better one cannot surpass it.
      EXPECT_TRUE(better < worse || (better == 0 && worse == 0))
          << goal.key << ": " << AgentNames()[i] << " " << better << ", " << AgentNames()[i - 1] << " " << worse;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Each, Ranking,
                         testing::Values("groove", "follow_line", "stop_before_far", "bicortical", "beside_canal",
                                         "mandibulotomy"),
                         [](const auto& of) { return std::string(of.param); });

// The student sees the expert beside their own attempt, so it must do what the exercise asks. The levels differ only in
// aids that the agent does not use, so that one exercise is done at all of them, and the others at one without a stop.
TEST_F(Agents, ExpertIsWithinTheToleranceInEachExercise) {
  for (const Exercise& exercise : ListExercises()) {
    // The mandible takes long to make.
    const bool small = MakeExerciseScene(exercise.id, 1).bone.source == BoneSource::kMandible;
    for (int level = 1; level <= kLevels; ++level) {
      if (level != 2 && exercise.difficulty > 1) continue;
      const Scene scene =
          small ? MakeLevel(test::MakeSmallExercise(exercise.id), level) : MakeExerciseScene(exercise.id, level);
      const ScoreSheet sheet = Score(scene, MakeAgentParams("expert", static_cast<std::uint64_t>(level)));
      const std::string where = exercise.id + ", level " + std::to_string(level) + "\n" + FormatSheet(sheet);
      EXPECT_GT(sheet.total.value(), 88) << where;
      EXPECT_LT(sheet.Get("too_deep_mm").value_or(0), scene.exercise.margin_mm) << where;
      EXPECT_GT(sheet.Get("cut_share").value(), 0.95) << where;
    }
  }
}

TEST_F(Agents, TotalDecreasesWithEachInjectedError) {
  struct Injected {
    const char* what;
    std::function<void(AgentParams&, double)> set;
    std::vector<double> values;
  };
  const std::vector<Injected> all{
      {"offset", [](AgentParams& p, double x) { p.offset_mm = x; }, {0.4, 1.2}},
      {"offset to the other side", [](AgentParams& p, double x) { p.offset_mm = -x; }, {0.4, 1.2}},
      {"roll", [](AgentParams& p, double x) { p.roll_deg = x; }, {3, 8}},
      {"yaw", [](AgentParams& p, double x) { p.yaw_deg = x; }, {3, 8}},
      {"depth", [](AgentParams& p, double x) { p.deeper_mm = x; }, {0.7, 1.4}},
      {"tremor", [](AgentParams& p, double x) { p.tremor_mm = x; }, {0.1, 0.4}},
      {"pauses", [](AgentParams& p, double x) { p.pause_s = x; }, {4, 8}},
  };
  // In soft bone the tool is where the hand intends, so all errors are the injected ones.
  Scene scene = test::MakeSmallExercise("groove");
  scene.bone.block.layers = {{9, 32}};
  const double perfect = Score(scene, Perfect()).total.value();
  EXPECT_GT(perfect, 85);
  for (const Injected& injected : all) {
    double last = perfect;
    for (const double value : injected.values) {
      AgentParams params = Perfect();
      injected.set(params, value);
      const double total = Score(scene, params).total.value();
      EXPECT_LT(total, last) << injected.what << " " << value;
      last = total;
    }
  }
}

TEST_F(Agents, TotalDecreasesWithReactionTimeAndForceAtBreakthrough) {
  Scene scene = test::MakeSmallExercise("bicortical");
  scene.force = ForceLaw("hertz_chip");
  double last_plunge = -1;
  double last = 101;
  for (const double delay_s : {0.05, 0.3, 0.6}) {
    AgentParams params = Perfect();
    params.lookahead_mm = 0;
    params.delay_s = delay_s;
    const ScoreSheet sheet = Score(scene, params);
    EXPECT_GT(sheet.Get("plunge_max_mm").value(), last_plunge) << delay_s;
    EXPECT_LT(sheet.total.value(), last) << delay_s;
    last_plunge = sheet.Get("plunge_max_mm").value();
    last = sheet.total.value();
  }
  // An agent that slows down before the far side plunges less deeply.
  AgentParams careful = Perfect();
  careful.delay_s = 0.6;
  careful.lookahead_mm = 3;
  EXPECT_LT(Score(scene, careful).Get("plunge_max_mm").value(), last_plunge);
}

TEST_F(Agents, BurCutsAGrooveForFullMarks) {
  Scene scene = test::MakeSmallExercise("groove");
  scene.force = ForceLaw("hertz_chip");
  scene.tool.shape = FissureBur{.diameter_mm = 2.1, .length_mm = 8};
  scene.tool.rpm = 30000;
  scene.exercise.feed_mm_per_s = 1;
  scene.path.strokes[0].start_mm = scene.exercise.start_mm + Vec3(0, 0, 2);
  scene.path.strokes[0].end_mm = scene.exercise.start_mm + Vec3(0, 0, 1);
  scene.path.strokes[0].disc_normal = {0, 0, 1};
  AgentParams params = Perfect();
  params.correction_Hz = 4;
  const ScoreSheet sheet = Score(scene, params);
  EXPECT_GT(sheet.total.value(), 97) << FormatSheet(sheet);
  EXPECT_GT(sheet.Get("cut_share").value(), 0.99);
  // The plane of a groove that is wider than deep is that of its way, not its floor.
  params.offset_mm = 0.3;
  params.yaw_deg = -4;
  const ScoreSheet aslant = Score(scene, params);
  EXPECT_NEAR(aslant.Get("plane_yaw_deg").value() - sheet.Get("plane_yaw_deg").value(), -4, 1);
  EXPECT_NEAR(aslant.Get("plane_offset_mm").value() - sheet.Get("plane_offset_mm").value(), 0.3, 0.1);
}

TEST_F(Agents, DrillsHolesAndEachErrorLowersItsMeasure) {
  Scene scene = test::MakeSmallExercise("bicortical");
  scene.force = ForceLaw("hertz_chip");
  scene.tool.shape = TwistDrill{.diameter_mm = 1.5, .length_mm = 12};
  scene.tool.rpm = 5000;
  scene.coupling.params.stiffness_N_per_mm = 8;
  SceneExercise& e = scene.exercise;
  e.kind = ExerciseKind::kDrillHoles;
  e.depth_stop = false;
  e.start_mm = {-3, 0, 0};
  e.further = {{.start_mm = {3, 0, 0}, .into = e.into, .depth_mm = 6}};
  e.depth_mm = 6;
  e.margin_mm = 1;
  e.feed_mm_per_s = 0.8;
  scene.path.strokes[0].start_mm = {-3, 0, 2};
  scene.path.strokes[0].end_mm = {-3, 0, 1};
  scene.path.strokes[0].disc_normal = {0, 0, 1};
  AgentParams params = Perfect();
  params.correction_Hz = 4;
  const ScoreSheet perfect = Score(scene, params);
  EXPECT_GT(perfect.total.value(), 90) << FormatSheet(perfect);
  EXPECT_EQ(perfect.Get("holes_through"), 2);
  EXPECT_LT(perfect.Get("hole_offset_mm").value(), 0.1);
  EXPECT_LT(perfect.Get("hole_angle_deg").value(), 0.3);
  struct Case {
    const char* key;
    double more;
    void (*set)(AgentParams&);
  };
  for (const Case& c : {Case{"plunge_max_mm", 3, [](AgentParams& p) { p.deeper_mm = 3; }},
                        Case{"hole_offset_mm", 0.6, [](AgentParams& p) { p.offset_mm = 0.6; }},
                        Case{"hole_angle_deg", 5, [](AgentParams& p) { p.roll_deg = 5; }}}) {
    AgentParams faulty = params;
    c.set(faulty);
    const ScoreSheet sheet = Score(scene, faulty);
    EXPECT_NEAR(sheet.Get(c.key).value() - perfect.Get(c.key).value(), c.more, 0.2 * c.more) << c.key;
    EXPECT_LT(sheet.total.value(), perfect.total.value() - 5) << c.key;
    for (const Goal& goal : GoalsOf(e.kind)) {
      // A plunge is also a longer way.
      if (std::string_view(goal.key) == c.key || std::string_view(goal.key) == "path_length_mm") continue;
      EXPECT_NEAR(RowOf(sheet, goal.key).points.value(), RowOf(perfect, goal.key).points.value(), 0.1)
          << c.key << " changes " << goal.key;
    }
  }
}

TEST_F(Agents, BladesWithAStrokePlungeAlongTheLineAndATiltLowersItsMeasure) {
  Scene scene = test::MakeSmallExercise("groove");
  scene.force = ForceLaw("hertz_chip");
  scene.tool.rpm = 15000;
  scene.exercise.feed_mm_per_s = 1;
  scene.exercise.margin_mm = 1;
  scene.path.strokes[0].start_mm = scene.exercise.start_mm + Vec3(0, 0, 2);
  scene.path.strokes[0].end_mm = scene.exercise.start_mm + Vec3(0, 0, 1);
  AgentParams params = Perfect();
  params.correction_Hz = 4;
  for (const Tool& tool : {Tool(OscillatingBlade{}), Tool(PiezoInsert{}), Tool(ReciprocatingBlade{.length_mm = 8})}) {
    scene.tool.shape = tool;
    const ScoreSheet perfect = Score(scene, params);
    EXPECT_GT(perfect.total.value(), 95) << FormatSheet(perfect);
    EXPECT_GT(perfect.Get("cut_share").value(), 0.97);
    EXPECT_EQ(perfect.Get("line_share"), 1);
    AgentParams tilted = params;
    tilted.roll_deg = 5;
    const ScoreSheet sheet = Score(scene, tilted);
    EXPECT_NEAR(sheet.Get("plane_angle_deg").value(), 5, 0.5);
    EXPECT_LT(sheet.total.value(), perfect.total.value() - 3);
    for (const Goal& goal : GoalsOf(scene.exercise.kind)) {
      if (std::string_view(goal.key) == "plane_angle_deg") continue;
      EXPECT_NEAR(RowOf(sheet, goal.key).points.value(), RowOf(perfect, goal.key).points.value(), 0.5)
          << "the tilt changes " << goal.key;
    }
  }
}

TEST_F(Agents, SameAgentGivesTheSameScore) {
  const Scene scene = test::MakeSmallExercise("groove");
  const AgentParams params = MakeAgentParams("novice", 4);
  ScoreSheet a = Score(scene, params);
  ScoreSheet b = Score(scene, params);
  a.recording = b.recording = "";
  a.created = b.created = "";
  EXPECT_EQ(FormatSheetJson(a), FormatSheetJson(b));
  AgentParams other = params;
  other.seed = 5;
  EXPECT_NE(Score(scene, other).Get("jitter_mm"), b.Get("jitter_mm"));
}

// By the formula alone, stopping early could increase the score: less path, less time, fewer faults. An incomplete
// attempt is therefore not graded.
TEST_F(Agents, TruncatedRecordingIsMeasuredButNotGraded) {
  MakeFolder(folder_);
  const Scene scene = test::MakeSmallExercise("follow_line");
  const std::string whole_file = folder_ + "/whole.kerf";
  const ScoreSheet whole = test::ScoreAgent(scene, MakeAgentParams("novice", 1), whole_file);
  ASSERT_TRUE(whole.total);
  EXPECT_TRUE(whole.incomplete.empty());
  EXPECT_EQ(whole.state, RecordingState::kWhole);
  const std::string bytes = ReadTextFile(whole_file, std::size_t{1} << 30);
  bool one_would_gain = false;
  bool one_is_short_of_the_line = false;
  for (const double fraction : {0.3, 0.5, 0.7, 0.9}) {
    const std::string file = fmt::format("{}/{:.0f}.kerf", folder_, 100 * fraction);
    WriteTextFile(file, bytes.substr(0, static_cast<std::size_t>(fraction * static_cast<double>(bytes.size()))));
    RecordingReader recording(file);
    ScoreSheet part = ScoreRecording(recording, {}, {});
    EXPECT_FALSE(part.total) << fraction;
    ASSERT_FALSE(part.incomplete.empty()) << fraction;
    EXPECT_EQ(part.incomplete[0], "the recording is cut short");
    // The unreadable part may have finished the exercise, so there is no such message.
    for (const std::string& why : part.incomplete) EXPECT_THAT(why, testing::Not(testing::HasSubstr("not finished")));
    if (part.Get("line_share").value() < 0.8) {
      one_is_short_of_the_line = true;
      ASSERT_EQ(part.incomplete.size(), 2U);
      EXPECT_THAT(part.incomplete[1], testing::StartsWith("in the readable part: the tool was at least "));
    }
    EXPECT_TRUE(part.Get("time_total_s")) << fraction;
    const auto json = nlohmann::json::parse(FormatSheetJson(part));
    EXPECT_EQ(json["complete"], false);
    EXPECT_EQ(json["recording_state"], "cut short");
    EXPECT_TRUE(json["total"].is_null());
    EXPECT_THAT(FormatSheet(part), testing::HasSubstr("not graded: the recording is cut short"));
    for (const MeasureRow& row : part.rows) EXPECT_FALSE(row.points) << row.info->key;
    part.incomplete.clear();
    CalcTotal(part);
    one_would_gain = one_would_gain || part.total.value() > *whole.total;
  }
  EXPECT_TRUE(one_would_gain) << "whole: " << *whole.total;
  EXPECT_TRUE(one_is_short_of_the_line);
}

TEST_F(Agents, AnExerciseThatIsNotFinishedIsNotGraded) {
  MakeFolder(folder_);
  Scene scene = test::MakeSmallExercise("groove");
  std::get<DiscSaw>(scene.tool.shape).diameter_mm = 8;  // so small that it does not cover the whole line at once
  scene.exercise.start_mm = {-6, 0, 0};
  scene.exercise.end_mm = {6, 0, 0};
  scene.path.strokes[0].start_mm = {-6, 0, 5};
  scene.path.strokes[0].end_mm = {-6, 0, 4};
  const AgentParams params = MakeAgentParams("expert", 1);
  std::optional<double> fraction;
  for (const bool finishes : {false, true}) {
    const std::string file = fmt::format("{}/{}.kerf", folder_, finishes);
    std::atomic<bool> done{false};
    LoopOptions loop;
    loop.virtual_time = true;
    loop.seconds = finishes ? CalcAgentTime(params, scene) : 3.5;
    loop.output.log = LoopLog::kNone;
    loop.output.record = file;
    loop.output.scene_file = file + ".toml";
    loop.stop = &done;
    loop.driver.make_hand = MakeAgent(params, scene, &done);
    RunLoop(scene, loop, {});
    RecordingReader recording(file);
    const ScoreSheet sheet = ScoreRecording(recording, {}, {});
    EXPECT_EQ(sheet.state, RecordingState::kWhole);
    EXPECT_EQ(sheet.total.has_value(), finishes) << FormatSheet(sheet);
    EXPECT_EQ(done.load(), finishes);
    EXPECT_EQ(sheet.incomplete.empty(), finishes);
    EXPECT_GT(sheet.Get("line_share").value(), fraction.value_or(-1));
    fraction = sheet.Get("line_share");
  }
}

// The digest covers the inputs of the ticks. Another name, header or seal does not change it; another second does.
TEST_F(Agents, CopiesOfARecordingHaveTheSameDigest) {
  MakeFolder(folder_);
  Scene scene = test::MakeSmallExercise("groove");
  const ScoreSheet one = test::ScoreAgent(scene, MakeAgentParams("expert", 1), folder_ + "/one.kerf");
  scene.title = "of another student";
  scene.name = "another";
  const ScoreSheet two = test::ScoreAgent(scene, MakeAgentParams("expert", 1), folder_ + "/two.kerf");
  const ScoreSheet other = test::ScoreAgent(scene, MakeAgentParams("expert", 2), folder_ + "/other.kerf");
  EXPECT_NE(ReadTextFile(folder_ + "/one.kerf", 1 << 30), ReadTextFile(folder_ + "/two.kerf", 1 << 30));
  EXPECT_EQ(one.steps_digest, two.steps_digest);
  EXPECT_NE(one.steps_digest, other.steps_digest);
  EXPECT_EQ(one.beginning_digest, two.beginning_digest);
  EXPECT_NE(one.beginning_digest, other.beginning_digest);
}

// The beginning ends after kBeginningMoves moves. Whether later moves are present or missing does not change its
// digest.
TEST_F(Agents, RecordingsThatDivergeAfterTheBeginningShareItsDigest) {
  MakeFolder(folder_);
  const auto digest = [&](std::size_t waits, std::size_t moves, double last_mm) {
    const std::string file = fmt::format("{}/{}_{}_{}.kerf", folder_, waits, moves, last_mm);
    RecordingHeader header;
    header.voxel_mm = 1;
    RecordingWriter writer(file, header, {});
    const std::size_t steps = waits + moves + 1;
    for (std::size_t i = 0; i < steps; ++i) {
      RecordedStep step;
      step.X.p_AB.x = 0.01 * static_cast<double>(i < waits ? 0 : i - waits);
      if (i + 1 == steps) step.X.p_AB.y = last_mm;
      writer.Add(step, 0.001 * static_cast<double>(i + 1));
    }
    writer.Flush();
    RecordingReader recording(file);
    return CalcStepsDigests(recording);
  };
  const StepsDigests whole = digest(10, 5000, 0);
  for (const std::size_t moves : {kBeginningMoves + 1, std::size_t{4100}}) {
    const StepsDigests other = digest(10, moves, 1);
    EXPECT_EQ(other.beginning, whole.beginning) << moves;
    EXPECT_NE(other.all, whole.all) << moves;
  }
  EXPECT_NE(digest(10, kBeginningMoves, 1).beginning, whole.beginning);  // its last step differs
  EXPECT_EQ(digest(10, kBeginningMoves, 0).beginning, whole.beginning);
  EXPECT_NE(digest(10, kBeginningMoves - 1, 0).beginning, whole.beginning);  // too short
  EXPECT_NE(digest(11, 5000, 0).beginning, whole.beginning);                 // the wait is part of the beginning
  EXPECT_NE(digest(5001, 10, 0).beginning, digest(5001, 11, 0).beginning);   // but does not count as moves
}

TEST(AgentParams, OutOfRangeIsRefused) {
  EXPECT_THROW(MakeAgentParams("master", 1), Error);
  const Scene scene = test::MakeSmallExercise("groove");
  AgentParams params;
  params.tremor_mm = -1;
  EXPECT_THROW(MakeAgent(params, scene), Error);
  params = {};
  params.delay_s = NAN;
  EXPECT_THROW(MakeAgent(params, scene), Error);
  Scene none = scene;
  none.exercise.given = false;
  EXPECT_THROW(MakeAgent({}, none), Error);
}

}  // namespace
}  // namespace kerf
