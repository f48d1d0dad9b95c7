// Round numbers along an axis.
#pragma once

#include <string>
#include <vector>

namespace kerf {

struct Tick {
  double value;
  std::string text;  // empty: a small tick without a number
};

/// Multiples of 1, 2 or 5 times a power of ten within [lower, upper], at most about `count` of them (at least 2).
std::vector<Tick> CalcLinearTicks(double lower, double upper, int count);
/// Decades within [lower, upper] with small ticks between; where there are fewer than two decades, 2 and 5 bear numbers
/// too. 0 < lower < upper.
std::vector<Tick> CalcLogTicks(double lower, double upper);

}  // namespace kerf
