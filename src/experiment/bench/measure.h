// Clocks and the state of the machine on which the figures were measured.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/coupled.h"

namespace kerf {

/// Returns the time of a monotonic clock, ns.
std::int64_t ReadClock_ns();

/// Returns how often the system has interrupted this thread so far.
long CountInterruptions();

/// Adds up the time of each stage over the ticks; leaves out ticks in which the system interrupted the thread.
class StageClock : public TickObserver {
 public:
  static constexpr std::size_t kStages = static_cast<std::size_t>(TickStage::kEnd);

  void Enter(TickStage stage) noexcept override;
  /// Ends the tick; the next tick begins with the next Enter().
  void FinishTick() noexcept;
  /// Returns the mean over the ticks, by stage, us.
  std::array<double, kStages> CalcMeans_us() const;

 private:
  std::array<std::int64_t, kStages> in_tick_ns_{};
  std::array<std::int64_t, kStages> sum_ns_{};
  std::size_t now_ = kStages;
  std::int64_t since_ns_ = 0;
  std::int64_t ticks_ = 0;
  long interruptions_ = CountInterruptions();
};
const char* NameOfStage(std::size_t stage);

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

struct MachineState {
  std::string cpu;  // model name as reported by the system
  int cores = 0;    // number of cores that this program may use
  double load = 0;  // load average: mean number of programs ready to run in the last minute
};
MachineState LookAtMachine();

}  // namespace kerf
