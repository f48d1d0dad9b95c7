#include "session/run_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <thread>

#include "bone/surface.h"
#include "core/hash.h"
#include "core/high_pass.h"
#include "devices/simulated_device.h"
#include "haptics/bone_mirror.h"
#include "haptics/step_body.h"
#include "kerf/error.h"
#include "scene/doubts.h"
#include "session/hand_motion.h"
#include "session/live_pieces.h"
#include "session/make_bone.h"

namespace kerf {
namespace {

constexpr double kNoiseFrom_Hz = 20;

/// Whether bone is within the tool as it is set down: looked for at points of its middle plane.
bool IsInBone(const Bone& bone, const Tool& tool, const Pose& X_WT) {
  const double reach_mm = CalcReach(tool);
  const double step_mm = std::max(bone.voxel_mm(), reach_mm / 50);
  for (double x = -reach_mm; x <= reach_mm; x += step_mm) {
    for (double y = -reach_mm; y <= reach_mm; y += step_mm) {
      // Half a voxel deep: to touch is not to be inside.
      if (x * x + y * y < reach_mm * reach_mm && bone.SignedDistance(X_WT.Point({x, y, 0})) < -0.5 * bone.voxel_mm()) {
        return true;
      }
    }
  }
  return false;
}

LoopTimeSummary Summarize(const std::string& name, const LogHistogram& times) {
  return {name,
          times.total(),
          times.CalcPercentile_us(0.5),
          times.CalcPercentile_us(0.99),
          times.CalcPercentile_us(0.999),
          times.max_us(),
          times.CalcMean_us()};
}

/// Eight bars to an octave, from the first to the last that is not empty.
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

/// Takes the loop's log as it comes.
class Recorder {
 public:
  Recorder(const Vec3& p_TC_mm, int every, double ticks, LoopSummary& summary)
      : p_TC_mm_(p_TC_mm), every_(static_cast<std::uint64_t>(std::max(every, 1))), summary_(summary) {
    // In one go: in locked memory each page costs.
    const auto n = static_cast<std::size_t>(ticks) + 64;
    summary_.rows.reserve(n / every_ + 1);
    summary_.effects.rows.reserve((n / every_ + 1) * summary_.effects.figures.size());
    for (auto& axis : force_) axis.reserve(n);
    cutting_.reserve(n);
  }

  void Drain(HapticLoop& loop) {
    SpscRing<LoopSample>& samples = loop.samples();
    while (const LoopSample* sample = samples.Peek()) {
      Take(*sample, loop.channels(popped_));
      samples.Pop();
      ++popped_;
    }
  }

  void Finish(double dt_s) {
    summary_.force_hash = hash_;
    LoopForceSummary& force = summary_.force;
    double sum = 0;
    for (const auto& axis : force_) sum += std::pow(CalcRms(axis, 0, axis.size(), dt_s), 2);
    force.noise_above_20_Hz_mN = 1000 * std::sqrt(sum);
    const auto window = static_cast<std::size_t>(std::lround(1 / dt_s));
    for (std::size_t begin = 0; begin + window <= cutting_.size(); begin += window) {
      const auto first = cutting_.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = first + static_cast<std::ptrdiff_t>(window);
      if (std::find(first, last, false) != last) continue;
      double square = 0;
      for (const auto& axis : force_) square += std::pow(CalcRms(axis, begin, window, dt_s), 2);
      force.cutting_noise_mN = std::max(force.cutting_noise_mN.value_or(0), 1000 * std::sqrt(square));
    }
    FinishMoments();
  }

 private:
  static double CalcRms(const std::vector<double>& x, std::size_t begin, std::size_t count, double dt_s) {
    return CalcHighPassRms(std::span(x).subspan(begin, count), dt_s, kNoiseFrom_Hz);
  }
  void Mix(double value) { hash_ = MixHash(hash_ ^ std::bit_cast<std::uint64_t>(value)); }

