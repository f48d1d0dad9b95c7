#include "session/run/loop_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "base/core/cancelled.h"
#include "bone/grid/set_leaf.h"
#include "bone/grid/shared_leaves.h"
#include "cut/effects/guide.h"
#include "cut/hand_sim/internals.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "loop/haptics/bone_mirror.h"
#include "session/run/bone_cache.h"
#include "session/run/expected_files.h"
#include "session/run/live_pieces.h"
#include "session/run/loop_actions.h"
#include "session/run/loop_handle.h"
#include "session/run/loop_mover.h"
#include "session/run/loop_recorder.h"
#include "session/run/loop_summary.h"
#include "session/run/make_bone.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

using WallClock = std::chrono::steady_clock;

constexpr double kBetweenLines_s = 0.25;  // between two lines of costs

/// Returns true if there is bone inside the tool at its initial pose. Tests points of the tool's surface and, of a
/// blade, its middle plane.
bool IsInBone(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const std::vector<Vec3> points_T = SampleToolSurface(tool, std::max(bone.voxel_mm(), CalcReach(tool) / 50));
  // A point must be at least half a voxel deep, because contact alone does not count.
  return std::any_of(points_T.begin(), points_T.end(),
                     [&](const Vec3& p_T) { return bone.SignedDistance(X_WT.Point(p_T)) < -0.5 * bone.voxel_mm(); });
}

/// Returns true if undo is possible; a history of the bone is kept only then.
bool NeedsUndo(const LoopOptions& options) {
  if (options.watchers.peer != nullptr && options.watchers.peer->needs_undo()) return true;
  const auto uses_history = [](const LoopAction& a) { return a.kind != LoopAction::Kind::kSpindle; };
  if (std::any_of(options.undo.actions.begin(), options.undo.actions.end(), uses_history)) return true;
  if (options.replay.recording == nullptr) return false;
  const std::vector<RecordedEvent>& events = options.replay.recording->events();
  return std::any_of(events.begin(), events.end(), [](const RecordedEvent& e) {
    return e.what == "checkpoint" || e.what == "undo" || e.what == "retract";
  });
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
  params.load = {options.burn_us, options.seconds / 3, 2 * options.seconds / 3};
  return params;
}

void CheckOptions(const Scene& scene, const LoopOptions& options) {
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error("[simulation] mode = \"slab\" can't be coupled to a handle; set mode = \"voxel\" for 'kerf loop'");
  }
  CheckParameters(options, "loop");
  if (options.driver.device.is_set() && options.driver.device.in_real_time && options.virtual_time) {
    throw Error("a real device needs real time: it can't be used in a run in virtual time");
  }
  const double ticks = options.seconds * scene.loop.rate_hz;
  if (options.output.log == LoopLog::kMemory && ticks > kMaxTicksInMemory) {
    throw Error(fmt::format("{:.0f} ticks are too many to keep in memory (the maximum is {:.0f}); specify a folder",
                            ticks, kMaxTicksInMemory));
  }
}

}  // namespace

// The members are in the order in which they are made; a later one may refer to an earlier one.
struct LoopSession::State {
  enum class Phase : std::uint8_t { kReplay, kBegin, kVirtual, kLive, kEnd };

  State(const Scene& scene_in, const LoopOptions& options_in, const Progress& progress_in)
      : scene(scene_in), options(options_in), progress(progress_in) {}

  // ---- making the session
  void MakeBone();
  void MakeRecording();
  void MakeLogs();
  void MakeBody();
  void MakeLoop();
  void MakePieces(Bone bone);
  void MakeReaders();

  // ---- steps
  bool StepReplay();
  bool ReplayTick();
  void BeforeReplayedTick(const RecordedStep& step);
  void EndReplay();
  bool Begin();
  bool StepVirtual();
  void AfterVirtualTick();
  bool StepLive();

  // ---- reading the loop
  void Read(double fraction);
  /// Searches for pieces after fixed numbers of ticks, so that the result is reproducible. Returns false if no search
  /// is due after `ticks` ticks.
  bool Search(std::int64_t ticks, double time_s);
  void SendRest();
  StageCosts MakeCosts();

  // ---- summing up
  void EndRecording();
  void SummarizeUndo();
  void SummarizeCut();

