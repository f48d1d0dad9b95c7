#include "app/window/progress_meter.h"

#include <algorithm>
#include <chrono>

namespace kerf {
namespace {

constexpr double kMinElapsed_s = 1;
constexpr double kMinEstimatedFraction = 0.02;

}  // namespace

double ProgressMeter::Now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void ProgressMeter::Set(const std::string& stage, double fraction, double now_s) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (stage != stage_) {
    stage_ = stage;
    fraction_ = fraction;
    began_s_ = set_s_ = now_s;
    return;
  }
  if (fraction <= fraction_) return;
  fraction_ = fraction;
  set_s_ = now_s;
}

WorkProgress ProgressMeter::Get(double now_s) const {
  WorkProgress progress{.stage = stage_, .fraction = fraction_, .seconds_left = {}};
  const double elapsed_s = set_s_ - began_s_;
  if (elapsed_s < kMinElapsed_s || fraction_ < kMinEstimatedFraction) return progress;
  const double left_s = elapsed_s * (1 - fraction_) / fraction_;
  progress.seconds_left = std::max(0.0, left_s - (now_s - set_s_));
  return progress;
}

}  // namespace kerf
