#include "view/plot/ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace kerf {
namespace {

// A value that is outside the range only because of rounding counts as inside; this is the relative tolerance.
constexpr double kRelativeTolerance = 1e-9;

}  // namespace

std::vector<Tick> CalcLinearTicks(double lower, double upper, int count) {
  const double wanted = (upper - lower) / std::max(count, 2);
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= wanted * (1 - kRelativeTolerance)) step = factor * power;
  }
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + kRelativeTolerance)));
  const double largest = std::max(std::abs(lower), std::abs(upper));
  std::vector<Tick> ticks;
  const double hair = kRelativeTolerance * (upper - lower);
  for (double i = std::ceil((lower - hair) / step); i * step <= upper + hair; ++i) {
    const double value = i * step;
    const bool plain = largest < 1e6 && decimals <= 6;
    ticks.push_back({value, i == 0  ? "0"
                            : plain ? fmt::format("{:.{}f}", value, decimals)
                                    : fmt::format("{:g}", value)});
  }
  return ticks;
}

std::vector<Tick> CalcLogTicks(double lower, double upper) {
  // The fewer decades, the more digits get numbers.
  const double decades = std::log10(upper / lower);
  const std::string_view digits = decades < 1.3 ? "123457" : decades < 2.5 ? "125" : "1";
  std::vector<Tick> ticks;
  for (int decade = static_cast<int>(std::floor(std::log10(lower))); decade <= std::ceil(std::log10(upper)); ++decade) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, decade);
      if (value < lower * (1 - kRelativeTolerance) || value > upper * (1 + kRelativeTolerance)) continue;
      const bool numbered = digits.find(static_cast<char>('0' + digit)) != std::string_view::npos;
      ticks.push_back({value, numbered ? fmt::format("{:g}", value) : ""});
    }
  }
  return ticks;
}

}  // namespace kerf
