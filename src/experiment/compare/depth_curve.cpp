#include "experiment/compare/depth_curve.h"

#include <limits>

namespace kerf {
namespace {

/// Smaller differences of depth, mm, are due to rounding in a path that returns to an earlier depth.
constexpr double kSameDepth_mm = 1e-9;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Fills the bins between `before` and `after`, which both have values.
void Interpolate(std::vector<double>& values, std::size_t before, std::size_t after) {
  for (std::size_t i = before + 1; i < after; ++i) {
    const double t = static_cast<double>(i - before) / static_cast<double>(after - before);
    values[i] = values[before] + t * (values[after] - values[before]);
  }
}

}  // namespace

std::vector<DepthSample> TakeAdvance(const std::vector<DepthSample>& samples) {
  std::vector<DepthSample> advance;
  double deepest_mm = -std::numeric_limits<double>::infinity();
  for (const DepthSample& sample : samples) {
    if (!(sample.depth_mm > deepest_mm + kSameDepth_mm)) continue;
    deepest_mm = sample.depth_mm;
    advance.push_back(sample);
  }
  return advance;
}

DepthCurve CalcDepthCurve(const std::vector<DepthSample>& samples, const DepthGrid& grid) {
  DepthCurve curve;
  const auto columns = {&curve.force_N, &curve.magnitude_N, &curve.thrust_N, &curve.teeth};
  for (std::vector<double>* column : columns) column->assign(grid.count, 0);
  std::vector<std::size_t> ticks(grid.count, 0);
  for (const DepthSample& sample : samples) {
    if (!(sample.depth_mm >= 0)) continue;
    const double at = sample.depth_mm / grid.step_mm;
    if (!(at < static_cast<double>(grid.count))) continue;
    const auto bin = static_cast<std::size_t>(at);
    ++ticks[bin];
    curve.force_N[bin] += sample.force_N;
    curve.magnitude_N[bin] += sample.magnitude_N;
    curve.thrust_N[bin] += sample.thrust_N;
    curve.teeth[bin] += sample.teeth;
  }
  std::size_t before = grid.count;  // the last bin with ticks; none so far
  for (std::size_t i = 0; i < grid.count; ++i) {
    for (std::vector<double>* column : columns) {
      (*column)[i] = ticks[i] > 0 ? (*column)[i] / static_cast<double>(ticks[i]) : kNone;
    }
    if (ticks[i] == 0) continue;
    if (before < grid.count && i > before + 1) {
      for (std::vector<double>* column : columns) Interpolate(*column, before, i);
      curve.interpolated += i - before - 1;
    }
    before = i;
    curve.reach = i + 1;
  }
  return curve;
}

}  // namespace kerf