  bool replays() const { return options.replay.recording != nullptr; }
  bool records() const { return !options.output.record.empty(); }
  bool stopped() const {
    return (options.stop != nullptr && options.stop->load()) || (recording && !recording->failure().empty());
  }
  double CalcElapsed_s() const { return std::chrono::duration<double>(WallClock::now() - began).count(); }
  void Show(const char* stage, double fraction) const {
    if (progress) progress(stage, fraction);
  }

  const Scene& scene;
  const LoopOptions& options;
  const Progress progress;
  const double period_s = 1 / scene.loop.rate_hz;
  const double requested_ticks = options.seconds * scene.loop.rate_hz;
  LoopSummary s;
  const Path path = MakePath(scene);
  const Pose X_WT_start = path.CalcPose(0, 0);
  CoupledParams params = MakeCoupledParams(scene);
  std::optional<RecordingHeader> header;  // if the session is recorded
  std::optional<SessionRecorder> recording;
  std::optional<CoupledSimulation> simulation;

  std::optional<LoopHandle> handle;
  std::optional<StepBody> step_body;
  std::optional<ChangedHash> voxel_hash;

  MonotonicClock monotonic;
  VirtualClock virtual_clock;
  std::optional<ReplayBody> replay;
  std::optional<HapticLoop> loop;
  std::optional<LoopMover> mover;
  std::optional<LoopUndo> undo;
  std::optional<BoneMirror> mirror;
  std::optional<FragmentsDriver> fragments;
  PieceExchange exchange;
  std::optional<LivePieces> pieces;
  std::optional<LoopRecorder> recorder;
  std::optional<LoopActions> actions;

  Phase phase = Phase::kBegin;
  WallClock::time_point began;
  double line_at_s = 0;                     // when the next line of costs is due
  std::int64_t ticks_between_searches = 0;  // for pieces; 0: none
  double search_at_s = 0;                   // live: when the next search is due
  std::int64_t replayed_ticks = 0;
  double replayed_s = 0;
  std::size_t copied = 0;       // events copied from the recording that is continued
  std::int64_t done_ticks = 0;  // in virtual time
  double completed = 0;         // fraction of the stage
  WallClock::time_point tick_began;
};

LoopSession::LoopSession(const Scene& scene, const LoopOptions& options, const Progress& progress) {
  CheckOptions(scene, options);
  state_ = std::make_unique<State>(scene, options, progress);
  state_->MakeBone();
  state_->MakeReaders();
}

LoopSession::~LoopSession() = default;

bool LoopSession::Step() {
  switch (state_->phase) {
    case State::Phase::kReplay:
      return state_->StepReplay();
    case State::Phase::kBegin:
      return state_->Begin();
    case State::Phase::kVirtual:
      return state_->StepVirtual();
    case State::Phase::kLive:
      return state_->StepLive();
    case State::Phase::kEnd:
      break;
  }
  return false;
}

void LoopSession::State::MakeBone() {
  s.seconds = options.seconds;
  s.rate_hz = scene.loop.rate_hz;
  s.virtual_time = options.virtual_time;
  s.setup = MakeLoopSetup(scene);
  s.device = s.setup.profile.name;
  s.hand = options.driver.device.is_set() ? "" : s.setup.hand.name;
  s.force.slew_bound_N = scene.device.slew_N_per_s * period_s;
  s.force.scale = s.setup.force_scale;
  params.coupling = s.setup.fitted.coupling;

  Bone bone = MakeSceneBone(
      scene, [&](double f) { Show("making the bone", f); }, &s.material, options.read_bone);
  // `kerf loop` measures; a window's user waits.
  if (options.watchers.peer == nullptr && !options.virtual_time) FinishKeepingBones();
  Show("preparing the session", 0);
  ShareLeaves(bone);
  params.spare_leaves = std::min(CountSpareLeaves(bone), options.spare_leaves);
  s.warnings = FindToolWarnings(scene, bone.voxel_mm());
  for (const std::string& warning : FindHandWarnings(scene, s.setup)) s.warnings.push_back(warning);
  s.warnings.insert(s.warnings.end(), s.material.warnings.begin(), s.material.warnings.end());
  s.starts_in_bone = IsInBone(bone, params.tool, X_WT_start);
  if (replays()) CheckReplays(*options.replay.recording, bone);
  if (records()) {
    header = MakeRecordingHeader(scene, options.output.scene_file, RecordedKind::kLoop, bone, X_WT_start);
    if (replays()) header->taken_up_from = options.replay.recording->path();
  }
  if (options.output.keep_bones) s.before = CopySharing(bone);
  Show("preparing the session", 0.3);
  if (!options.output.keep_last) s.volume_before_mm3 = bone.CalcVolume();
  Bone copy = CopySharing(bone);
  Show("preparing the session", 0.5);
  simulation.emplace(std::move(bone), params, X_WT_start);
  Show("preparing the session", 0.9);
  MakeRecording();
  MakeLogs();
  MakeBody();
  MakeLoop();
  MakePieces(std::move(copy));
}

