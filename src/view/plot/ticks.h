// Round numbers along an axis.
#pragma once

#include <string>
#include <vector>

namespace kerf {

struct Tick {
  double value;
  std::string text;  // empty: small tick without a number
};

/// Returns the multiples of 1, 2 or 5 times a power of ten within [lower, upper], at most about `count` (at least 2).
std::vector<Tick> CalcLinearTicks(double lower, double upper, int count);
/// Returns the decades within [lower, upper] with small ticks between them. With fewer than 2.5 decades, 2 and 5 also
/// get numbers; with fewer than 1.3, also 3, 4 and 7. Requires 0 < lower < upper.
std::vector<Tick> CalcLogTicks(double lower, double upper);

}  // namespace kerf
