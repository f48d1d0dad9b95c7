#include "view/plot/plot_scale.h"

#include <fmt/format.h>

#include "kerf/error.h"

namespace kerf {

PlotScale MakePlotScale(const PlotAxis& axis, const PlotExtent& data, bool tight, double headroom, const char* name) {
  double lower = axis.lower.value_or(data.lower);
  double upper = axis.upper.value_or(data.upper);
  if (!std::isfinite(lower) || !std::isfinite(upper)) {
    throw Error(fmt::format("a plot needs at least one finite{} value along {}", axis.log ? " positive" : "", name));
  }
  if (axis.log) {
    if (!(lower > 0)) throw Error(fmt::format("a logarithmic axis can't begin at {} along {}", lower, name));
    if (!axis.lower && !tight) lower /= 1.3;
    if (!axis.upper && !tight) upper *= 1.3;
    if (!(upper > lower * 1.0001)) lower /= 2, upper *= 2;
    return {lower, upper, true};
  }
  // An axis whose data begin near zero begins at zero.
  if (!axis.lower && !tight && lower > 0 && lower < 0.5 * upper) lower = 0;
  const double span = upper - lower;
  if (!axis.upper && !tight) upper += headroom * span;
  if (!axis.lower && !tight && lower < 0) lower -= 0.08 * span;
  if (!(upper - lower > 1e-9 * std::max(std::abs(lower), std::abs(upper)))) {
    const double room = lower == 0 ? 1 : 0.5 * std::abs(lower);
    lower -= room, upper += room;
  }
  return {lower, upper, false};
}

}  // namespace kerf