void LoopSession::State::MakeRecording() {
  if (!header) return;
  recording.emplace(options.output.record, *header, ReadSceneFiles(scene, options.output.scene_file));
}

void LoopSession::State::MakeLogs() {
  s.effects = EffectRecord(EffectsOf(*simulation));
  const std::string folder = options.output.log == LoopLog::kFolder ? options.output.folder : "";
  if (options.output.log != LoopLog::kNone) {
    s.effect_files = EffectFiles(EffectsOf(*simulation), static_cast<std::size_t>(requested_ticks) + 64, false, folder);
  }
  if (folder.empty()) return;
  s.force_log = std::make_unique<ForceLog>(folder + "/forces.csv", s.effects.Header(),
                                           recording ? CalcRoomForRecording(requested_ticks) : 0);
}

void LoopSession::State::MakeBody() {
  const CouplingParams& coupling = params.coupling;
  handle.emplace(scene, options.driver, s.setup, path, coupling.p_TC_mm,
                 coupling.stiffness_N_per_mm * s.setup.force_scale);
  StepBodyParams body_params;
  body_params.rpm = scene.tool.CalcTickRpm();
  body_params.period_s = period_s;
  body_params.force_map = s.setup.force_map;
  // A real device may be plugged in again.
  if (handle->is_real() && options.driver.device.in_real_time) body_params.give_up_s = kMaxLoop_s;
  step_body.emplace(*simulation, handle->device(), body_params, handle->hand());
  if (recording || replays()) step_body->set_hash(&voxel_hash.emplace());
}

void LoopSession::State::MakeLoop() {
  if (replays()) {
    replay.emplace(*step_body, *simulation, handle->recorded(), *options.replay.recording, options.replay.until_s,
                   [this](const RecordedStep& step) { BeforeReplayedTick(step); });
    phase = Phase::kReplay;
  }
  LoopClock& clock = options.virtual_time ? static_cast<LoopClock&>(virtual_clock) : monotonic;
  loop.emplace(replay ? static_cast<LoopBody&>(*replay) : *step_body, handle->device(), clock,
               MakeLoopParams(scene.loop, options));
  if (options.costs.costs) loop->Watch(EffectsOf(*simulation));
  if (!NeedsUndo(options)) return;
  mover.emplace(params.tool, X_WT_start, period_s, step_body->can_place());
  for (const EffectPlan::Entry& entry : EffectsOf(*simulation).entries()) {
    const auto* guide = dynamic_cast<const GuideEffect*>(entry.effect.get());
    if (guide == nullptr) continue;
    const GuideParams& plane = guide->params();
    mover->set_guide({plane.point_W_mm, glm::normalize(plane.normal_W), plane.tolerance_mm});
  }
  step_body->set_restores(&undo.emplace(*simulation, options.undo.max_MB, &*mover).exchange());
  s.undo.emplace();
}

