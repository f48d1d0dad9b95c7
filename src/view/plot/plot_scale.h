// Axis of a plot: maps data to a fraction of the axes' box, 0 to 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "view/plot/plot.h"
#include "view/plot/ticks.h"

namespace kerf {

class PlotScale {
 public:
  PlotScale() = default;
  PlotScale(double lower, double upper, bool log) : lower_(lower), upper_(upper), log_(log) {}
  double lower() const { return lower_; }
  double upper() const { return upper_; }
  bool log() const { return log_; }
  bool CanShow(double value) const { return std::isfinite(value) && (!log_ || value > 0); }
  double operator()(double value) const {
    if (log_) return std::log(value / lower_) / std::log(upper_ / lower_);
    return (value - lower_) / (upper_ - lower_);
  }
  std::vector<Tick> MakeTicks(int count) const {
    return log_ ? CalcLogTicks(lower_, upper_) : CalcLinearTicks(lower_, upper_, count);
  }

 private:
  double lower_ = 0;
  double upper_ = 1;
  bool log_ = false;
};

struct PlotExtent {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();
  void Include(double value) {
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  }
};

/// `tight`: the axis ends where the data end. `headroom`: fraction of the range that stays free above the data. Throws
/// Error, with the axis's `name` in the message, if there is no range.
PlotScale MakePlotScale(const PlotAxis& axis, const PlotExtent& data, bool tight, double headroom, const char* name);

}  // namespace kerf
