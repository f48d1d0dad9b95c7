#include "loop/haptics/watchdog.h"

#include <algorithm>

#include "base/realtime/realtime.h"

namespace kerf {

bool Watchdog::Look(std::int64_t now_ns, std::int64_t beat_ns) noexcept {
  if (now_ns - beat_ns <= limit_ns_ || beat_ns == tripped_at_beat_ns_) return false;
  // If Trip() fails, the loop is using the device and is therefore not stalled; the next Look() tries again.
  if (!device_.Trip()) return false;
  tripped_at_beat_ns_ = beat_ns;
  return true;
}

WatchdogThread::WatchdogThread(GuardedDevice& device, LoopClock& clock, const std::atomic<std::int64_t>& beat_ns,
                               std::int64_t limit_ns, int priority)
    : thread_([this, &device, &clock, &beat_ns, limit_ns, priority] {
        RealtimeGrants grants;
        RequestPriority(priority, grants);
        Watchdog watchdog(device, limit_ns);
        const std::int64_t between_ns = std::max<std::int64_t>(limit_ns / 5, 100'000);
        for (std::int64_t next_ns = clock.Now(); !stop_.load(); next_ns += between_ns) {
          clock.SleepUntil(next_ns);
          const std::int64_t now_ns = clock.Now();
          next_ns = std::max(next_ns, now_ns - between_ns);
          if (watchdog.Look(now_ns, beat_ns.load())) trips_.fetch_add(1);
        }
      }) {}

WatchdogThread::~WatchdogThread() {
  stop_.store(true);
  thread_.join();
}

}  // namespace kerf
