#include "loop/haptics/haptic_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>

#include "base/core/heap_guard.h"
#include "base/core/vectors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

LoopParams Checked(LoopParams params) {
  CheckParameters(params, "loop");
  params.governor.period_s = 1 / params.rate_hz;
  return params;
}

std::int64_t Nanoseconds(double seconds) {
  return std::llround(1e9 * seconds);
}

float Microseconds(std::int64_t ns) {
  return static_cast<float>(1e-3 * static_cast<double>(ns));
}

/// Returns the fraction of `burn_us` that is wasted at this fidelity.
double BurnFraction(Fidelity fidelity) {
  return fidelity == Fidelity::kFull ? 1 : fidelity == Fidelity::kCoarse ? 0.5 : 0.1;
}

constexpr int kCatchUpLeaves = 64;  // number of leaves sent per tick while restored bone waits in the queue

/// Status bits that can also be set if the tick did everything as requested.
constexpr std::uint32_t kHarmless = kCoupledAsleep | kCoupledSpindleStopped | kCoupledBlending | kCoupledTouchesMetal;

}  // namespace

const char* ToString(TickStage stage) {
  switch (stage) {
    case TickStage::kAccept:
      return "accept";
    case TickStage::kNear:
      return "near";
    case TickStage::kEngage:
      return "engage";
    case TickStage::kSolve:
      return "solve";
    case TickStage::kRemove:
      return "remove";
    case TickStage::kEffects:
      return "effects";
    case TickStage::kPublish:
      return "publish";
    case TickStage::kEnd:
      break;
  }
  return "end";
}

HapticLoop::HapticLoop(LoopBody& body, GuardedDevice& device, LoopClock& clock, const LoopParams& params)
    : body_(body),
      device_(device),
      clock_(clock),
      params_(Checked(params)),
      period_ns_(Nanoseconds(1 / params.rate_hz)),
      deadlines_(period_ns_),
      governor_(params_.governor),
      stages_(clock),
      leaves_(static_cast<std::size_t>(params.leaf_ring)),
      samples_(static_cast<std::size_t>(params.sample_ring)),
      channel_count_(body.channel_count()),
      channels_((samples_.capacity() + 1) * channel_count_),
      publisher_(leaves_, static_cast<std::size_t>(params.max_leaves_waiting)) {}

HapticLoop::~HapticLoop() {
  Stop();
}

void HapticLoop::Start() {
  if (thread_.joinable() || !running()) return;
  if (params_.lock_memory) {
    LockMemory(grants_);
  } else {
    grants_.memory = "Locking memory in RAM was not requested.";
  }
  beat_ns_.store(clock_.Now());
  thread_ = std::thread([this] { RunThread(); });
  started_.wait(false);
  watchdog_ = std::make_unique<WatchdogThread>(device_, clock_, beat_ns_, Nanoseconds(1e-3 * params_.watchdog_ms),
                                               grants_.fifo ? grants_.priority + 1 : 0);
}

void HapticLoop::Stop() {
  stop_.store(true);
  if (!thread_.joinable()) return;
  thread_.join();
  watchdog_trips_ = watchdog_ ? watchdog_->trips() : 0;
  watchdog_.reset();
  if (grants_.locked) UnlockMemory();
}

void HapticLoop::RunThread() {
  RequestPriority(params_.priority, grants_);
  TouchStack();
  start_ns_ = clock_.Now();
  deadlines_.Start(start_ns_);
  beat_ns_.store(start_ns_);
  started_.store(true);
  started_.notify_all();
  while (running() && !stop_.load(std::memory_order_relaxed)) TickOnce();
  if (running()) Finish(LoopEnd::kRequested);
}

void HapticLoop::BeginHere() {
  grants_.scheduling = "The loop ran without a thread and without waiting.";
  grants_.memory = "Locking memory in RAM was not requested.";
  start_ns_ = clock_.Now();
  deadlines_.Start(start_ns_);
  beat_ns_.store(start_ns_);
}

bool HapticLoop::StepHere() {
  if (!running() || stop_.load()) return false;
  TickOnce();
  return true;
}

void HapticLoop::EndHere() {
  if (running()) Finish(LoopEnd::kRequested);
}

void HapticLoop::RunHere(std::int64_t ticks, const std::function<bool()>& between) {
  BeginHere();
  for (std::int64_t i = 0; i < ticks && StepHere(); ++i) {
    if (between && !between()) break;
  }
  EndHere();
}

bool HapticLoop::StepWithoutClock() {
  const Deadlines::Tick on_time{};
  const HeapGuard guard;
  // During DoTick(), tick_ has the time before the tick, because the tick's duration is not known yet.
  if (!DoTick(on_time)) return false;
  unclocked_s_ += kerf::CalcElapsed(tick_.in, params_.rate_hz);
  tick_.time_s = unclocked_s_;
  counts_.missed += tick_.in.skipped;
  counts_.longest_gap = std::max(counts_.longest_gap, std::uint64_t{tick_.in.skipped});
  Exchange(on_time, clock_.Now());
  return true;
}

void HapticLoop::Finish(LoopEnd end) {
  device_.Close();
  end_.store(end);
}

