#include "session/score/feed_meter.h"

#include <cmath>

namespace kerf {
namespace {

/// Fraction of the line at either end where the tool may start and stop.
constexpr double kLineEnds = 0.1;

}  // namespace

std::optional<double> FeedMeter::Take(double time_s, const Pose& X_WT) {
  const Vec3 stw = cut_.ToCut(X_WT.p_AB);
  const bool follows = stw.x >= kLineEnds * cut_.length_mm && stw.x <= (1 - kLineEnds) * cut_.length_mm &&
                       stw.y + cut_.below_mm >= kFeedDepthFraction * cut_.depth_mm;
  if (!follows) {
    places_.clear();
    return {};
  }
  places_.push_back({time_s, stw.x});
  // The last place that is old enough stays, so that a pause between poses leaves no gap.
  while (places_.size() > 1 && time_s - places_[1].time_s >= kFeedMean_s) places_.pop_front();
  const Place& from = places_.front();
  if (time_s - from.time_s < kFeedMean_s) return {};
  return std::abs(stw.x - from.s_mm) / (time_s - from.time_s);
}

}  // namespace kerf
