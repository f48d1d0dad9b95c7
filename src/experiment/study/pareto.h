// Which of several settings no other beats.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

struct CostAndError {
  double cost = 0;
  double error = 0;
};

/// Indices of the points that no other point beats: none is as cheap and as exact, and better in one of both. By rising
/// cost; of equal points the first. What is not finite is beaten by all.
std::vector<std::size_t> FindParetoFront(const std::vector<CostAndError>& points);

}  // namespace kerf
