#include "experiment/study/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {

std::vector<std::size_t> FindParetoFront(const std::vector<CostAndError>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error)) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (points[a].cost != points[b].cost) return points[a].cost < points[b].cost;
    return points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (points[i].error >= least) continue;
    least = points[i].error;
    front.push_back(i);
  }
  return front;
}

}  // namespace kerf