  void Take(const LoopSample& s, std::span<const double> channels) {
    const CoupledOutput& out = s.report.out;
    // The device held its force over what was missed.
    for (int k = 0; k < s.skipped && k < 10'000; ++k) Hold();
    for (int axis = 0; axis < 3; ++axis) force_[static_cast<std::size_t>(axis)].push_back(s.report.f_device_N[axis]);
    cutting_.push_back(out.engaged_teeth > 0);
    for (int axis = 0; axis < 3; ++axis) {
      Mix(s.report.f_device_N[axis]);
      Mix(out.f_H_W_N[axis]);
      Mix(out.X_WT.p_AB[axis]);
    }
    summary_.effect_files.Take(s.time_s, s.time_s - summary_.simulated_s, out.X_WT, channels);
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
    NoteMoments(s);
    removed_mm3_ += out.removed_mm3;
    if (++ticks_ % every_ != 0) {
      summary_.effects.Take(channels);
      return;
    }
    summary_.effects.TakeRow(channels);
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
    summary_.rows.push_back(row);
    removed_mm3_ = 0;
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
      // What came before is there for its place alone.
      summary_.moments[summary_.moments.size() - 2].out.engaged_teeth = 0;
    }
  }
  void Hold() {
    for (auto& axis : force_) axis.push_back(axis.empty() ? 0 : axis.back());
    cutting_.push_back(!cutting_.empty() && cutting_.back());
  }

