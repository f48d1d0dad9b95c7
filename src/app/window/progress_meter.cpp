#include "app/window/progress_meter.h"

#include <algorithm>
#include <chrono>
#include <cmath>

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
    fraction_ = shown_ = fraction;
    began_s_ = set_s_ = now_s;
    return;
  }
  if (fraction <= fraction_) return;
  shown_ = std::max(Get(now_s).fraction, fraction);
  fraction_ = fraction;
  set_s_ = now_s;
}

WorkProgress ProgressMeter::Get(double now_s) const {
  WorkProgress progress{.stage = stage_, .fraction = shown_, .seconds_left = {}};
  const double elapsed_s = set_s_ - began_s_;
  if (elapsed_s < kMinElapsed_s || fraction_ < kMinEstimatedFraction) return progress;
  const double left_s = elapsed_s * (1 - fraction_) / fraction_;
  // Without reports, the work is expected to go on at the same rate at first. It then seems to slow down, so that
  // neither the fraction nor the time that is left claims an end that was not reported.
  const double rest = left_s > 0 ? std::exp(-std::max(0.0, now_s - set_s_) / left_s) : 1;
  progress.fraction = std::max(shown_, 1 - (1 - fraction_) * rest);
  progress.seconds_left = left_s * rest;
  return progress;
}

}  // namespace kerf
