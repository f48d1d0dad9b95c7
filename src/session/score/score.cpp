#include "session/score/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string_view>

#include "base/compress/bytes.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/path_tape.h"
#include "session/run/run.h"
#include "session/run/run_loop.h"
#include "session/score/cut_measures.h"
#include "session/score/holes.h"
#include "session/score/motion.h"

namespace kerf {
namespace {

/// Time and path length added to the minimum that an exercise takes. The sum costs no points; at twice the sum, half of
/// the points remain.
constexpr double kExtra_s = 5;
constexpr double kExtra_mm = 20;
/// Height above the surface to which a tool is lifted between two plunges.
constexpr double kLift_mm = 3;

using Progress = std::function<void(const std::string&, double)>;

/// Returns the data of a tick that ends at `time_s`; the previous one ended at `last_s`.
MotionTick MakeMotionTick(const LoopTick& sample, double time_s, double last_s) {
  const CoupledOutput& out = sample.coupled;
  MotionTick tick;
  tick.time_s = time_s;
  tick.dt_s = std::max(time_s - last_s, 0.0);
  tick.X_WT = out.X_WT;
  tick.force_N = glm::length(out.f_H_W_N);
  tick.contact = glm::length(out.f_cut_W_N) + glm::length(out.f_face_W_N) > 0 || out.engaged_teeth > 0;
  tick.turns = std::abs(sample.in.rpm) >= 1;
  tick.regions_cut = out.regions_cut;
  return tick;
}

struct ReplayOutcome {
  Bone before;
  Bone after;
  std::vector<std::string> warnings;
};

void NoteDivergence(const std::optional<Divergence>& divergence, std::vector<std::string>& warnings) {
  if (!divergence) return;
  warnings.push_back(
      fmt::format("its replay differs from the recording from {:.3f} s on: {}", divergence->time_s, divergence->what));
}

ReplayOutcome ReplayLoopRecording(RecordingReader& recording, const Scene& scene, const ScoreOptions& options,
                                  const Progress& progress, MotionMeter& meter) {
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = std::clamp(recording.duration_s(), 0.01, kMaxLoop_s);
  loop.output.log = LoopLog::kNone;
  loop.output.keep_bones = true;
  loop.stop = options.stop;
  loop.replay.recording = &recording;
  double last_s = 0;
  loop.watchers.take_tick = [&](const LoopTick& sample, std::span<const double>) {
    meter.Take(MakeMotionTick(sample, sample.time_s, last_s));
    last_s = sample.time_s;
  };
  LoopSummary summary = RunLoop(scene, loop, progress);
  if (options.stop != nullptr && options.stop->load()) throw Error("the scoring was interrupted");
  // A piece that was taken out is not bone that was removed.
  if (summary.fragments) summary.after = PutBack(summary.after, summary.fragments->out);
  ReplayOutcome outcome{std::move(summary.before), std::move(summary.after), {}};
  if (summary.replayed) NoteDivergence(summary.replayed->divergence, outcome.warnings);
  return outcome;
}

ReplayOutcome ReplayRunRecording(RecordingReader& recording, const Scene& scene, const Progress& progress,
                                 MotionMeter& meter) {
  RunReplay replay(recording, 1e300, false);
  Bone before = MakeSceneBone(scene, [&](double f) { progress("making the bone", f); });
  CheckReplays(replay.recording(), before);
  RunResult result =
      RunPath(before, MakeSimulationParams(scene), MakePath(scene), scene.simulation.rate_hz, scene.tool.CalcTickRpm(),
              [&](double f) { progress("cutting", f); }, {}, {.replay = &replay});
  double last_s = 0;
  for (const TickRecord& record : result.ticks) {
    MotionTick tick;
    tick.time_s = record.time_s;
    tick.dt_s = std::max(record.time_s - last_s, 0.0);
    last_s = record.time_s;
    tick.X_WT = record.X_WT;
    tick.force_N = glm::length(record.out.f_T_W_N);
    tick.contact = record.out.engaged_teeth > 0;
    tick.turns = scene.tool.rpm >= 1;
    const int id = record.out.main_region;
    if (id > 0 && id < 256) tick.regions_cut[static_cast<std::size_t>(id) / 64] |= std::uint64_t{1} << (id % 64);
    meter.Take(tick);
  }
  ReplayOutcome outcome{std::move(before), std::move(result.bone), {}};
  NoteDivergence(replay.MakeReport(outcome.after.CalcHash()).divergence, outcome.warnings);
  return outcome;
}

/// Returns the length of the path that suffices for the cuts: along each, down and up as often as the tool plunges, and
/// from one to the next.
double CalcShortPath_mm(const std::vector<WantedCut>& cuts) {
  double path_mm = kExtra_mm;
  const WantedCut* last = nullptr;
  for (const WantedCut& cut : cuts) {
    path_mm += cut.length_mm + 2 * cut.depth_mm + 2 * (cut.plunges - 1) * (cut.depth_mm + kLift_mm);
    if (last != nullptr) path_mm += glm::distance(last->ToWorld({last->length_mm, 0, 0}), cut.start_W);
    last = &cut;
  }
  return path_mm;
}

/// Sets the goals of time, path length and feed, and the values at which half of the points are lost.
void SetHalfValues(const std::vector<WantedCut>& cuts, const SceneExercise& exercise, ScoreSheet& sheet) {
  const double path_mm = CalcShortPath_mm(cuts);
  const double time_s = CalcUnhurriedTime_s(cuts, exercise);
  for (MeasureRow& row : sheet.rows) {
    const std::string_view key = row.info->key;
    if (key == "time_total_s") row.goal = time_s;
    if (key == "path_length_mm") row.goal = path_mm;
    if (key == "feed_error") row.goal = kFeedGood;
    if (row.goal > 0) row.half = 2 * row.goal;
  }
}

/// Reasons for the end of a recording that count as regular, for a loop and for a path.
constexpr std::array<std::string_view, 3> kRegularEnds{"asked", "stopped", "the path's end"};

std::vector<std::string> FindIncomplete(const RecordingReader& recording, const ScoreSheet& sheet) {
  std::vector<std::string> found;
  if (sheet.state != RecordingState::kWhole) {
    found.push_back(fmt::format("the recording is {}", ToString(sheet.state)));
  }
  if (!recording.header().taken_up_from.empty()) found.emplace_back("it continues another recording");
  if (recording.end() &&
      std::find(kRegularEnds.begin(), kRegularEnds.end(), recording.end()->why) == kRegularEnds.end()) {
    found.push_back(fmt::format("the session ended with a failure: {}", recording.end()->why));
  }
  if (!sheet.kind) return found;
  const double fraction = sheet.Get("line_share").value_or(0);
  if (fraction < kFinishedShare && sheet.kind == ExerciseKind::kDrillHoles) {
    found.push_back(fmt::format("the exercise is not finished: {:.0f} of {} holes are at least half as deep as wanted",
                                fraction * static_cast<double>(sheet.holes.size()), sheet.holes.size()));
  } else if (fraction < kFinishedShare) {
    found.push_back(fmt::format(
        "{}: the tool was at least half as deep as wanted along {:.0f} % of the line; {:.0f} % are required",
        sheet.state == RecordingState::kWhole ? "the exercise is not finished" : "in the readable part", 100 * fraction,
        100 * kFinishedShare));
  }
  return found;
}

/// Returns a sheet with everything that the recording states without a replay.
ScoreSheet BeginSheet(RecordingReader& recording, const Scene& scene) {
  const RecordingHeader& header = recording.header();
  const SceneExercise& exercise = scene.exercise;
  ScoreSheet sheet = MakeSheet(exercise.given ? std::optional(exercise.kind) : std::nullopt);
  sheet.recording = recording.path();
  sheet.scene = header.scene_name;
  sheet.title = scene.title;
  sheet.created = header.created;
  sheet.level = exercise.given ? exercise.level : 0;
  sheet.exercise = exercise;
  sheet.strokes = CalcStroke(scene.tool.shape) > 0;
  sheet.state = recording.damage().state;
  sheet.seal = recording.seal();
  const StepsDigests digests = CalcStepsDigests(recording);
  sheet.steps_digest = digests.all;
  sheet.beginning_digest = digests.beginning;
  if (const std::string damage = recording.DescribeDamage(); !damage.empty()) sheet.warnings.push_back(damage);
  return sheet;
}

/// Measures the cut and the motion, and computes the total.
void FinishSheet(const RecordingReader& recording, const Scene& scene, const MotionMeter& meter, const Bone& before,
                 const Bone& after, const RegionDistance* nerve, const Progress& progress, ScoreSheet& sheet) {
  const Tool tool = MakeTool(scene);
  progress("measuring", 0);
  const bool holes = scene.exercise.given && scene.exercise.kind == ExerciseKind::kDrillHoles;
  std::vector<WantedCut> cuts;
  std::vector<DepthGauge> gauges;
  if (scene.exercise.given) {
    cuts = MakeWantedCuts(scene.exercise, tool);
    for (const WantedCut& cut : cuts) {
      if (!holes) gauges.emplace_back(before, cut);
    }
    SetHalfValues(cuts, scene.exercise, sheet);
  }
  MeasureCut(before, after, cuts, meter.FindLeans_deg(gauges), sheet);
  progress("measuring", 0.5);
  std::optional<RegionDistance> computed;
  if (nerve == nullptr) nerve = &computed.emplace(before, Tissue::kCanal);
  if (holes) MeasureHoles(before, cuts, meter.FindDeepest(before, cuts), sheet);
  if (!nerve->empty() && !cuts.empty()) sheet.plan_nerve_mm = nerve->CalcFrom(cuts);
  meter.Finish(tool, gauges, nerve, FindRegionsOf(before, Tissue::kCanal), sheet);
  sheet.incomplete = FindIncomplete(recording, sheet);
  CalcTotal(sheet);
  progress("measuring", 1);
}

MotionMeter MakeMeter(const Scene& scene) {
  return MotionMeter(scene.exercise.given ? scene.exercise.force_limit_N : 0);
}

}  // namespace

double CalcUnhurriedTime_s(const std::vector<WantedCut>& cuts, const SceneExercise& exercise) {
  return CalcShortPath_mm(cuts) / exercise.feed_mm_per_s + kExtra_s;
}

StepsDigests CalcStepsDigests(RecordingReader& recording) {
  constexpr std::size_t kChunk = 4096;  // number of steps; independent of the blocks' sizes
  StepsDigests digests;
  Digest digest{};
  ByteWriter bytes;
  std::size_t count = 0;
  std::size_t moves = 0;
  std::optional<Pose> last;
  const auto add = [&digest](const std::string& chunk) {
    return CalcDigest({reinterpret_cast<const char*>(digest.data()), digest.size()}, chunk);
  };
  RecordedBlock block;
  for (std::size_t i = 0; recording.ReadBlock(i, block); ++i) {
    for (const RecordedStep& step : block.steps) {
      const Vec3& p = step.X.p_AB;
      const Quat& q = step.X.R_AB;
      for (const double x : {p.x, p.y, p.z, q.w, q.x, q.y, q.z, step.dt_s, step.rpm}) bytes.Put(x);
      bytes.Put(step.buttons);
      bytes.Put(step.flags);
      const bool moved = last && (last->p_AB != p || last->R_AB != q);
      last = step.X;
      if (moved && ++moves == kBeginningMoves) digests.beginning = ToHex(add(bytes.bytes()));
      if (++count % kChunk != 0) continue;
      digest = add(bytes.bytes());
      bytes = {};
    }
  }
  digests.all = ToHex(add(bytes.bytes()));
  if (moves < kBeginningMoves) digests.beginning = digests.all;
  return digests;
}

ScoreSheet ScoreRecording(RecordingReader& recording, const ScoreOptions& options,
                          const std::function<void(const std::string&, double)>& progress) {
  const Progress show = [&](const std::string& stage, double fraction) {
    if (progress) progress(stage, fraction);
  };
  const RecordingHeader& header = recording.header();
  if (header.kind == RecordedKind::kSlab) {
    throw Error(fmt::format("{}: is a recording of slab mode, in which no bone is cut", recording.path()));
  }
  const RecordedScene recorded = OpenRecordedScene(recording, options.bone_file);
  const Scene& scene = recorded.scene;
  ScoreSheet sheet = BeginSheet(recording, scene);
  MotionMeter meter = MakeMeter(scene);
  const ReplayOutcome outcome = header.kind == RecordedKind::kLoop
                                    ? ReplayLoopRecording(recording, scene, options, show, meter)
                                    : ReplayRunRecording(recording, scene, show, meter);
  sheet.warnings.insert(sheet.warnings.end(), outcome.warnings.begin(), outcome.warnings.end());
  FinishSheet(recording, scene, meter, outcome.before, outcome.after, nullptr, show, sheet);
  return sheet;
}

SessionMeter::SessionMeter(const Scene& scene) : scene_(scene), meter_(MakeMeter(scene)) {}

void SessionMeter::Take(const LoopTick& tick) {
  is_complete_ = is_complete_ && tick.number == ticks_ + 1;
  ++ticks_;
  // The time is added up as in a replay, so that both give the same figures to the last bit.
  const double last_s = time_s_;
  time_s_ += CalcElapsed(tick.in, scene_.loop.rate_hz);
  meter_.Take(MakeMotionTick(tick, time_s_, last_s));
  if (meter_.begun_s()) begun_s_.store(*meter_.begun_s(), std::memory_order_relaxed);
}

ScoreSheet SessionMeter::Score(RecordingReader& recording, const Bone& before, const Bone& after,
                               const RegionDistance* nerve) const {
  if (!is_complete_ || recording.damage().whole_steps != ticks_) {
    throw Error(fmt::format("{}: does not have the ticks of the session", recording.path()));
  }
  ScoreSheet sheet = BeginSheet(recording, scene_);
  FinishSheet(
      recording, scene_, meter_, before, after, nerve, [](const std::string&, double) {}, sheet);
  return sheet;
}

}  // namespace kerf
