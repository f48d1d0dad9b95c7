// Clocks, and binding of the measured thread to a core.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "loop/haptics/stage_timer.h"

namespace kerf {

/// Returns the time of a monotonic clock, ns.
std::int64_t ReadClock_ns();
inline double ReadClock_ms() {
  return 1e-6 * static_cast<double>(ReadClock_ns());
}
inline double CalcSecondsSince(std::int64_t start_ns) {
  return 1e-9 * static_cast<double>(ReadClock_ns() - start_ns);
}

/// How often the system has interrupted this thread so far, and has had to find it a page of memory.
struct Disturbances {
  long interruptions = 0;
  long page_faults = 0;
};
Disturbances CountDisturbances();

struct WorkTime {
  std::int64_t ns = 0;
  bool undisturbed = true;  // the system did not interrupt the thread
  bool page_fault = false;

  double us() const { return 1e-3 * static_cast<double>(ns); }
};
/// Times one call of `work`; nothing else runs between the two clock readings.
template <typename Work>
WorkTime TimeWork(Work&& work) {
  const Disturbances before = CountDisturbances();
  const std::int64_t start_ns = ReadClock_ns();
  work();
  const std::int64_t ns = ReadClock_ns() - start_ns;
  const Disturbances after = CountDisturbances();
  return {ns, after.interruptions == before.interruptions, after.page_faults > before.page_faults};
}

/// Times the stages of ticks; leaves out ticks in which the system interrupted the thread.
class UndisturbedStages {
 public:
  /// `tick` runs one tick with the given observer.
  template <typename Tick>
  void Time(Tick&& tick) {
    const bool undisturbed = TimeWork([&] { tick(&timer_); }).undisturbed;
    timer_.Finish(undisturbed);
    if (undisturbed) ++ticks_;
  }
  /// Returns the mean over the ticks, by TickStage, us.
  std::vector<double> CalcMeans_us() const;

 private:
  MonotonicClock clock_;
  StageTimer timer_{clock_};
  std::uint64_t ticks_ = 0;
};
const char* NameOfStage(std::size_t stage);

/// The core that a measurement uses; `core` may be optional.
template <typename Core, typename V>
void DescribeCore(Core& core, V&& visit) {
  visit("core", core, Range{0, 4095}, "core that runs the ticks, zero-based");
}
/// Voxel size of the mandible in measurements.
inline constexpr Range kBenchVoxelRange_mm{0.1, 1};

/// Binds the calling thread to one core for the lifetime of the object.
class PinnedToCore {
 public:
  /// If `realtime` is true, requests real-time priority, as the loop does. Throws Error if this program may not use
  /// that core, or if the system does not permit real-time priority.
  explicit PinnedToCore(int core, bool realtime = false);
  ~PinnedToCore();
  PinnedToCore(const PinnedToCore&) = delete;
  PinnedToCore& operator=(const PinnedToCore&) = delete;

 private:
  std::vector<unsigned char> before_;
  int policy_before_ = 0;
  int priority_before_ = 0;
};

}  // namespace kerf
