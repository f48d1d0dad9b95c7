#include "kerf/run.h"

#include <utility>

#include "kerf/error.h"
#include "session/library/progress.h"
#include "session/library/results.h"
#include "session/run/make_bone.h"
#include "session/run/path_tape.h"
#include "session/run/run_loop.h"
#include "session/run/run_scene.h"
#include "session/run/run_slab.h"
#include "session/run/run_slab_scene.h"
#include "session/run/run_warnings.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {
namespace {

ChannelRows TakeChannels(EffectRecord&& record) {
  ChannelRows rows;
  for (const EffectFigure& figure : record.figures) rows.names.push_back(figure.effect + "." + figure.name);
  rows.values = std::move(record.rows);
  return rows;
}

}  // namespace

PathRun RunVoxelPath(const Scene& scene, Bone bone, MaterialSummary material, const TickProgress& progress,
                     const PathTape& tape) {
  const Path path = MakePath(scene);
  RunSummary summary;
  summary.voxel_mm = bone.voxel_mm();
  summary.material = std::move(material);
  RunResult result = RunPath(std::move(bone), MakeSimulationParams(scene), path, scene.simulation.rate_hz,
                             scene.tool.CalcTickRpm(), progress, {}, tape);
  SummarizeTicks(scene, path, result, summary);
  PathRun run;
  run.bone = std::move(result.bone);
  run.removed_mm3 = result.removed_mm3;
  run.removed_mm3_by_region = result.removed_mm3_by_region;
  run.channels = TakeChannels(std::move(result.effects));
  run.wall_s = result.wall_s;
  run.ticks = std::move(result.ticks);
  run.warnings = FindRunWarnings(scene, summary);
  return run;
}

PathRun RunSlabPath(const Scene& scene, const Bone& bone, MaterialSummary material, const TickProgress& progress,
                    const PathTape& tape) {
  SlabSummary summary;
  summary.voxel_mm = bone.voxel_mm();
  summary.material = std::move(material);
  SlabRun result = RunSlab(scene, MakeSlabProfile(scene, bone), progress, tape);
  if (result.ticks.empty()) throw Error("the recording contains no tick");
  SummarizeSlabRun(scene, MakeSlabParams(scene), result, summary);
  PathRun run;
  run.wall_s = result.wall_s;
  run.ticks = std::move(result.ticks);
  run.slab_states = std::move(result.states);
  run.warnings = FindSlabRunWarnings(scene, summary);
  return run;
}

PathRun RunAlongPath(const SceneFile& scene, const PathRunOptions& options) {
  return OrCancelled([&] {
    const Scene& values = scene.scene();
    const bool slab = scene.is_slab();
    ShownStages shown(ListRunStages(values, false), options.progress);
    MaterialSummary material;
    const Bone bone = MakeSceneBone(values, shown.Stage("making the bone"), &material);
    RunTape tape({.record = options.record, .scene_file = scene.path()}, values,
                 slab ? RecordedKind::kSlab : RecordedKind::kRun, bone);
    const TickProgress cutting = shown.Stage("cutting");
    PathRun run = slab ? RunSlabPath(values, bone, std::move(material), cutting, tape.tape())
                       : RunVoxelPath(values, bone, std::move(material), cutting, tape.tape());
    tape.Finish(slab ? bone.CalcHash() : run.bone.CalcHash());
    shown.End();
    return run;
  });
}

PathRun RunAlongPath(const SceneFile& scene, Bone bone, const ShowProgress& progress) {
  return OrCancelled([&] {
    ShownStages shown({{"cutting", 1}}, progress);
    const TickProgress cutting = shown.Stage("cutting");
    PathRun run = scene.is_slab() ? RunSlabPath(scene.scene(), bone, {}, cutting, {})
                                  : RunVoxelPath(scene.scene(), std::move(bone), {}, cutting, {});
    shown.End();
    return run;
  });
}

HandRun RunHandLoop(const Scene& scene, LoopOptions loop, const std::atomic<bool>* stop, const ShowProgress& progress) {
  HandRun run;
  std::atomic<bool> ended = false;
  bool cancelled = false;
  std::vector<double> channels;
  loop.stop = &ended;
  loop.output.log = LoopLog::kNone;
  loop.output.keep_bones = true;
  loop.output.keep_last = true;
  loop.watchers.take_tick = [&](const LoopTick& tick, std::span<const double> values) {
    run.ticks.push_back({.time_s = tick.time_s,
                         .X_WH = tick.X_WH,
                         .rpm = tick.in.rpm,
                         .out = tick.coupled,
                         .f_device_N = tick.force.f_H_W_N,
                         .tau_device_Nmm = tick.force.tau_H_W_Nmm,
                         .faults = tick.faults});
    channels.insert(channels.end(), values.begin(), values.end());
    if (stop != nullptr && stop->load()) ended = true;
  };
  ShownStages shown(ListLoopStages(scene, loop, false), progress);
  LoopSummary summary = RunLoop(scene, loop, [&](const std::string& stage, double fraction) {
    if (stop != nullptr && stop->load()) ended = true;
    if (shown.Show(stage, fraction)) return;
    cancelled = true;
    ended = true;
  });
  if (cancelled) throw Cancelled();
  run.bone = std::move(summary.after);
  run.removed_mm3 = summary.removed_mm3;
  run.channels = TakeChannels(std::move(summary.effects));
  run.channels.values = std::move(channels);
  run.wall_s = summary.wall_s;
  run.warnings = std::move(summary.warnings);
  if (summary.end == LoopEnd::kFailed) throw Error(summary.failure);
  if (!summary.failure.empty()) run.warnings.push_back(summary.failure);
  if (summary.recorded && !summary.recorded->failure.empty()) throw Error(summary.recorded->failure);
  if (summary.replayed) run.difference = ToDifference(summary.replayed->divergence);
  shown.End();
  return run;
}

HandRun RunInHand(const SceneFile& scene, const HandRunOptions& options) {
  LoopOptions loop;
  loop.seconds = options.seconds;
  loop.virtual_time = !options.real_time;
  loop.output.record = options.record;
  loop.output.scene_file = scene.path();
  if (options.device != nullptr) {
    loop.driver.device.begin = [&](const Pose&, const CouplingParams&, double) -> Device& { return *options.device; };
    loop.driver.device.in_real_time = options.real_time;
  }
  CheckParameters(loop);
  return OrCancelled([&] { return RunHandLoop(scene.scene(), std::move(loop), options.stop, options.progress); });
}

}  // namespace kerf