  Vec3 p_TC_mm_;
  std::uint64_t every_;
  LoopSummary& summary_;
  std::array<std::vector<double>, 3> force_;  // on the device, every deadline
  std::vector<bool> cutting_;
  std::uint64_t ticks_ = 0;
  std::uint64_t popped_ = 0;
  std::uint64_t hash_ = 0;
  bool any_ = false;
  bool engaged_ = false;
  double peak_N_ = 0;
  std::array<TickRecord, 2> before_, first_, peak_, last_;  // a tick and the one before it
  double removed_mm3_ = 0;
};

/// All times and counts of a loop that is over.
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

/// The bone after it all, and what it fell into.
void TakeApart(Bone bone, const Scene& scene, const LoopOptions& options,
               const std::function<void(const char*, double)>& show, LoopSummary& s) {
  show("taking the pieces apart", 0);
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
    throw Error("[simulation] mode = \"slab\" has no tool in a hand; set mode = \"voxel\" for 'kerf loop'");
  }
  if (!(options.seconds >= 0.01 && options.seconds <= 3600)) {
    throw Error(fmt::format("the loop can't run for {:g} s; give 0.01 to 3600", options.seconds));
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
  s.hand = hand.name;

  StepBodyParams body_params;
  body_params.rpm = scene.tool.rpm;
  body_params.period_s = period_s;
  body_params.force_map = s.setup.force_map;
  s.force.slew_bound_N = scene.device.slew_N_per_s * period_s;
  s.force.scale = s.setup.force_scale;

  CoupledParams params = MakeCoupledParams(scene);
  params.coupling = s.setup.fitted.coupling;

  const Path path = MakePath(scene);
  Bone bone = MakeSceneBone(
      scene, [&](double f) { show("making the bone", f); }, &s.material);
  params.spare_leaves = CountSpareLeaves(bone);
  s.warnings = FindToolDoubts(scene, bone.voxel_mm());
  for (const std::string& doubt : FindHandDoubts(scene, s.setup)) s.warnings.push_back(doubt);
  s.warnings.insert(s.warnings.end(), s.material.warnings.begin(), s.material.warnings.end());
  s.starts_in_bone = IsInBone(bone, params.tool, path.CalcPose(0, 0));
  if (options.keep_bones) s.before = bone;
  s.volume_before_mm3 = bone.CalcVolume();
  Bone copy = bone;
  const Vec3 p_TC_mm = params.coupling.p_TC_mm;
  const Pose X_WT_start = path.CalcPose(0, 0);
  CoupledSimulation simulation(std::move(bone), params, X_WT_start);
  s.effects = EffectRecord(simulation.effects());
  s.effect_files =
      EffectFiles(simulation.effects(), static_cast<std::size_t>(options.seconds * scene.loop.rate_hz) + 64, false);
  SimulatedDeviceOptions device_options;
  device_options.p_TC_mm = p_TC_mm;
  SimulatedDevice simulated(profile, hand, X_WT_start, device_options);
  HandMotion motion(simulated, path, scene.hand, p_TC_mm, params.coupling.stiffness_N_per_mm * s.setup.force_scale);
  GuardedDevice device(simulated);
  StepBody body(simulation, device, body_params, &motion);

  MonotonicClock monotonic;
  VirtualClock stands_still;
  LoopClock& clock = options.virtual_time ? static_cast<LoopClock&>(stands_still) : monotonic;
  HapticLoop loop(body, device, clock, MakeLoopParams(scene.loop, options));
  if (options.costs.costs) loop.Watch(simulation.effects());
  const auto make_costs = [&] {
    return MakeStageCosts(loop.tick_times(), loop.stages(), simulation.effects(), 1e6 * period_s);
  };
  BoneMirror mirror(std::move(copy), loop.leaves());
  FragmentsDriver fragments(simulation.effects());
  PieceExchange exchange;
  LivePieces pieces(fragments, loop, exchange, mirror, CalcReach(params.tool));
  if (fragments.is_on()) {
    mirror.set_listener([&](const LeafMessage& leaf) {
      fragments.Change(leaf.index, leaf.values);
      pieces.Take(leaf);
    });
  }
  if (fragments.takes_out()) body.set_pieces(&exchange);
  Recorder recorder(p_TC_mm, scene.output.forces_every_ticks, options.seconds * scene.loop.rate_hz, s);
  const auto stopped = [&] { return options.stop != nullptr && options.stop->load(); };
  auto began = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  double line_at_s = 0;
  const auto read = [&](double share) {
    recorder.Drain(loop);
    s.leaves_sent += mirror.Update();
    show("cutting", share);
    if (options.costs.live && options.costs.costs && elapsed_s() > line_at_s) {
      options.costs.live(FormatCostLine(make_costs()));
      line_at_s = elapsed_s() + 0.25;
    }
  };

  if (options.virtual_time) {
    const auto ticks = static_cast<std::int64_t>(std::llround(options.seconds * scene.loop.rate_hz));
    const std::int64_t between_looks =
        fragments.is_on() ? std::max<std::int64_t>(1, std::llround(fragments.every_s() * scene.loop.rate_hz)) : 0;
    std::int64_t done = 0;
    // Burnt time passes by ticks that are missed: the end is a moment, not a number of ticks.
    const std::int64_t end_ns = std::llround(1e9 * options.seconds);
    loop.RunHere(ticks, [&] {
      if (++done % 64 == 0) read(static_cast<double>(done) / static_cast<double>(ticks));
      if (fragments.is_on() && done % between_looks == 0) {
        loop.state().Update();
        s.leaves_sent += mirror.Update();
        pieces.Poll();
        if (!pieces.is_leaving()) fragments.Look(static_cast<double>(done) * period_s);
        if (!pieces.is_leaving()) pieces.Prepare();
      }
      return stands_still.Now() < end_ns && !stopped();
    });
  } else {
    loop.Start();
    double look_at_s = 0;
    began = std::chrono::steady_clock::now();  // locking the memory takes a while
    while (loop.running() && !stopped() && elapsed_s() < options.seconds) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (fragments.is_on()) loop.state().Update();  // what had been sent by then is read now
      read(elapsed_s() / options.seconds);
      pieces.Poll();
      if (!fragments.is_on() || elapsed_s() < look_at_s || pieces.is_leaving()) continue;
      look_at_s = elapsed_s() + fragments.every_s();
      fragments.Look(loop.state().front().sent_until_s, elapsed_s);
      pieces.Prepare();
    }
    loop.Stop();
  }
  s.wall_s = elapsed_s();
  // The tool rests: what still waits goes out.
  const auto send_rest = [&] {
    while (loop.SendRest()) s.leaves_sent += mirror.Update();
    read(1);
  };
  send_rest();
  pieces.Finish(simulation, s.simulated_s, send_rest);

  SummarizeLoop(loop, device, s);
  if (options.costs.costs) s.costs = make_costs();
  recorder.Finish(period_s);
  s.rounds = motion.rounds();
  s.strokes = motion.strokes();
  for (const double mm3 : simulation.CalcRemovedByRegion()) s.removed_mm3 += mm3;
  s.bone_hash = simulation.bone().CalcHash();
  s.mirror_identical = mirror.bone().CalcHash() == s.bone_hash;
  if (!s.touched) s.warnings.emplace_back("the tool met no bone");
  if (s.starts_in_bone) {
    s.warnings.emplace_back("the tool was set down inside the bone; what its edge held there went at once");
  }
  s.heat = MakeHeatReport(simulation.effects(), s.moments.empty() ? X_WT_start : s.moments.back().X_WT);
  s.fragments = fragments.MakeReport(mirror.bone().materials());
  TakeApart(std::move(simulation).TakeBone(), scene, options, show, s);
  return s;
}

}  // namespace kerf
