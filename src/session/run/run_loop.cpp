#include "session/run/run_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "base/core/hash.h"
#include "bone/grid/surface.h"
#include "device/devices/simulated_device.h"
#include "kerf/error.h"
#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/step_body.h"
#include "session/run/expected_files.h"
#include "session/run/force_noise.h"
#include "session/run/hand_motion.h"
#include "session/run/live_pieces.h"
#include "session/run/loop_actions.h"
#include "session/run/loop_replay.h"
#include "session/run/make_bone.h"
#include "session/run/session_recorder.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

/// Returns true if there is bone inside the tool at its initial pose. Tests points of the tool's mid-plane.
bool IsInBone(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const double reach_mm = CalcReach(tool);
  const double step_mm = std::max(bone.voxel_mm(), reach_mm / 50);
  for (double x = -reach_mm; x <= reach_mm; x += step_mm) {
    for (double y = -reach_mm; y <= reach_mm; y += step_mm) {
      // The point must be at least half a voxel deep, because contact alone does not count.
      if (x * x + y * y < reach_mm * reach_mm && bone.SignedDistance(X_WT.Point({x, y, 0})) < -0.5 * bone.voxel_mm()) {
        return true;
      }
    }
  }
  return false;
}

PartTimes Summarize(const std::string& name, const LogHistogram& times) {
  return {CalcPercentiles(times), name, times.CalcMean_us()};
}

/// Returns a histogram with eight bars per octave, from the first bar to the last one that is not empty.
std::vector<LoopBar> MakeBars(const LogHistogram& times) {
  constexpr std::size_t kBuckets = 4;
  std::vector<LoopBar> bars;
  for (std::size_t i = 0; i + kBuckets <= LogHistogram::kBuckets; i += kBuckets) {
    LoopBar bar;
    bar.lower_us = LogHistogram::LowerEdge_us(i);
    bar.upper_us = LogHistogram::UpperEdge_us(i + kBuckets - 1) + 0.001;
    for (std::size_t k = i; k < i + kBuckets; ++k) bar.count += times.count(k);
    if (bar.count > 0 || !bars.empty()) bars.push_back(bar);
  }
  while (!bars.empty() && bars.back().count == 0) bars.pop_back();
  return bars;
}

/// Processes the loop's log during the run.
class Recorder {
 public:
  Recorder(const Vec3& p_TC_mm, int every, double ticks, LoopLog log, double dt_s, LoopSummary& summary)
      : p_TC_mm_(p_TC_mm),
        every_(static_cast<std::uint64_t>(std::max(every, 1))),
        keeps_rows_(log == LoopLog::kMemory),
        summary_(summary),
        noise_(dt_s) {
    const std::size_t rows = (static_cast<std::size_t>(ticks) + 64) / every_ + 1;
    summary_.force_curve.Reserve(rows);
    if (!keeps_rows_) return;
    // All memory is reserved at once, because each page is costly in locked memory.
    summary_.rows.reserve(rows);
    summary_.effects.rows.reserve(rows * summary_.effects.figures.size());
  }

  void set_recording(SessionRecorder* recording) { recording_ = recording; }
  void set_take_tick(const TakeTick& take_tick) { take_tick_ = take_tick; }
  /// Returns the last pose of the tool; none before the first tick.
  const std::optional<Pose>& X_WT() const { return X_WT_; }

  void Drain(HapticLoop& loop) {
    SpscRing<LoopSample>& samples = loop.samples();
    while (const LoopSample* sample = samples.Peek()) {
      const TickToRecord tick = MakeTickToRecord(sample->report);
      hash_ = MixHash(hash_ ^ tick.hash);
      if (recording_ != nullptr) Record(*sample, tick);
      if (take_tick_) take_tick_(*sample, loop.channels(popped_));
      Take(*sample, loop.channels(popped_));
      samples.Pop();
      ++popped_;
    }
  }

  void Finish() {
    summary_.force_hash = hash_;
    summary_.force.noise_above_20_Hz_mN = noise_.Finish_mN();
    summary_.force.cutting_noise_mN = noise_.cutting_mN();
    FinishMoments();
  }

