#include "kerf/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kerf/error.h"
#include "session/library/progress.h"
#include "session/library/results.h"
#include "session/run/make_bone.h"
#include "session/run/path_tape.h"
#include "session/run/run_loop.h"
#include "session/run/run_slab.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

ChannelRows TakeChannels(EffectRecord&& record) {
  ChannelRows rows;
  for (const EffectFigure& figure : record.figures) rows.names.push_back(figure.effect + "." + figure.name);
  rows.values = std::move(record.rows);
  return rows;
}

/// Returns warnings about the scene and about a run that touched no bone or did not do what was requested.
std::vector<std::string> FindPathWarnings(const Scene& scene, const Bone& bone, const PathRun& run) {
  std::vector<std::string> warnings = FindWarnings(scene, bone.voxel_mm());
  const auto touched = [](const TickRecord& tick) { return tick.touched; };
  if (run.slab_states.empty() && std::ranges::none_of(run.ticks, touched)) {
    warnings.emplace_back("the saw touched no bone on its path");
  }
  const auto count = std::ranges::count_if(run.ticks, [](const TickRecord& tick) { return tick.out.status != 0; });
  if (count > 0) warnings.push_back(fmt::format("{} ticks report that something was not done as requested", count));
  return warnings;
}

}  // namespace

PathRun RunVoxelPath(const Scene& scene, Bone bone, const ShowProgress& progress, const PathTape& tape) {
  RunResult result = RunPath(std::move(bone), MakeSimulationParams(scene), MakePath(scene), scene.simulation.rate_hz,
                             scene.tool.rpm, ThrowIfCancelled(progress), {}, tape);
  PathRun run;
  run.bone = std::move(result.bone);
  run.removed_mm3 = result.removed_mm3;
  run.removed_mm3_by_region = result.removed_mm3_by_region;
  run.channels = TakeChannels(std::move(result.effects));
  run.wall_s = result.wall_s;
  run.ticks = std::move(result.ticks);
  return run;
}

PathRun RunSlabPath(const Scene& scene, const Bone& bone, const ShowProgress& progress, const PathTape& tape) {
  SlabRun result = RunSlab(scene, MakeSlabProfile(scene, bone), ThrowIfCancelled(progress), tape);
  PathRun run;
  run.wall_s = result.wall_s;
  run.ticks = std::move(result.ticks);
  run.slab_states = std::move(result.states);
  return run;
}

PathRun RunAlongPath(const SceneFile& scene, const PathRunOptions& options) {
  return OrCancelled([&] {
    const Scene& values = scene.scene();
    const bool slab = scene.is_slab();
    MaterialSummary material;
    const Bone bone = MakeSceneBone(values, ThrowIfCancelled(PartOf(options.progress, 0, 0.5)), &material);
    RunTape tape({.record = options.record, .scene_file = scene.path()}, values,
                 slab ? RecordedKind::kSlab : RecordedKind::kRun, bone);
    const ShowProgress show = PartOf(options.progress, 0.5, 1);
    PathRun run = slab ? RunSlabPath(values, bone, show, tape.tape()) : RunVoxelPath(values, bone, show, tape.tape());
    tape.Finish(slab ? bone.CalcHash() : run.bone.CalcHash());
    run.warnings = FindPathWarnings(values, bone, run);
    run.warnings.insert(run.warnings.end(), material.warnings.begin(), material.warnings.end());
    return run;
  });
}

PathRun RunAlongPath(const SceneFile& scene, Bone bone, const ShowProgress& progress) {
  return OrCancelled([&] {
    PathRun run = scene.is_slab() ? RunSlabPath(scene.scene(), bone, progress, {})
                                  : RunVoxelPath(scene.scene(), bone, progress, {});
    run.warnings = FindPathWarnings(scene.scene(), bone, run);
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
  LoopSummary summary = RunLoop(scene, loop, [&](const std::string&, double fraction) {
    if (stop != nullptr && stop->load()) ended = true;
    if (!progress || progress(fraction)) return;
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
  if (!summary.failure.empty()) run.warnings.push_back(summary.failure);
  if (summary.recorded && !summary.recorded->failure.empty()) throw Error(summary.recorded->failure);
  if (summary.replayed) run.difference = ToDifference(summary.replayed->divergence);
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