void LoopSession::State::MakePieces(Bone bone) {
  SessionController* const peer = options.watchers.peer;
  mirror.emplace(std::move(bone), loop->leaves());
  if (mover) mover->Connect(*loop, *mirror);
  fragments.emplace(EffectsOf(*simulation));
  pieces.emplace(*fragments, *loop, exchange, *mirror, CalcReach(params.tool));
  if (fragments->is_on() || peer != nullptr) {
    mirror->set_listener([this, peer](const LeafMessage& leaf) {
      if (peer != nullptr) peer->TakeLeaf(leaf);
      if (!fragments->is_on()) return;
      std::array<float, 512> phi;
      GetLeaf(mirror->bone(), leaf.index, phi);
      fragments->Change(leaf.index, phi);
      pieces->Take(leaf);
    });
  }
  if (peer != nullptr) peer->Begin({mirror->bone(), params, s.setup, EffectsOf(*simulation), X_WT_start});
  if (fragments->takes_out()) step_body->set_pieces(&exchange);
  if (recording) {
    pieces->set_listener(
        [this](std::uint32_t number, const std::string& bytes) { recording->AddPiece(number, bytes); });
  }
  if (!fragments->is_on()) return;
  ticks_between_searches = std::max<std::int64_t>(1, std::llround(fragments->every_s() * scene.loop.rate_hz));
}

void LoopSession::State::MakeReaders() {
  recorder.emplace(params.coupling.p_TC_mm, scene.output.forces_every_ticks, requested_ticks, options.output.log,
                   period_s, s);
  recorder->set_recording(recording ? &*recording : nullptr);
  recorder->set_take_tick(mover ? [this](const LoopTick& tick, std::span<const double> channels) {
    mover->Take(tick);
    if (options.watchers.take_tick) options.watchers.take_tick(tick, channels);
  } : options.watchers.take_tick);
  const auto record_request = [this](const std::string& what, const std::string& name, std::uint32_t number) {
    recorder->Drain(*loop);
    if (recording) recording->AddEvent(what, name, number);
  };
  actions.emplace(options.undo.actions, scene.tool, *step_body, undo ? &*undo : nullptr, options.watchers.peer,
                  record_request);
  began = WallClock::now();
}

void LoopSession::State::Read(double fraction) {
  completed = fraction;
  recorder->Drain(*loop);
  if (recording) recording->FlushAt(CalcElapsed_s());
  s.leaves_sent += mirror->Update();
  Show(phase == Phase::kReplay && options.replay.continues ? "repeating the recording" : "cutting", fraction);
  if (options.costs.live && options.costs.costs && CalcElapsed_s() > line_at_s) {
    options.costs.live(FormatCostLine(MakeCosts()));
    line_at_s = CalcElapsed_s() + kBetweenLines_s;
  }
}

bool LoopSession::State::Search(std::int64_t ticks, double time_s) {
  if (ticks % ticks_between_searches != 0) return false;
  loop->state().Update();
  s.leaves_sent += mirror->Update();
  pieces->Poll();
  if (!pieces->is_leaving()) fragments->Search(time_s);
  return true;
}

void LoopSession::State::SendRest() {
  while (loop->SendRemaining()) s.leaves_sent += mirror->Update();
  Read(stopped() ? completed : 1);
}

StageCosts LoopSession::State::MakeCosts() {
  return MakeStageCosts(loop->tick_times(), loop->stages(), EffectsOf(*simulation), 1e6 * period_s);
}

bool LoopSession::State::StepReplay() {
  if (ReplayTick()) return true;
  EndReplay();
  if (options.replay.continues) {
    phase = Phase::kBegin;
    return true;
  }
  loop->RunHere(0);
  phase = Phase::kEnd;
  return false;
}

/// Runs the next recorded tick. Returns false if there is none, or if the session is stopped.
bool LoopSession::State::ReplayTick() {
  const LoopReplayOptions& o = options.replay;
  const auto ticks = static_cast<std::int64_t>(loop->counts().ticks);
  const double total_s = std::min(o.until_s, o.recording->damage().whole_s);
  const double time_s = replay->steps().time_s();
  if (ticks % 64 == 0) Read(total_s > 0 ? time_s / total_s : 1);
  if (undo) undo->Poll();
  if (fragments->is_on() && ticks > replayed_ticks) Search(ticks, time_s);
  replayed_ticks = ticks;
  if (stopped()) return false;
  if (o.speed > 0) {
    const std::chrono::duration<double> at_s(time_s / o.speed);
    std::this_thread::sleep_until(began + std::chrono::duration_cast<WallClock::duration>(at_s));
  }
  if (!replay->Prepare() || (o.verify && replay->steps().divergence())) return false;
  SupplyLeaves(*simulation);
  return loop->StepWithoutClock();
}