 private:
  void Record(const LoopSample& s, const TickToRecord& tick) {
    if (s.tick != next_tick_) recording_->Lose(s.tick - next_tick_);
    next_tick_ = s.tick + 1;
    recording_->Take(tick);
  }
  void Take(const LoopSample& s, std::span<const double> channels) {
    const CoupledOutput& out = s.report.out;
    // The device held its force during missed ticks.
    for (int k = 0; k < s.skipped && k < 10'000; ++k) noise_.Hold();
    noise_.Take(s.report.f_device_N, out.engaged_teeth > 0);
    summary_.effect_files.Take(s.time_s, s.time_s - summary_.simulated_s, out.X_WT, channels);
    const double turns = std::abs(s.report.inputs.rpm) / 60 * (s.time_s - summary_.simulated_s);
    summary_.cutting_sums.thrust_turns_N += out.thrust_sum_N * turns;
    if (out.engaged_teeth > 0) summary_.cutting_sums.cutting_turns += turns;
    summary_.simulated_s = s.time_s;
    summary_.force.largest_simulated_N = std::max(summary_.force.largest_simulated_N, glm::length(out.f_H_W_N));
    summary_.hand_J += 1e-3 * out.hand_mJ;
    summary_.spindle_J += 1e-3 * out.spindle_mJ;
    summary_.stored_J += 1e-3 * out.stored_mJ;
    summary_.cut_J += 1e-3 * out.cut_mJ;
    summary_.friction_J += 1e-3 * out.friction_mJ;
    summary_.damping_J += 1e-3 * out.damping_mJ;
    summary_.numerical_J += 1e-3 * out.numerical_mJ;
    summary_.removed_by_occupancy_mm3 += out.removed_mm3;
    if ((out.status & kCoupledLeavesUsedUp) != 0 && !summary_.leaves_used_up_s) summary_.leaves_used_up_s = s.time_s;
    X_WT_ = out.X_WT;
    NoteMoments(s);
    removed_mm3_ += out.removed_mm3;
    if (++ticks_ % every_ != 0) {
      summary_.effects.Take(channels);
      return;
    }
    TakeRow(s, channels);
  }
  void TakeRow(const LoopSample& s, std::span<const double> channels) {
    const CoupledOutput& out = s.report.out;
    LoopRow row;
    row.time_s = s.time_s;
    row.skipped = s.skipped;
    row.p_WC_mm = s.report.X_WH.Point(p_TC_mm_);
    row.p_WT_mm = out.X_WT.p_AB;
    row.f_hand_N = out.f_H_W_N;
    row.f_device_N = s.report.f_device_N;
    row.cut_N = static_cast<float>(glm::length(out.f_cut_W_N));
    row.face_N = static_cast<float>(glm::length(out.f_face_W_N));
    row.friction_N = static_cast<float>(glm::length(out.f_friction_W_N));
    row.thrust_N = static_cast<float>(out.thrust_sum_N);
    row.engaged_teeth = static_cast<float>(out.engaged_teeth);
    row.removed_mm3 = static_cast<float>(removed_mm3_);
    row.tick_us = s.tick_us;
    row.late_us = s.late_us;
    row.fidelity = out.fidelity;
    row.status = out.status;
    removed_mm3_ = 0;
    summary_.force_curve.Add(MakeForcePoint(row));
    if (summary_.force_log) summary_.force_log->Take(row, channels);
    if (!keeps_rows_) return summary_.effects.Take(channels);
    summary_.effects.TakeRow(channels);
    summary_.rows.push_back(row);
  }
  void NoteMoments(const LoopSample& s) {
    const CoupledOutput& out = s.report.out;
    const Vec3 f_W_N = out.f_cut_W_N + out.f_face_W_N + out.f_friction_W_N;
    TickRecord now;
    now.time_s = s.time_s;
    now.X_WT = out.X_WT;
    now.out.engaged_teeth = out.engaged_teeth;
    now.out.f_T_W_N = f_W_N;
    if (!any_) before_ = first_ = peak_ = last_ = {now, now};
    any_ = true;
    const std::array<TickRecord, 2> both{before_[1], now};
    before_ = both;
    summary_.touched = summary_.touched || glm::length(f_W_N) > 0;
    if (out.engaged_teeth <= 0) return;
    if (!engaged_) first_ = both;
    engaged_ = true;
    last_ = both;
    if (glm::length(f_W_N) > peak_N_) {
      peak_N_ = glm::length(f_W_N);
      peak_ = both;
    }
  }
  void FinishMoments() {
    if (!any_) return;
    for (const auto* moment : {&first_, &peak_, &last_}) {
      summary_.moments.push_back((*moment)[0]);
      summary_.moments.push_back((*moment)[1]);
      // Only the position of the preceding tick is used.
      summary_.moments[summary_.moments.size() - 2].out.engaged_teeth = 0;
    }
  }
  SessionRecorder* recording_ = nullptr;
  TakeTick take_tick_;
  std::uint64_t next_tick_ = 1;
  std::optional<Pose> X_WT_;
  Vec3 p_TC_mm_;
  std::uint64_t every_;
  bool keeps_rows_;
  LoopSummary& summary_;
  ForceNoise noise_;  // of the force on the device at every deadline
  std::uint64_t ticks_ = 0;
  std::uint64_t popped_ = 0;
  std::uint64_t hash_ = 0;
  bool any_ = false;
  bool engaged_ = false;
  double peak_N_ = 0;
  std::array<TickRecord, 2> before_, first_, peak_, last_;  // each with the tick before it
  double removed_mm3_ = 0;
};

/// Collects times and counts of a loop that has ended.
void SummarizeLoop(const HapticLoop& loop, const GuardedDevice& device, LoopSummary& s) {
  s.end = loop.end();
  s.failure = loop.failure();
  s.grants = loop.grants();
  s.counts = loop.counts();
  s.device_counts = device.counts();
  s.watchdog_trips = loop.watchdog_trips();
  s.tick = Summarize("tick", loop.tick_times());
  s.lateness = Summarize("lateness", loop.lateness());
  for (std::size_t i = 0; i < kTickStages; ++i) {
    const auto stage = static_cast<TickStage>(i);
    if (loop.stage_times(stage).total() > 0) s.stages.push_back(Summarize(ToString(stage), loop.stage_times(stage)));
  }
  s.stages.push_back(Summarize("exchange", loop.exchange_times()));
  s.tick_bars = MakeBars(loop.tick_times());
  s.lateness_bars = MakeBars(loop.lateness());
  s.fidelity_steps.assign(loop.governor().steps().begin(), loop.governor().steps().end());
  s.fidelity_step_count = loop.governor().step_count();
  s.force.largest_N = device.counts().largest_N;
  s.force.largest_step_N = device.counts().largest_step_N;
}

/// Summarises the bone and its pieces after the run.
void SummarizeBone(Bone bone, const Scene& scene, const LoopOptions& options,
                   const std::function<void(const char*, double)>& show, LoopSummary& s) {
  show("separating the pieces", 0);
  Pieces split = SplitPieces(bone, scene.output.smallest_piece_mm3);
  s.dust_count = split.dust_count;
  s.dust_mm3 = split.dust_mm3;
  const std::span<const PieceOut> out = s.fragments ? s.fragments->out : std::span<const PieceOut>{};
  for (const ResultPiece& piece : ListPieces(split.pieces, out)) s.pieces.push_back(Summarize(piece));
  s.volume_after_mm3 = bone.CalcVolume();
  if (!options.keep_bones) return;
  s.after = std::move(bone);
  s.after.set_note("cut_by_scene", scene.name);
  s.piece_bones = std::move(split.pieces);
}

/// Returns true if undo is possible; a history of the bone is kept only then.
bool NeedsUndo(const LoopOptions& options) {
  if (options.peer != nullptr) return true;
  const auto uses_history = [](const LoopAction& a) { return a.kind != LoopAction::Kind::kSpindle; };
  if (std::any_of(options.actions.begin(), options.actions.end(), uses_history)) return true;
  if (options.replay.recording == nullptr) return false;
  const std::vector<RecordedEvent>& events = options.replay.recording->events();
  return std::any_of(events.begin(), events.end(),
                     [](const RecordedEvent& e) { return e.what == "checkpoint" || e.what == "undo"; });
}

LoopParams MakeLoopParams(const SceneLoop& scene, const LoopOptions& options) {
  LoopParams params;
  params.rate_hz = scene.rate_hz;
  params.watchdog_ms = scene.watchdog_ms;
  params.leaves_per_tick = scene.publish_leaves_per_tick;
  params.governor.degrade = scene.degrade;
  params.governor.budget_share = scene.budget_share;
  params.governor.overrun_share = scene.overrun_share;
  params.governor.calm_s = scene.calm_s;
  params.burn_us = options.burn_us;
  params.burn_from_s = options.seconds / 3;
  params.burn_to_s = 2 * options.seconds / 3;
  return params;
}

}  // namespace

