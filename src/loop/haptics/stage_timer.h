// Durations of the stages of a tick.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/core/log_histogram.h"
#include "base/realtime/loop_clock.h"
#include "cut/effects/plan.h"
#include "kerf/coupled.h"

namespace kerf {

inline constexpr std::size_t kTickStages = static_cast<std::size_t>(TickStage::kEnd);
const char* ToString(TickStage stage);

/// Adds up the time spent in each stage over a tick, even if a stage is entered several times. A tick that does not
/// enter a stage adds no value to its histogram. Tick-safe. Used by one thread, but any thread may read the histograms.
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
  /// Enables timing of each of the plan's effects. Not tick-safe.
  void Watch(EffectPlan& plan) {
    effects_ = std::vector<EffectTime>(plan.entries().size());
    plan.set_observer(this);
  }
  void EnterEffect(std::size_t effect) noexcept override {
    effect_ = effect;
    effect_since_ns_ = clock_.Now();
  }
  void LeaveEffect() noexcept override { effects_[effect_].spent_ns += clock_.Now() - effect_since_ns_; }
  /// Ends the tick. Its times are added to the histograms if `counts` is true.
  void Finish(bool counts = true) noexcept {
    if (now_ < kTickStages) Enter(TickStage::kEnd);
    for (std::size_t i = 0; i < kTickStages; ++i) {
      if (entered_[i] && counts) times_[i].Add(spent_ns_[i]);
      spent_ns_[i] = 0;
      entered_[i] = false;
    }
    for (EffectTime& effect : effects_) {
      const std::int64_t spent_ns = std::exchange(effect.spent_ns, 0);
      if (counts) effect.times.Add(spent_ns);
    }
  }
  const LogHistogram& times(TickStage stage) const { return times_[static_cast<std::size_t>(stage)]; }
  /// Number of watched effects of the plan. The times of the effects are also part of the stages' times. A tick in
  /// which an effect does nothing is counted too.
  std::size_t effect_count() const { return effects_.size(); }
  const LogHistogram& effect_times(std::size_t effect) const { return effects_[effect].times; }

 private:
  LoopClock& clock_;
  std::size_t now_ = kTickStages;
  std::int64_t since_ns_ = 0;
  std::array<std::int64_t, kTickStages> spent_ns_{};
  std::array<bool, kTickStages> entered_{};
  std::array<LogHistogram, kTickStages> times_;
  struct EffectTime {
    std::int64_t spent_ns = 0;  // in this tick
    LogHistogram times;
  };
  std::vector<EffectTime> effects_;
  std::size_t effect_ = 0;
  std::int64_t effect_since_ns_ = 0;
};

}  // namespace kerf
