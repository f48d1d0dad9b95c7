// How long the parts of a tick take.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/log_histogram.h"
#include "haptics/loop_clock.h"
#include "kerf/coupled.h"

namespace kerf {

inline constexpr std::size_t kTickStages = static_cast<std::size_t>(TickStage::kEnd);
const char* ToString(TickStage stage);

/// Adds up the time in each stage over a tick, however often it is entered; a tick that never enters a stage does not
/// count for it. Tick-safe; one thread, but the histograms may be read by any.
class StageTimer final : public TickObserver {
 public:
  explicit StageTimer(LoopClock& clock) : clock_(clock) {}

  void Enter(TickStage stage) noexcept override {
    const std::int64_t now_ns = clock_.Now();
    if (now_ < kTickStages) spent_ns_[now_] += now_ns - since_ns_;
    now_ = static_cast<std::size_t>(stage);
    if (now_ < kTickStages) entered_[now_] = true;
    since_ns_ = now_ns;
  }
  /// The tick is over.
  void Finish() noexcept {
    if (now_ < kTickStages) Enter(TickStage::kEnd);
    for (std::size_t i = 0; i < kTickStages; ++i) {
      if (entered_[i]) times_[i].Add(spent_ns_[i]);
      spent_ns_[i] = 0;
      entered_[i] = false;
    }
  }
  const LogHistogram& times(TickStage stage) const { return times_[static_cast<std::size_t>(stage)]; }

 private:
  LoopClock& clock_;
  std::size_t now_ = kTickStages;
  std::int64_t since_ns_ = 0;
  std::array<std::int64_t, kTickStages> spent_ns_{};
  std::array<bool, kTickStages> entered_{};
  std::array<LogHistogram, kTickStages> times_;
};

}  // namespace kerf
