// The loop: ticks at a steady rate in a thread of its own, timed, watched and kept in time; what others need to see
// goes out through queues that never stop it.
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
#include "loop/haptics/governor.h"
#include "loop/haptics/guarded_device.h"
#include "loop/haptics/leaf_stream.h"
#include "loop/haptics/loop_body.h"
#include "loop/haptics/stage_timer.h"
#include "loop/haptics/watchdog.h"

namespace kerf {

struct LoopParams {
  double rate_hz = 1000;             // 250 to 4000
  double watchdog_ms = 50;           // 2 to 10000: a tick that began longer ago makes the force zero
  int leaves_per_tick = 4;           // sent to readers, 0 to 1000
  int max_leaves_waiting = 1 << 15;  // to be sent, 1 to 2^24; what does not fit waits in the simulation
  int leaf_ring = 512;               // sent and not read yet, 1 to 65536; 2 kB each
  int sample_ring = 8192;            // ticks logged and not read yet, 1 to 2^20
  int priority = 80;                 // SCHED_FIFO, 1 to 98 where it is allowed; 0: don't ask
  bool lock_memory = true;           // where it is allowed
  GovernorParams governor;           // its period is the loop's
  // Fault injection, to show the governor: time burnt in each tick between these moments, in full fidelity; half as
  // much in coarse, a tenth in slab.
  double burn_us = 0;  // 0 to 1e6
  double burn_from_s = 0;
  double burn_to_s = 1e300;
};

/// A tick, as logged.
struct LoopSample {
  std::uint64_t tick = 0;  // its number, from 1: where one is missing, it was lost
  double time_s = 0;       // of its deadline, since the start
  int skipped = 0;         // deadlines missed before it
  LoopTick report;
  float tick_us = 0;
  float late_us = 0;
};

/// The newest state, for whoever draws it.
struct LoopState {
  LoopSample last;
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  // deadlines without a tick
  double removed_mm3 = 0;
  std::size_t leaves_waiting = 0;
  double sent_until_s = 0;  // what had changed by then has been sent
};

/// Why the loop is over.
enum class LoopEnd : std::uint8_t { kNotYet, kAsked, kDeviceFailed, kFailed };

/// What happened, for after the end.
struct LoopCounts {
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;
  std::uint64_t longest_gap = 0;   // deadlines missed in a row
  std::uint64_t ramps = 0;         // times the force began again from zero
  std::uint64_t samples_lost = 0;  // the log's reader was too slow
  std::uint64_t status_ticks = 0;  // with a status bit that tells of something not done as asked
  std::uint64_t not_finite = 0;    // ticks whose force came out not finite
  std::uint64_t bad_poses = 0;
  double removed_mm3 = 0;
};

class HapticLoop {
 public:
  /// The device is the one that `body` writes to. All must outlive the loop. Throws Error for a parameter out of range.
  HapticLoop(LoopBody& body, GuardedDevice& device, LoopClock& clock, const LoopParams& params);
  /// Stops.
  ~HapticLoop();
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  /// Times each effect too, in stages(); before the loop begins.
  void Watch(EffectPlan& plan) { stages_.Watch(plan); }

  /// Before it begins: ticks in the calling thread, without a clock, for as long as `more` says; it is called before
  /// each tick, outside the heap guard, and reads what the queues have. Each lasts as long as the body reports
  /// (LoopGiven::dt_s), and the loop's own time begins after them. Throws what the body throws.
  void GoThrough(const std::function<bool()>& more);
  /// Starts the loop's thread and the watchdog's; returns when the system has said what it grants. Once.
  void Start();
  /// Waits for the tick under way, makes the force zero, and ends the threads. Any number of times.
  void Stop();
  /// Runs `ticks` ticks in the calling thread, without priority, locked memory or watchdog; then as Stop(). For a
  /// VirtualClock. `between` is called after each tick, outside the heap guard, and ends the run by false; may be
  /// empty.
  void RunHere(std::int64_t ticks, const std::function<bool()>& between = {});
  /// After the end: sends changed leaves that still wait, as far as there is room. False when there were none.
  bool SendRest();
  /// Since it began, which is when its time is 0; after Start(), by any thread.
  std::chrono::nanoseconds CalcElapsed() const { return std::chrono::nanoseconds(clock_.Now() - start_ns_); }
  /// False once the loop has ended by itself.
  bool running() const { return end_.load() == LoopEnd::kNotYet; }

  // ---- while it runs: one reader each, no matter which thread
  TripleBuffer<LoopState>& state() { return state_; }
  SpscRing<LoopSample>& samples() { return samples_; }
  /// The body's figures of the sample that is read now, by the reader of samples(): `popped`, how many it has read
  /// before. Until that is popped.
  std::span<const double> channels(std::uint64_t popped) const {
    return {channels_.data() + popped % (samples_.capacity() + 1) * channel_count_, channel_count_};
  }
  SpscRing<LeafMessage>& leaves() { return leaves_; }
  // any thread
  const LogHistogram& tick_times() const { return tick_times_; }
  const LogHistogram& lateness() const { return lateness_; }
  const LogHistogram& exchange_times() const { return exchange_times_; }  // logging and sending, part of the tick
  const LogHistogram& stage_times(TickStage stage) const { return stages_.times(stage); }
  const StageTimer& stages() const { return stages_; }
  long watchdog_trips() const { return watchdog_ ? watchdog_->trips() : watchdog_trips_; }

  // ---- after the end (or, for the grants, after Start())
  const RealtimeGrants& grants() const { return grants_; }
  const LoopCounts& counts() const { return counts_; }
  const Governor& governor() const { return governor_; }
  LoopEnd end() const { return end_.load(); }
  const std::string& failure() const { return failure_; }  // a sentence; empty when all went well

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
  SpscRing<LoopSample> samples_;
  // A slot more than samples wait: the one that is filled is never one that is read.
  std::size_t channel_count_;
  std::vector<double> channels_;
  std::uint64_t samples_sent_ = 0;
  TripleBuffer<LoopState> state_;
  LeafPublisher publisher_;
  int next_mark_ = 0;
  double sent_until_s_ = 0;
  bool catching_up_ = false;

  LoopSample sample_;
  LoopCounts counts_;
  double gone_through_s_ = 0;
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

/// Of the loop's dt: real motion over real time, so that a hand at 5 mm/s that nobody looked at for 9 ticks is not
/// taken for one at 50 mm/s, and the cutting law with it; but never more than this, or a single period if that is
/// longer.
inline constexpr double kLongestTick_s = 0.010;

}  // namespace kerf