LoopSummary RunLoop(const Scene& scene, const LoopOptions& options,
                    const std::function<void(const std::string&, double)>& progress) {
  const auto show = [&](const char* stage, double fraction) {
    if (progress) progress(stage, fraction);
  };
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error("[simulation] mode = \"slab\" can't be coupled to a handle; set mode = \"voxel\" for 'kerf loop'");
  }
  if (!(options.seconds >= 0.01 && options.seconds <= kMaxLoop_s)) {
    throw Error(fmt::format("the loop can't run for {:g} s; give 0.01 to {:g}", options.seconds, kMaxLoop_s));
  }
  if (options.device.is_set() && options.device.in_real_time && options.virtual_time) {
    throw Error("a real device needs real time: it can't be used in a run in virtual time");
  }
  const double requested_ticks = options.seconds * scene.loop.rate_hz;
  if (options.log == LoopLog::kMemory && requested_ticks > kMaxTicksInMemory) {
    throw Error(fmt::format("{:.0f} ticks are too many to keep in memory (the maximum is {:.0f}); specify a folder",
                            requested_ticks, kMaxTicksInMemory));
  }
  LoopSummary s;
  s.seconds = options.seconds;
  s.rate_hz = scene.loop.rate_hz;
  s.virtual_time = options.virtual_time;
  const double period_s = 1 / scene.loop.rate_hz;
  s.setup = MakeLoopSetup(scene);
  const DeviceProfile& profile = s.setup.profile;
  const HandModel& hand = s.setup.hand;
  s.device = profile.name;
  s.hand = options.device.is_set() ? "" : hand.name;

  StepBodyParams body_params;
  body_params.rpm = scene.tool.rpm;
  body_params.period_s = period_s;
  body_params.force_map = s.setup.force_map;
  // A real device may be plugged in again.
  if (options.device.is_set() && options.device.in_real_time) body_params.give_up_s = kMaxLoop_s;
  s.force.slew_bound_N = scene.device.slew_N_per_s * period_s;
  s.force.scale = s.setup.force_scale;

  CoupledParams params = MakeCoupledParams(scene);
  params.coupling = s.setup.fitted.coupling;

  const Path path = MakePath(scene);
  Bone bone = MakeSceneBone(
      scene, [&](double f) { show("making the bone", f); }, &s.material);
  params.spare_leaves = CountSpareLeaves(bone);
  s.warnings = FindToolWarnings(scene, bone.voxel_mm());
  for (const std::string& warning : FindHandWarnings(scene, s.setup)) s.warnings.push_back(warning);
  s.warnings.insert(s.warnings.end(), s.material.warnings.begin(), s.material.warnings.end());
  s.starts_in_bone = IsInBone(bone, params.tool, path.CalcPose(0, 0));
  if (options.replay.recording != nullptr) CheckBone(options.replay.recording->header(), bone);
  std::optional<SessionRecorder> recording;
  if (!options.record.empty()) {
    RecordingHeader header =
        MakeRecordingHeader(scene, options.scene_file, RecordedKind::kLoop, bone, path.CalcPose(0, 0));
    if (options.replay.recording != nullptr) header.taken_up_from = options.replay.recording->path();
    recording.emplace(options.record, header, ReadSceneFiles(scene, options.scene_file));
  }
  if (options.keep_bones) s.before = bone;
  s.volume_before_mm3 = bone.CalcVolume();
  Bone copy = bone;
  const Vec3 p_TC_mm = params.coupling.p_TC_mm;
  const Pose X_WT_start = path.CalcPose(0, 0);
  CoupledSimulation simulation(std::move(bone), params, X_WT_start);
  s.effects = EffectRecord(simulation.effects());
  const std::string log_folder = options.log == LoopLog::kFolder ? options.folder : "";
  if (options.log != LoopLog::kNone) {
    s.effect_files =
        EffectFiles(simulation.effects(), static_cast<std::size_t>(requested_ticks) + 64, false, log_folder);
  }
  if (!log_folder.empty()) {
    s.force_log = std::make_unique<ForceLog>(log_folder + "/forces.csv", s.effects.Header(),
                                             recording ? CalcRoomForRecording(requested_ticks) : 0);
  }
  SimulatedDeviceOptions device_options;
  device_options.p_TC_mm = p_TC_mm;
  device_options.delay_ticks = scene.device.delay_ticks;
  const double felt_stiffness_N_per_mm = params.coupling.stiffness_N_per_mm * s.setup.force_scale;
  DeviceSlot held(profile);
  std::optional<SimulatedDevice> simulated;
  std::optional<HandMotion> motion;
  std::unique_ptr<HandDriver> other_hand;
  if (!options.device.is_set()) simulated.emplace(profile, hand, X_WT_start, device_options);
  if (simulated && options.make_hand) {
    other_hand = options.make_hand(*simulated, s.setup, p_TC_mm, felt_stiffness_N_per_mm);
  } else if (simulated) {
    motion.emplace(*simulated, path, scene.hand, p_TC_mm, felt_stiffness_N_per_mm);
  }
  if (simulated) held.set_device(*simulated);

  HandDriver* hand_moves = motion ? &*motion : other_hand.get();
  ReplayDevice recorded_device(held);
  const bool replays = options.replay.recording != nullptr;
  GuardedDevice device(replays ? static_cast<Device&>(recorded_device) : held);
  StepBody step_body(simulation, device, body_params, hand_moves);
  std::optional<ChangedHash> voxel_hash;
  if (recording || replays) step_body.set_hash(&voxel_hash.emplace());

  MonotonicClock monotonic;
  VirtualClock virtual_clock;
  LoopClock& clock = options.virtual_time ? static_cast<LoopClock&>(virtual_clock) : monotonic;
  LoopReplay replay(options.replay, step_body, simulation, recorded_device);
  LoopBody& body = replays ? replay.body() : step_body;
  HapticLoop loop(body, device, clock, MakeLoopParams(scene.loop, options));
  if (options.costs.costs) loop.Watch(simulation.effects());
  const auto make_costs = [&] {
    return MakeStageCosts(loop.tick_times(), loop.stages(), simulation.effects(), 1e6 * period_s);
  };
  std::optional<LoopUndo> undo;
  if (NeedsUndo(options)) {
    step_body.set_restores(&undo.emplace(simulation, options.undo_MB).exchange());
    s.undo.emplace();
  }
  BoneMirror mirror(std::move(copy), loop.leaves());
  FragmentsDriver fragments(simulation.effects());
  PieceExchange exchange;
  LivePieces pieces(fragments, loop, exchange, mirror, CalcReach(params.tool));
  if (fragments.is_on() || options.peer != nullptr) {
    mirror.set_listener([&](const LeafMessage& leaf) {
      if (options.peer != nullptr) options.peer->TakeLeaf(leaf);
      if (!fragments.is_on()) return;
      fragments.Change(leaf.index, leaf.values);
      pieces.Take(leaf);
    });
  }
  if (options.peer != nullptr) {
    options.peer->Begin({mirror.bone(), params, s.setup, simulation.effects(), X_WT_start});
  }
  if (fragments.takes_out()) step_body.set_pieces(&exchange);
  if (recording) {
    pieces.set_listener([&](std::uint32_t number, const std::string& bytes) { recording->AddPiece(number, bytes); });
  }
  Recorder recorder(p_TC_mm, scene.output.forces_every_ticks, requested_ticks, options.log, period_s, s);
  recorder.set_recording(recording ? &*recording : nullptr);
  recorder.set_take_tick(options.take_tick);
  const auto stopped = [&] {
    return (options.stop != nullptr && options.stop->load()) || (recording && !recording->failure().empty());
  };
  auto began = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  double line_at_s = 0;
  const auto record_request = [&](const std::string& what, const std::string& name, std::uint32_t number) {
    recorder.Drain(loop);
    if (recording) recording->AddEvent(what, name, number);
  };
  LoopActions actions(options.actions, step_body, undo ? &*undo : nullptr, options.peer, record_request);
  const auto read = [&](double fraction) {
    recorder.Drain(loop);
    if (recording) recording->FlushAt(elapsed_s());
    s.leaves_sent += mirror.Update();
    show("cutting", fraction);
    if (options.costs.live && options.costs.costs && elapsed_s() > line_at_s) {
      options.costs.live(FormatCostLine(make_costs()));
      line_at_s = elapsed_s() + 0.25;
    }
  };

  const std::int64_t ticks_between_searches =
      fragments.is_on() ? std::max<std::int64_t>(1, std::llround(fragments.every_s() * scene.loop.rate_hz)) : 0;
  // Pieces are searched for after fixed numbers of ticks, so that the result is reproducible.
  const auto search = [&](std::int64_t ticks, double time_s) {
    if (ticks % ticks_between_searches != 0) return false;
    loop.state().Update();
    s.leaves_sent += mirror.Update();
    pieces.Poll();
    if (!pieces.is_leaving()) fragments.Search(time_s);
    return true;
  };
  std::int64_t replayed_ticks = 0;
  double replayed_s = 0;
  std::size_t copied = 0;  // events copied from the recording that is continued
  if (replays) {
    replay.set_between_ticks([&](const RecordedStep& step) {
      // The calls below may settle the field, which invalidates pointers to leaves, so all waiting leaves are sent
      // first.
      while (loop.SendRemaining()) read(0);
      if ((step.flags & kRecordedTakenUp) != 0) simulation.bone();
      const std::vector<RecordedEvent>& events = options.replay.recording->events();
      if (recording) {
        read(0);
        for (; copied < events.size() && events[copied].step <= replay.step(); ++copied) {
          recording->AddEvent(events[copied].what, events[copied].name, events[copied].number);
        }
      }
      if (undo) undo->Repeat(step, events);
      if ((step.flags & kRecordedPieceLeaves) == 0) return;
      pieces.Repeat(step.piece, options.replay.recording->ReadPiece(step.piece), s.simulated_s);
    });
    replay.RunWithoutClock(loop, [&](double fraction) {
      if (fraction >= 0) read(fraction);
      if (undo) undo->Poll();
      const auto ticks = static_cast<std::int64_t>(loop.counts().ticks);
      if (fragments.is_on() && ticks > replayed_ticks) search(ticks, replay.time_s());
      replayed_ticks = ticks;
      return !stopped();
    });
    while (loop.SendRemaining()) read(1);
    s.replayed = replay.MakeReport();
    replayed_s = s.replayed->time_s;
    actions.SkipTo(replayed_s, s.warnings);
    if (options.replay.continues) device.Trip();  // the user who continues feels no force at first
    s.replayed->bone_hash = simulation.bone().CalcHash();
    CheckEnd(*options.replay.recording, *s.replayed);
    if (recording) recording->AddEvent("taken up", options.replay.recording->path(), 0);
  }
  const bool continues = !replays || options.replay.continues;
  if (continues && options.device.is_set()) {
    show("waiting for the device", 0);
    held.set_device(options.device.begin(recorder.X_WT().value_or(X_WT_start), params.coupling, s.setup.force_scale));
  }
  if (!continues) {
    loop.RunHere(0);
  } else if (options.virtual_time) {
    const auto ticks = static_cast<std::int64_t>(std::llround(options.seconds * scene.loop.rate_hz));
    std::int64_t done = 0;
    // The injected delay (burn_us) makes the loop miss ticks, so the end is given as a time, not as a number of ticks.
    const std::int64_t end_ns = std::llround(1e9 * options.seconds);
    using Clock = std::chrono::steady_clock;
    Clock::time_point tick_began = Clock::now();
    actions.Act(replayed_s, s.warnings);
    loop.RunHere(ticks, [&] {
      actions.Act(replayed_s + static_cast<double>(done + 1) * period_s, s.warnings);
      if (options.watch != nullptr) {
        const double wall_us = std::chrono::duration<double, std::micro>(Clock::now() - tick_began).count();
        loop.state().Update();
        options.watch->Take(wall_us, loop.state().front().last, simulation);
      }
      if (++done % 64 == 0) read(static_cast<double>(done) / static_cast<double>(ticks));
      if (fragments.is_on() && search(replayed_ticks + done, replayed_s + static_cast<double>(done) * period_s) &&
          !pieces.is_leaving()) {
        pieces.Prepare();
      }
      tick_began = Clock::now();
      return virtual_clock.Now() < end_ns && !stopped();
    });
  } else {
    loop.Start();
    double search_at_s = 0;
    began = std::chrono::steady_clock::now() - loop.CalcElapsed();  // not counting the time for locking the memory
    while (loop.running() && !stopped() && elapsed_s() < options.seconds) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (fragments.is_on()) loop.state().Update();  // everything sent up to now is read below
      read(elapsed_s() / options.seconds);
      actions.Act(replayed_s + elapsed_s(), s.warnings);
      pieces.Poll();
      if (!fragments.is_on() || elapsed_s() < search_at_s || pieces.is_leaving()) continue;
      search_at_s = elapsed_s() + fragments.every_s();
      fragments.Search(loop.state().front().sent_until_s, [&] { return replayed_s + elapsed_s(); });
      pieces.Prepare();
    }
    loop.Stop();
  }
  s.wall_s = elapsed_s();
  // The tool is at rest: send the remaining leaves.
  const auto send_rest = [&] {
    while (loop.SendRemaining()) s.leaves_sent += mirror.Update();
    read(1);
  };
  send_rest();
  if (options.device.figures) s.device_figures = options.device.figures();
  if (recording) {
    recording->Finish(stopped()                ? "stopped"
                      : loop.failure().empty() ? "asked"
                                               : loop.failure(),
                      simulation.bone().CalcHash());
    s.recorded = {options.record, recording->bytes(), recording->steps(), recording->failure()};
  }
  pieces.Finish(simulation, s.simulated_s, send_rest);

  if (actions.left() > 0) {
    s.warnings.push_back(fmt::format("the loop ended before {} of the requested actions, the first at {:g} s",
                                     actions.left(), actions.next_s()));
  }
  if (undo) {
    undo->Poll();
    if (!undo->is_idle()) s.warnings.emplace_back("the loop ended while an action was in progress");
    s.undo->restores = undo->restores();
    s.undo->longest_ms = actions.longest_ms();
    s.undo->checkpoints = undo->journal().checkpoints().size();
    s.undo->kept_MB = 1e-6 * static_cast<double>(undo->journal().CalcMemoryBytes());
  }
  SummarizeLoop(loop, device, s);
  if (options.costs.costs) s.costs = make_costs();
  recorder.Finish();
  if (motion) {
    s.passes = motion->passes();
    s.strokes = motion->strokes();
  }
  for (const double mm3 : simulation.CalcRemovedByRegion()) s.removed_mm3 += mm3;
  s.bone_hash = simulation.bone().CalcHash();
  s.mirror_identical = mirror.bone().CalcHash() == s.bone_hash;
  AddLoopWarnings(s, params.spare_leaves);
  if (!s.replayed && !(s.undo && s.undo->restores > 0)) {
    s.cutting_sums.simulated_s = s.simulated_s;
    s.cutting_sums.removed_mm3 = s.removed_mm3;
    s.cutting = CalcCuttingEnergy(scene, s.effects, s.cutting_sums);
    for (const std::string& warning : FindEnergyWarnings(scene, *s.cutting)) s.warnings.push_back(warning);
  }
  s.heat = MakeHeatReport(simulation.effects(), s.moments.empty() ? X_WT_start : s.moments.back().X_WT);
  s.fragments = fragments.MakeReport(mirror.bone().materials());
  SummarizeBone(std::move(simulation).TakeBone(), scene, options, show, s);
  return s;
}

}  // namespace kerf
