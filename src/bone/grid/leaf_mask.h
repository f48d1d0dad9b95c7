// Sets of voxels of a leaf.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace kerf {

/// A set of voxels of a leaf, one bit each: voxel (x, y, z) is bit 8 y + z of word x.
using LeafMask = std::array<std::uint64_t, 8>;

inline constexpr std::uint64_t kLowZ = 0x0101010101010101;  // the voxels of a word with z = 0
inline constexpr std::uint64_t kHighZ = kLowZ << 7;

/// Returns the voxels with a negative value.
inline LeafMask MaskOf(const float* values) {
  LeafMask mask{};
  for (std::size_t x = 0; x < 8; ++x) {
    std::uint64_t word = 0;
    for (std::size_t bit = 0; bit < 64; ++bit) word |= std::uint64_t{values[64 * x + bit] < 0} << bit;
    mask[x] = word;
  }
  return mask;
}

inline bool IsEmpty(const LeafMask& mask) {
  return std::all_of(mask.begin(), mask.end(), [](std::uint64_t word) { return word == 0; });
}

/// Returns a word together with the bits that share a face with it in the same layer.
inline std::uint64_t GrownInLayer(std::uint64_t w) {
  return w | w << 8 | w >> 8 | (w & ~kHighZ) << 1 | (w & ~kLowZ) >> 1;
}

/// Adds to `part`, which lies in `mask`, all of `mask` that is connected to it through faces.
inline void Flood(const LeafMask& mask, LeafMask& part) {
  const auto grow = [&](std::size_t x) {
    std::uint64_t w = part[x];
    if (x > 0) w |= part[x - 1];
    if (x < 7) w |= part[x + 1];
    w &= mask[x];
    for (std::uint64_t before = 0; before != w;) {
      before = w;
      w = GrownInLayer(w) & mask[x];
    }
    return std::exchange(part[x], w) != w;
  };
  for (bool grew = true; grew;) {
    grew = false;
    for (std::size_t x = 0; x < 8; ++x) grew = grow(x) || grew;
    for (std::size_t x = 8; x-- > 0;) grew = grow(x) || grew;
  }
}

/// Returns the voxels of the leaf beside this one, in direction `side` (-x, +x, -y, +y, -z, +z), that share a face with
/// a voxel of the mask.
inline LeafMask Across(const LeafMask& mask, std::size_t side) {
  LeafMask beside{};
  for (std::size_t x = 0; x < 8; ++x) {
    const std::uint64_t w = mask[x];
    switch (side) {
      case 0:
        beside[7] = mask[0];
        break;
      case 1:
        beside[0] = mask[7];
        break;
      case 2:
        beside[x] = w << 56;
        break;
      case 3:
        beside[x] = w >> 56;
        break;
      case 4:
        beside[x] = (w & kLowZ) << 7;
        break;
      default:
        beside[x] = (w & kHighZ) >> 7;
        break;
    }
  }
  return beside;
}

}  // namespace kerf
