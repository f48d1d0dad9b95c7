// Feed along the line of an exercise: the same while it is cut and in the score.
#pragma once

#include <deque>
#include <optional>

#include "session/scene/exercise.h"

namespace kerf {

/// Time over which the feed is averaged.
inline constexpr double kFeedMean_s = 0.5;
/// Fraction of the wanted depth from which on the tool follows the line rather than going down.
inline constexpr double kFeedDepthFraction = 0.5;

/// Measures the feed of a tool along the line.
class FeedMeter {
 public:
  explicit FeedMeter(const WantedCut& cut) : cut_(cut) {}
  /// Takes the next pose. Returns the mean feed along the line over the last kFeedMean_s, mm/s, in either direction.
  /// None if the tool was less than kFeedDepthFraction of the wanted depth deep, or in the first or last tenth of the
  /// line, where it starts and stops.
  std::optional<double> Take(double time_s, const Pose& X_WT);

 private:
  struct Place {
    double time_s;
    double s_mm;
  };
  WantedCut cut_;
  std::deque<Place> places_;  // of the last kFeedMean_s
};

}  // namespace kerf
