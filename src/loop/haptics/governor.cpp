#include "loop/haptics/governor.h"

#include <algorithm>

namespace kerf {
namespace {

/// A window with fewer ticks than this is extended instead of evaluated.
constexpr long kMinTicks = 4;
constexpr double kCalmTicks = 0.01;

Fidelity Below(Fidelity fidelity) {
  return fidelity == Fidelity::kFull ? Fidelity::kCoarse : Fidelity::kSlab;
}
Fidelity Above(Fidelity fidelity) {
  return fidelity == Fidelity::kSlab ? Fidelity::kCoarse : Fidelity::kFull;
}

}  // namespace

const char* ToString(FidelityReason reason) {
  return reason == FidelityReason::kOverrun ? "overrun" : "calm";
}

std::optional<Fidelity> Governor::Observe(double time_s, double tick_us) {
  if (!params_.degrade) return std::nullopt;
  if (!begun_) {
    begun_ = true;
    window_start_s_ = calm_since_s_ = time_s - params_.period_s;
  }
  const double budget_us = 1e6 * params_.period_s * params_.budget_share;
  ++ticks_;
  over_ += tick_us > budget_us ? 1 : 0;
  not_calm_ += tick_us > budget_us * params_.calm_fraction ? 1 : 0;
  longest_us_ = std::max(longest_us_, tick_us);
  if (time_s - window_start_s_ < params_.window_s || ticks_ < kMinTicks) return std::nullopt;

  const Fidelity before = fidelity_;
  const double n = static_cast<double>(ticks_);
  const bool calm = static_cast<double>(not_calm_) <= kCalmTicks * n;
  if (!calm) calm_since_s_ = time_s;
  if (static_cast<double>(over_) > params_.overrun_share * n && fidelity_ != Fidelity::kSlab) {
    // If the last raise has to be reverted, it came too early: wait longer before the next one.
    const bool taken_back = time_s - last_up_s_ < params_.calm_s;
    wait_s_ = taken_back ? std::min(2 * wait_s_, std::max(params_.longest_calm_s, params_.calm_s)) : params_.calm_s;
    Step(time_s, Below(fidelity_), FidelityReason::kOverrun);
  } else if (calm && fidelity_ != Fidelity::kFull && time_s - calm_since_s_ >= wait_s_) {
    last_up_s_ = time_s;
    Step(time_s, Above(fidelity_), FidelityReason::kCalm);
  }
  window_start_s_ = time_s;
  ticks_ = over_ = not_calm_ = 0;
  longest_us_ = 0;
  if (fidelity_ == before) return std::nullopt;
  return fidelity_;
}

void Governor::Step(double time_s, Fidelity to, FidelityReason reason) {
  if (step_count_ < kKeptSteps) {
    steps_[static_cast<std::size_t>(step_count_)] = {
        time_s, fidelity_, to, reason, static_cast<double>(over_) / static_cast<double>(ticks_), longest_us_};
  }
  ++step_count_;
  fidelity_ = to;
  calm_since_s_ = time_s;
}

}  // namespace kerf
