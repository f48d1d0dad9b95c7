#include "session/plan/moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/core/symmetric_eigen.h"

namespace kerf {

std::optional<MomentFit> FitMoments(const std::vector<WeightedPoint>& points, std::size_t min_points) {
  double sum = 0;
  Vec3 mean(0);
  for (const WeightedPoint& w : points) {
    sum += w.weight;
    mean += w.weight * w.p;
  }
  if (!(sum > 0) || points.size() < min_points) return {};
  mean /= sum;
  std::array<std::array<double, 3>, 3> scatter{};
  for (const WeightedPoint& w : points) {
    const Vec3 d = w.p - mean;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) scatter[i][j] += w.weight / sum * d[i] * d[j];
    }
  }
  const SymmetricEigen eigen = CalcSymmetricEigen(scatter);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return eigen.values[i] < eigen.values[j]; });
  const auto spread = [&](std::size_t i) { return std::sqrt(std::max(0.0, eigen.values[order[i]])); };
  return MomentFit{.p = mean,
                   .normal = glm::normalize(eigen.vectors[order[0]]),
                   .along = glm::normalize(eigen.vectors[order[2]]),
                   .thickness = spread(0),
                   .breadth = spread(1),
                   .length = spread(2)};
}

}  // namespace kerf
