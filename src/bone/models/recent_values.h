// Values of functions of a point in a plane that a thread computed last.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "bone/models/shapes.h"

namespace kerf {

/// Returns a number that no other function has, for RecentValues.
std::uint64_t MakeFunctionId();

/// Keeps the last values, because a grid is evaluated leaf by leaf, and all points of a line across the plane have the
/// same place in it. Not thread-safe: each thread needs an object of its own.
template <typename Value>
class RecentValues {
 public:
  /// Returns the value that is kept for the function and the point; that of make() if there is none.
  template <typename Make>
  Value& Get(std::uint64_t function_id, const Vec2& p, Make&& make) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(p.x) * 0x9e3779b97f4a7c15u ^
                               std::bit_cast<std::uint64_t>(p.y) * 0xc2b2ae3d27d4eb4fu;
    Kept& kept = kept_[static_cast<std::size_t>((bits ^ bits >> 29) * 0x9e3779b97f4a7c15u >> 54)];
    if (kept.function_id != function_id || kept.p != p) kept = {function_id, p, make()};
    return kept.value;
  }

 private:
  struct Kept {
    std::uint64_t function_id = 0;
    Vec2 p{0};
    Value value{};
  };
  std::array<Kept, 1024> kept_;
};

}  // namespace kerf
