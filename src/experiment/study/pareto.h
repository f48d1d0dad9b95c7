// Pareto front of cost and error.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

struct CostAndError {
  double cost = 0;
  double error = 0;
};

/// Returns the indices of the points that no other point dominates, i.e. for which no other point is at least as cheap
/// and as accurate and better in one of the two. Sorted by ascending cost; of several equal points, only the first is
/// returned. Points that are not finite are dominated by all others.
std::vector<std::size_t> FindParetoFront(const std::vector<CostAndError>& points);

}  // namespace kerf
