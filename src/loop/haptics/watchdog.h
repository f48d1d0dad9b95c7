// Detects that the loop has stalled and sets the device's force to zero.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "base/realtime/loop_clock.h"
#include "loop/haptics/guarded_device.h"

namespace kerf {

/// Decision logic of the watchdog, without a thread or a clock.
class Watchdog {
 public:
  Watchdog(GuardedDevice& device, std::int64_t limit_ns) : device_(device), limit_ns_(limit_ns) {}

  /// `beat_ns`: time at which the last tick of the loop began. Trips the device once per stall that is longer than the
  /// limit. Returns true if this call tripped it.
  bool Look(std::int64_t now_ns, std::int64_t beat_ns) noexcept;

 private:
  GuardedDevice& device_;
  std::int64_t limit_ns_;
  std::int64_t tripped_at_beat_ns_ = INT64_MIN;
};

/// Thread that calls Look() five times per limit, at a higher priority than the loop's if the system permits it.
class WatchdogThread {
 public:
  /// `priority`: SCHED_FIFO priority; 0: normal scheduling. All references must outlive this object.
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