/// Repeats what was done between two ticks.
void LoopSession::State::BeforeReplayedTick(const RecordedStep& step) {
  // The calls below may settle the field, which invalidates pointers to leaves, so all waiting leaves are sent first.
  while (loop->SendRemaining()) Read(0);
  if ((step.flags & kRecordedTakenUp) != 0) simulation->UpdateBone();
  const std::vector<RecordedEvent>& events = options.replay.recording->events();
  if (recording) {
    Read(0);
    for (; copied < events.size() && events[copied].step <= replay->steps().step(); ++copied) {
      recording->AddEvent(events[copied].what, events[copied].name, events[copied].number);
    }
  }
  if (undo) undo->Repeat(step, events);
  if ((step.flags & kRecordedPieceLeaves) == 0) return;
  pieces->Repeat(step.piece, options.replay.recording->ReadPiece(step.piece), s.simulated_s);
}

void LoopSession::State::EndReplay() {
  Read(1);
  replay->HandOver();
  while (loop->SendRemaining()) Read(1);
  replayed_s = replay->steps().time_s();
  actions->SkipTo(replayed_s, s.warnings);
  loop->state().Update();
  handle->EndReplay(loop->state().front().last);
  if (options.replay.continues) handle->TakeOver(loop->state().front().last);
  s.replayed = replay->steps().MakeReport(simulation->UpdateBone().CalcHash());
  if (recording) recording->AddEvent("taken up", options.replay.recording->path(), 0);
}

/// Connects the device and starts the loop.
bool LoopSession::State::Begin() {
  if (handle->is_real()) Show("waiting for the device", 0);
  handle->Connect(recorder->X_WT().value_or(X_WT_start), params.coupling, s.setup.force_scale);
  actions->Act(replayed_s, s.warnings);  // before the first tick, so that a peer can begin with the spindle off
  if (options.virtual_time) {
    phase = Phase::kVirtual;
    tick_began = WallClock::now();
    loop->BeginHere();
  } else {
    phase = Phase::kLive;
    loop->Start();
    began = WallClock::now() - loop->CalcElapsed();  // not counting the time for locking the memory
  }
  return true;
}

bool LoopSession::State::StepVirtual() {
  SupplyLeaves(*simulation);
  // The injected delay (burn_us) makes the loop miss ticks, so the end is given as a time, not only as a number of
  // ticks.
  if (done_ticks < std::llround(requested_ticks) && loop->StepHere()) {
    AfterVirtualTick();
    if (virtual_clock.Now() < std::llround(1e9 * options.seconds) && !stopped()) return true;
  }
  loop->EndHere();
  phase = Phase::kEnd;
  return false;
}

void LoopSession::State::AfterVirtualTick() {
  ++done_ticks;
  const double time_s = replayed_s + static_cast<double>(done_ticks) * period_s;
  actions->Act(time_s, s.warnings);
  if (options.watchers.watch_tick) {
    const double wall_us = std::chrono::duration<double, std::micro>(WallClock::now() - tick_began).count();
    loop->state().Update();
    options.watchers.watch_tick(wall_us, loop->state().front().last, *simulation);
  }
  if (done_ticks % 64 == 0) Read(static_cast<double>(done_ticks) / std::round(requested_ticks));
  if (fragments->is_on() && Search(replayed_ticks + done_ticks, time_s) && !pieces->is_leaving()) pieces->Prepare();
  tick_began = WallClock::now();
}

