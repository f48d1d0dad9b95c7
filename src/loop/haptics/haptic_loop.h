// Real-time loop that runs ticks at a fixed rate in a separate thread, with timing, watchdog and governor. Other
// threads read its state through queues that never block the loop.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/core/log_histogram.h"
#include "base/core/spsc_ring.h"
#include "base/core/triple_buffer.h"
#include "base/realtime/deadlines.h"
#include "base/realtime/loop_clock.h"
#include "base/realtime/realtime.h"
#include "loop/haptics/guarded_device.h"
#include "loop/haptics/leaf_stream.h"
#include "loop/haptics/loop_body.h"
#include "loop/haptics/loop_params.h"
#include "loop/haptics/stage_timer.h"
#include "loop/haptics/watchdog.h"

namespace kerf {

/// Latest state, read by the renderer.
struct LoopState {
  LoopTick last;
  double sent_until_s = 0;  // all changes up to this time have been sent
};

/// Reason why the loop ended.
enum class LoopEnd : std::uint8_t { kNotYet, kRequested, kDeviceFailed, kFailed };

/// Totals of a run, read after it ends.
struct LoopCounts {
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;
  std::uint64_t longest_gap = 0;   // longest run of consecutive missed deadlines
  std::uint64_t ramps = 0;         // number of times the force was ramped in again from zero
  std::uint64_t samples_lost = 0;  // samples dropped because the log's reader was too slow
  std::uint64_t status_ticks = 0;  // ticks with a status bit for something that was not done as requested
  std::uint64_t not_finite = 0;    // ticks whose force was not finite
  std::uint64_t bad_poses = 0;
  double removed_mm3 = 0;
};

class HapticLoop {
 public:
  /// `device` must be the one to which `body` writes. All references must outlive the loop. Throws kerf::Error if a
  /// parameter is out of range.
  HapticLoop(LoopBody& body, GuardedDevice& device, LoopClock& clock, const LoopParams& params);
  /// Calls Stop().
  ~HapticLoop();
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  /// Enables timing of each effect in stages(). Call before the loop starts.
  void Watch(EffectPlan& plan) { stages_.Watch(plan); }

  /// Runs a tick in the calling thread, without a clock. Call before the loop starts, and empty the queues before each
  /// call. The tick lasts as long as the body reports (TickInputs::dt_s); the loop's time then continues from the end
  /// of these ticks. Returns false if the device has failed. Rethrows exceptions of the body.
  bool StepWithoutClock();
  /// Starts the loop thread and the watchdog thread. Returns once it is known which real-time privileges the system
  /// grants. Call at most once.
  void Start();
  /// Waits for the current tick, sets the force to zero and ends the threads. May be called any number of times.
  void Stop();
  /// The same loop in the calling thread, without priority, locked memory or watchdog, for use with a VirtualClock:
  /// BeginHere(), then StepHere() for each tick until it returns false or enough ticks are done, then EndHere(), which
  /// ends the loop as Stop() does. StepHere() returns false, without a tick, if the loop has ended.
  void BeginHere();
  bool StepHere();
  void EndHere();
  /// Does all this for `ticks` ticks. `between` (optional) is called after each tick, outside the heap guard; the run
  /// ends if it returns false.
  void RunHere(std::int64_t ticks, const std::function<bool()>& between = {});
  /// Sends the remaining changed leaves, as far as the ring has room. Call after the loop has ended. Returns false if
  /// none remained.
  bool SendRemaining();
  /// Time since the loop started. May be called by any thread after Start().
  std::chrono::nanoseconds CalcElapsed() const { return std::chrono::nanoseconds(clock_.Now() - start_ns_); }
  /// False once the loop has ended.
  bool running() const { return end_.load() == LoopEnd::kNotYet; }

  // ---- For use while the loop runs. Each of these has one reader, in any thread.
  TripleBuffer<LoopState>& state() { return state_; }
  SpscRing<LoopTick>& samples() { return samples_; }
  /// The body's channels for the current sample, for the reader of samples(). `popped`: number of samples that the
  /// reader has popped so far. Valid until the current sample is popped.
  std::span<const double> channels(std::uint64_t popped) const {
    return {channels_.data() + popped % (samples_.capacity() + 1) * channel_count_, channel_count_};
  }
  SpscRing<LeafMessage>& leaves() { return leaves_; }
  // For any thread.
  const LogHistogram& tick_times() const { return tick_times_; }
  const LogHistogram& lateness() const { return lateness_; }
  const LogHistogram& exchange_times() const { return exchange_times_; }  // of logging and sending, part of the tick
  const LogHistogram& stage_times(TickStage stage) const { return stages_.times(stage); }
  const StageTimer& stages() const { return stages_; }
  long watchdog_trips() const { return watchdog_ ? watchdog_->trips() : watchdog_trips_; }

  // ---- For use after the loop has ended; grants() also after Start().
  const RealtimeGrants& grants() const { return grants_; }
  const LoopCounts& counts() const { return counts_; }
  const Governor& governor() const { return governor_; }
  LoopEnd end() const { return end_.load(); }
  const std::string& failure() const { return failure_; }  // one sentence; empty if no error occurred

 private:
  void RunThread();
  void TickOnce();
  bool DoTick(const Deadlines::Tick& when);
  void Exchange(const Deadlines::Tick& when, std::int64_t begin_ns);
  bool MarkChanged(double time_s);
  void Finish(LoopEnd end);

  LoopBody& body_;
  GuardedDevice& device_;
  LoopClock& clock_;
  LoopParams params_;
  std::int64_t period_ns_;
  Deadlines deadlines_;
  Governor governor_;
  StageTimer stages_;
  LogHistogram tick_times_;
  LogHistogram lateness_;
  LogHistogram exchange_times_;
  SpscRing<LeafMessage> leaves_;
  SpscRing<LoopTick> samples_;
  // One slot more than the ring's capacity, so that the slot being written is never one that is being read.
  std::size_t channel_count_;
  std::vector<double> channels_;
  std::uint64_t samples_sent_ = 0;
  TripleBuffer<LoopState> state_;
  LeafPublisher publisher_;
  double sent_until_s_ = 0;
  bool catching_up_ = false;

  LoopTick tick_;
  LoopCounts counts_;
  double unclocked_s_ = 0;
  std::int64_t start_ns_ = 0;
  std::atomic<std::int64_t> beat_ns_{0};
  std::atomic<bool> stop_{false};
  std::atomic<bool> started_{false};
  std::atomic<LoopEnd> end_{LoopEnd::kNotYet};
  std::string failure_;
  RealtimeGrants grants_;
  std::unique_ptr<WatchdogThread> watchdog_;
  long watchdog_trips_ = 0;
  std::thread thread_;
};

/// Maximum dt of a tick, unless the period is longer. dt is the real time since the last tick, so that after 9 missed
/// ticks, a hand that moves at 5 mm/s is not taken for one at 50 mm/s, which would also distort the cutting law.
inline constexpr double kMaxTickDt_s = 0.010;

}  // namespace kerf