void HapticLoop::TickOnce() {
  clock_.SleepUntil(deadlines_.due_ns());
  const std::int64_t now_ns = clock_.Now();
  const Deadlines::Tick when = deadlines_.Begin(now_ns);
  const std::int64_t before_ns = beat_ns_.exchange(now_ns);
  bool device_works = true;
  try {
    const HeapGuard guard;
    // The loop stalled for longer than the watchdog's limit. Trip the device here, since the watchdog thread may have
    // stalled too.
    const bool stale = static_cast<double>(now_ns - before_ns) > 1e6 * params_.watchdog_ms;
    if (stale) device_.Trip();
    if (device_.TakeTripped()) {
      body_.RampIn();
      ++counts_.ramps;
    }
    device_works = DoTick(when);
    if (device_works) Exchange(when, now_ns);
  } catch (const std::exception& e) {
    failure_ = e.what();
    Finish(LoopEnd::kFailed);
    return;
  }
  if (!device_works) {
    failure_ = "the device failed: it did not accept a force or report its position";
    Finish(LoopEnd::kDeviceFailed);
    return;
  }
  const std::int64_t end_ns = clock_.Now();
  tick_times_.Add(end_ns - now_ns);
  lateness_.Add(when.late_ns);
  const double tick_us = 1e-3 * static_cast<double>(end_ns - now_ns);
  const double time_s = 1e-9 * static_cast<double>(end_ns - start_ns_);
  if (const std::optional<Fidelity> change = governor_.Observe(time_s, tick_us)) body_.SetFidelity(*change);
  deadlines_.End(clock_.Now());
}

bool HapticLoop::DoTick(const Deadlines::Tick& when) {
  const double period_s = 1 / params_.rate_hz;
  const double elapsed_s = static_cast<double>(1 + when.skipped) * period_s;
  const double dt_s = std::min(elapsed_s, std::max(kMaxTickDt_s, period_s));
  if (!body_.Tick(dt_s, stages_, tick_)) return false;
  stages_.Finish();
  const double time_s = 1e-9 * static_cast<double>(when.due_ns - start_ns_);
  tick_.time_s = unclocked_s_ + time_s;
  // In StepWithoutClock(), the body reports this number.
  if (when.due_ns != 0) tick_.in.skipped = static_cast<std::uint32_t>(std::min<std::int64_t>(when.skipped, INT32_MAX));
  if (params_.load.burn_us > 0 && time_s >= params_.load.from_s && time_s < params_.load.to_s) {
    clock_.Burn(Nanoseconds(1e-6 * params_.load.burn_us * BurnFraction(governor_.fidelity())));
  }
  const CoupledOutput& out = tick_.coupled;
  ++counts_.ticks;
  tick_.number = counts_.ticks;
  counts_.missed += static_cast<std::uint64_t>(when.skipped);
  counts_.longest_gap = std::max(counts_.longest_gap, static_cast<std::uint64_t>(when.skipped));
  counts_.status_ticks += (out.status & ~kHarmless) != 0 ? 1U : 0U;
  counts_.bad_poses += (out.status & kCoupledBadPose) != 0 ? 1U : 0U;
  counts_.not_finite += IsFinite(out.f_H_W_N) && IsFinite(tick_.force.f_H_W_N) ? 0U : 1U;
  counts_.removed_mm3 += out.removed_mm3;
  return true;
}

void HapticLoop::Exchange(const Deadlines::Tick& when, std::int64_t begin_ns) {
  const std::int64_t before_ns = clock_.Now();
  const bool all_marked = MarkChanged(tick_.time_s);
  // Restored bone is sent faster than cut bone.
  if (tick_.stands && params_.leaves_per_tick > 0) catching_up_ = true;
  publisher_.Send(catching_up_ ? std::max(params_.leaves_per_tick, kCatchUpLeaves) : params_.leaves_per_tick);
  if (publisher_.waiting() == 0) catching_up_ = false;
  if (all_marked)
    sent_until_s_ = publisher_.waiting() == 0 ? tick_.time_s : publisher_.oldest_s() - 1 / params_.rate_hz;
  tick_.tick_us = Microseconds(before_ns - begin_ns);
  tick_.late_us = Microseconds(when.late_ns);
  if (channel_count_ > 0) {
    const std::size_t slot = samples_sent_ % (samples_.capacity() + 1);
    body_.ReportChannels(std::span(channels_).subspan(slot * channel_count_, channel_count_));
  }
  if (samples_.TryPush(tick_)) {
    ++samples_sent_;
  } else {
    ++counts_.samples_lost;
  }
  LoopState& state = state_.back();
  state.last = tick_;
  state.sent_until_s = sent_until_s_;
  state_.Publish();
  exchange_times_.Add(clock_.Now() - before_ns);
}

bool HapticLoop::SendRemaining() {
  MarkChanged(tick_.time_s);
  if (publisher_.waiting() == 0) return false;
  publisher_.Send(params_.leaf_ring);
  return true;
}

/// Queues the changed leaves, and removes these from the simulation's list. If the queue is full, the others stay
/// there. Returns false in that case.
bool HapticLoop::MarkChanged(double time_s) {
  const int count = body_.changed_count();
  int marked = 0;
  for (; marked < count; ++marked) {
    const ChangedLeaf leaf = body_.changed(marked);
    if (!publisher_.Mark(leaf.index, leaf.cut, time_s)) break;
  }
  if (marked > 0) body_.ClearChanged(marked);
  return marked == count;
}

}  // namespace kerf
