// Finds that the loop has stopped coming round, and makes the device's force zero.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "base/realtime/loop_clock.h"
#include "loop/haptics/guarded_device.h"

namespace kerf {

/// The judgement alone: no thread, no clock.
class Watchdog {
 public:
  Watchdog(GuardedDevice& device, std::int64_t limit_ns) : device_(device), limit_ns_(limit_ns) {}

  /// `beat_ns`: when the loop last began a tick. Trips the device once in each standstill longer than the limit. True
  /// when it did so now.
  bool Look(std::int64_t now_ns, std::int64_t beat_ns) noexcept;

 private:
  GuardedDevice& device_;
  std::int64_t limit_ns_;
  std::int64_t tripped_at_beat_ns_ = INT64_MIN;
};

/// A thread that looks five times in the limit, at a higher priority than the loop's where that is allowed.
class WatchdogThread {
 public:
  /// `priority`: SCHED_FIFO; 0: an ordinary thread. All must outlive this.
  WatchdogThread(GuardedDevice& device, LoopClock& clock, const std::atomic<std::int64_t>& beat_ns,
                 std::int64_t limit_ns, int priority);
  ~WatchdogThread();
  WatchdogThread(const WatchdogThread&) = delete;
  WatchdogThread& operator=(const WatchdogThread&) = delete;
  long trips() const { return trips_.load(); }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<long> trips_{0};
  std::thread thread_;
};

}  // namespace kerf
