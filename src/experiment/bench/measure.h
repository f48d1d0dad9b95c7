// Clocks, percentiles and the machine that figures were measured on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/coupled.h"

namespace kerf {

/// Of a clock that only goes forward, ns.
std::int64_t ReadClock_ns();

/// How often the system has taken the core from this thread so far.
long CountInterruptions();

/// Nearest-rank percentiles, microseconds; all 0 for none.
struct Percentiles {
  std::size_t count = 0;
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};
Percentiles CalcPercentiles(std::vector<double> times_us);

/// Adds up the time between the stages of ticks; leaves out ticks in which the system took the core away.
class StageClock : public TickObserver {
 public:
  static constexpr std::size_t kStages = static_cast<std::size_t>(TickStage::kEnd);

  void Enter(TickStage stage) noexcept override;
  /// The tick is over, and the next begins with the next Enter().
  void FinishTick() noexcept;
  /// Mean over the ticks, by stage, us.
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

/// Holds the calling thread to one core while it stands.
class PinnedToCore {
 public:
  /// `realtime`: before all programs that have not asked for that too, as the loop runs. Throws Error when there is no
  /// such core for this program, or the system does not allow real time.
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
  std::string cpu;  // its model, as the system names it
  int cores = 0;    // that this program may use
  double load = 0;  // programs that wanted a core in the last minute, on average
};
MachineState LookAtMachine();

}  // namespace kerf
