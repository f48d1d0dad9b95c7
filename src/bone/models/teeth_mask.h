// A set of teeth of one half of the mandible.
#pragma once

#include <cstdint>

namespace kerf {

/// Bit n: the n-th tooth from the midline.
using TeethMask = std::uint8_t;
inline constexpr TeethMask kAllTeeth = 0xff;

}  // namespace kerf
