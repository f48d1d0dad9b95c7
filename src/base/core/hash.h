// Fast 64-bit mixing function for state hashes. Not for security.
#pragma once

#include <cstdint>

namespace kerf {

/// Bijection that maps close inputs to distant outputs (finaliser of SplitMix64, Steele et al. 2014). Tick-safe.
constexpr std::uint64_t MixHash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace kerf
