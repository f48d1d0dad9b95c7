// Values in the bytes of OpenIGTLink.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "kerf/geometry.h"

namespace kerf {

/// Reads a value in network order. The caller checks the length.
template <std::unsigned_integral T>
T ReadBig(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value << 8 | bytes[at + i]);
  return value;
}

inline double ReadBigFloat(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<double>(std::bit_cast<float>(ReadBig<std::uint32_t>(bytes, at)));
}

/// The rotation between LPS and RAS, in both directions.
inline Vec3 TurnRas(const Vec3& v) {
  return {-v.x, -v.y, v.z};
}

}  // namespace kerf