bool LoopSession::State::StepLive() {
  if (!loop->running() || stopped() || CalcElapsed_s() >= options.seconds) {
    loop->Stop();
    phase = Phase::kEnd;
    return false;
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  SupplyLeaves(*simulation);
  if (fragments->is_on()) loop->state().Update();  // everything sent up to now is read below
  Read(CalcElapsed_s() / options.seconds);
  actions->Act(replayed_s + CalcElapsed_s(), s.warnings);
  pieces->Poll();
  if (!fragments->is_on() || CalcElapsed_s() < search_at_s || pieces->is_leaving()) return true;
  search_at_s = CalcElapsed_s() + fragments->every_s();
  fragments->Search(loop->state().front().sent_until_s, [this] { return replayed_s + CalcElapsed_s(); });
  pieces->Prepare();
  return true;
}

void LoopSession::State::EndRecording() {
  const std::string why = stopped() ? "stopped" : loop->failure().empty() ? "asked" : loop->failure();
  recording->Finish(why, simulation->UpdateBone().CalcHash());
  s.recorded = {options.output.record, recording->bytes(), recording->steps(), recording->failure()};
}

void LoopSession::State::SummarizeUndo() {
  undo->Poll();
  if (!undo->is_idle()) s.warnings.emplace_back("the loop ended while an action was in progress");
  s.undo->restores = undo->restores();
  s.undo->longest_ms = actions->longest_ms();
  s.undo->checkpoints = undo->journal().checkpoints().size();
  s.undo->kept_MB = 1e-6 * static_cast<double>(undo->journal().CalcMemoryBytes());
}

void LoopSession::State::SummarizeCut() {
  for (const double mm3 : simulation->CalcRemovedByRegion()) s.removed_mm3 += mm3;
  s.bone_hash = simulation->UpdateBone().CalcHash();
  if (!options.output.keep_last) s.mirror_identical = mirror->bone().CalcHash() == s.bone_hash;
  AddLoopWarnings(s, params.spare_leaves);
  if (!s.replayed && !(s.undo && s.undo->restores > 0)) {
    s.cutting_sums.simulated_s = s.simulated_s;
    s.cutting_sums.removed_mm3 = s.removed_mm3;
    s.cutting = CalcCuttingEnergy(scene, s.effects, s.cutting_sums);
    for (const std::string& warning : FindEnergyWarnings(scene, *s.cutting)) s.warnings.push_back(warning);
  }
  s.heat = MakeHeatReport(EffectsOf(*simulation), s.moments.empty() ? X_WT_start : s.moments.back().X_WT);
  s.fragments = fragments->MakeReport(mirror->bone().materials());
  if (options.output.keep_last) {
    s.after = std::move(*simulation).TakeBone();
    return;
  }
  Show("separating the pieces", 0);
  SummarizeBone(std::move(*simulation).TakeBone(), scene, options.output.keep_bones, s);
}

LoopSummary LoopSession::Finish() {
  State& state = *state_;
  LoopSummary& s = state.s;
  s.wall_s = state.CalcElapsed_s();
  state.SendRest();  // the tool is at rest
  state.handle->Summarize(s);
  if (state.recording) state.EndRecording();
  state.pieces->Finish(*state.simulation, s.simulated_s, [&] { state.SendRest(); });
  if (state.actions->left() > 0) {
    s.warnings.push_back(fmt::format("the loop ended before {} of the requested actions, the first at {:g} s",
                                     state.actions->left(), state.actions->next_s()));
  }
  if (state.undo) state.SummarizeUndo();
  if (state.mover) s.leaves_sent += state.mover->leaves_received();
  SummarizeLoop(*state.loop, s);
  if (state.options.costs.costs) s.costs = state.MakeCosts();
  state.recorder->Finish();
  state.SummarizeCut();
  return std::move(s);
}

LoopSummary LoopSession::Abandon(const std::string& failure) {
  State& state = *state_;
  if (state.phase == State::Phase::kLive) state.loop->Stop();
  if (state.phase == State::Phase::kVirtual) state.loop->EndHere();
  state.phase = State::Phase::kEnd;
  LoopSummary& s = state.s;
  s.failure = failure;
  s.wall_s = state.CalcElapsed_s();
  s.counts = state.loop->counts();
  if (state.recording) {
    state.recording->Finish(failure, state.simulation->UpdateBone().CalcHash());
    s.recorded = {state.options.output.record, state.recording->bytes(), state.recording->steps(),
                  state.recording->failure()};
  }
  s.after = std::move(*state.simulation).TakeBone();
  return std::move(s);
}

LoopSummary RunLoop(const Scene& scene, const LoopOptions& options, const LoopSession::Progress& progress) {
  LoopSession session(scene, options, progress);
  try {
    while (session.Step()) {
    }
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    if (!options.output.keep_on_failure) throw;
    return session.Abandon(e.what());
  }
  return session.Finish();
}

}  // namespace kerf
