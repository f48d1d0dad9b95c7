#include "kerf/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/library/progress.h"
#include "session/library/results.h"
#include "session/run/make_bone.h"
#include "session/run/session_recorder.h"

namespace kerf {
namespace {

void PutFirst(const std::vector<std::string>& first, std::vector<std::string>& warnings) {
  warnings.insert(warnings.begin(), first.begin(), first.end());
}

}  // namespace

struct Recording::State {
  explicit State(const std::string& path) : reader(path) {}
  const RecordingHeader& header() const { return reader.header(); }
  RecordingReader reader;
};

Recording::Recording(const std::string& path) : state_(std::make_unique<State>(path)) {}
Recording::~Recording() = default;
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;

std::string Recording::kind() const {
  return ToString(state_->header().kind);
}
std::string Recording::created() const {
  return state_->header().created;
}
std::string Recording::version() const {
  return fmt::format("{} ({})", state_->header().version, state_->header().commit);
}
double Recording::rate_hz() const {
  return state_->header().rate_hz;
}
double Recording::duration_s() const {
  return state_->reader.duration_s();
}
std::uint64_t Recording::ticks() const {
  return state_->reader.steps();
}
std::string Recording::damage() const {
  return state_->reader.DescribeDamage();
}

std::vector<RecordedMoment> Recording::moments() const {
  std::vector<RecordedMoment> moments;
  for (const RecordedEvent& event : state_->reader.events()) moments.push_back({event.time_s, event.what, event.name});
  return moments;
}

SceneFile Recording::scene() const {
  const RecordingHeader& header = state_->header();
  const std::string path = header.scene_file.empty() ? header.scene_name + ".toml" : header.scene_file;
  const RecordedScene recorded = OpenRecordedScene(state_->reader, "");
  return SceneFile(recorded.scene, path);
}

std::vector<RecordedInput> Recording::ReadInputs() {
  std::vector<RecordedInput> inputs;
  inputs.reserve(ticks());
  RecordedBlock block;
  for (std::size_t i = 0; state_->reader.ReadBlock(i, block); ++i) {
    double time_s = block.first_time_s;
    for (const RecordedStep& step : block.steps) {
      time_s += CalcElapsed(step, rate_hz());
      inputs.push_back({.time_s = time_s,
                        .X = step.X,
                        .dt_s = step.dt_s,
                        .rpm = step.rpm,
                        .buttons = step.buttons,
                        .set_down = (step.flags & kRecordedSetDown) != 0});
    }
  }
  return inputs;
}

PathRun Recording::ReplayPath(const ShowProgress& progress) {
  if (state_->header().kind == RecordedKind::kLoop) {
    throw Error(fmt::format("{}: is a recording of a tool in a hand, not along a path", state_->reader.path()));
  }
  return OrCancelled([&] {
    const RecordedScene recorded = OpenRecordedScene(state_->reader, "");
    ShownStages shown(ListRunStages(recorded.scene, false), progress);
    MaterialSummary material;
    const Bone bone = MakeSceneBone(recorded.scene, shown.Stage("making the bone"), &material);
    RunReplay replay(state_->reader, std::numeric_limits<double>::infinity(), false);
    CheckReplays(replay.recording(), bone);
    const TickProgress cutting = shown.Stage("cutting");
    const bool slab = state_->header().kind == RecordedKind::kSlab;
    PathRun run = slab ? RunSlabPath(recorded.scene, bone, std::move(material), cutting, {.replay = &replay})
                       : RunVoxelPath(recorded.scene, bone, std::move(material), cutting, {.replay = &replay});
    run.difference = ToDifference(replay.MakeReport(slab ? bone.CalcHash() : run.bone.CalcHash()).divergence);
    PutFirst(replay.FindWarnings(), run.warnings);
    shown.End();
    return run;
  });
}

HandRun Recording::ReplayHand(const ShowProgress& progress) {
  if (state_->header().kind != RecordedKind::kLoop) {
    throw Error(fmt::format("{}: is a recording along a path, not of a tool in a hand", state_->reader.path()));
  }
  return OrCancelled([&] {
    const RecordedScene recorded = OpenRecordedScene(state_->reader, "");
    LoopOptions loop;
    loop.virtual_time = true;
    loop.seconds = std::clamp(state_->reader.damage().whole_s, 0.01, kMaxLoop_s);
    loop.output.scene_file = state_->header().scene_file;
    loop.replay.recording = &state_->reader;
    HandRun run = RunHandLoop(recorded.scene, std::move(loop), nullptr, progress);
    PutFirst(FindDamageWarnings(state_->reader), run.warnings);
    return run;
  });
}

}  // namespace kerf
