#include "app/window/progress_meter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

constexpr double kMinElapsed_s = 1;
constexpr double kMinEstimatedFraction = 0.02;
constexpr double kReport = 0.001;  // reports that increase the fraction by less are not kept
constexpr double kFollow_s = 5;    // time in which the estimate follows a change of the rate

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
    left_s_.reset();
    reports_ = {{now_s, fraction}};
    return;
  }
  if (fraction <= fraction_) return;
  shown_ = std::max(Get(now_s).fraction, fraction);
  fraction_ = fraction;
  const double since_s = now_s - std::exchange(set_s_, now_s);
  if (fraction_ >= reports_.back().fraction + kReport) reports_.push_back({now_s, fraction_});
  const double elapsed_s = now_s - began_s_;
  if (elapsed_s < kMinElapsed_s || fraction_ < kMinEstimatedFraction) return;
  // The rate of the latest half of the time: an earlier part of the work may have been faster.
  while (reports_.size() > 1 && reports_[1].at_s <= now_s - 0.5 * elapsed_s) reports_.pop_front();
  const Report& from = reports_.front();
  const double now_left_s = (now_s - from.at_s) * (1 - fraction_) / (fraction_ - from.fraction);
  const double expected_s = left_s_ ? std::max(0.0, *left_s_ - since_s) : now_left_s;
  const double share = fraction_ == 1 ? 1 : 1 - std::exp(-since_s / kFollow_s);
  left_s_ = expected_s + share * (now_left_s - expected_s);
}

WorkProgress ProgressMeter::Get(double now_s) const {
  WorkProgress progress{.stage = stage_, .fraction = shown_, .seconds_left = {}};
  if (!left_s_) return progress;
  const double left_s = *left_s_;
  // Without reports, the work is expected to go on at the same rate at first. It then seems to slow down, so that
  // neither the fraction nor the time that is left claims an end that was not reported.
  const double rest = left_s > 0 ? std::exp(-std::max(0.0, now_s - set_s_) / left_s) : 1;
  progress.fraction = std::max(shown_, 1 - (1 - fraction_) * rest);
  progress.seconds_left = left_s * rest;
  return progress;
}

}  // namespace kerf
