#include "experiment/bench/slope.h"

#include <algorithm>
#include <cmath>

#include "base/core/hash.h"

namespace kerf {
namespace {

constexpr int kDraws = 2000;
constexpr std::size_t kMinPaths = 3;  // with fewer, nothing can be inferred about other paths

/// Contribution of a path to the sums of the least-squares fit.
struct Sums {
  double xx = 0;
  double xy = 0;
};

}  // namespace

std::optional<Slope> FitSlope(const std::vector<SlopePath>& paths) {
  std::vector<Sums> all;
  Slope fit;
  Sums total;
  for (const SlopePath& path : paths) {
    const std::size_t n = path.numbers.size();
    double mean_x = 0;
    double mean_y = 0;
    for (std::size_t i = 0; i < n; ++i) {
      mean_x += std::log(path.numbers[i]) / static_cast<double>(n);
      mean_y += std::log(path.errors[i]) / static_cast<double>(n);
    }
    Sums sums;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = std::log(path.numbers[i]) - mean_x;
      sums.xx += x * x;
      sums.xy += x * (std::log(path.errors[i]) - mean_y);
    }
    if (!(sums.xx > 1e-12)) continue;
    all.push_back(sums);
    total.xx += sums.xx;
    total.xy += sums.xy;
    fit.points += n;
  }
  if (all.empty()) return std::nullopt;
  fit.paths = all.size();
  fit.slope = total.xy / total.xx;
  if (all.size() < kMinPaths) return fit;
  std::vector<double> slopes;
  std::uint64_t counter = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Sums drawn;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Sums& sums = all[static_cast<std::size_t>(MixHash(++counter) % all.size())];
      drawn.xx += sums.xx;
      drawn.xy += sums.xy;
    }
    slopes.push_back(drawn.xy / drawn.xx);
  }
  std::sort(slopes.begin(), slopes.end());
  fit.interval = {slopes[static_cast<std::size_t>(0.025 * kDraws)],
                  slopes[static_cast<std::size_t>(0.975 * kDraws) - 1]};
  return fit;
}

}  // namespace kerf
