// The most that a surface may ask for, in one place for this folder (docs/reliability.md lists those of all).
#pragma once

#include <cstddef>

namespace kerf {

/// Held in memory as a whole while it is read.
inline constexpr std::size_t kMaxMeshFileBytes = std::size_t{4} << 30;
/// Of a mesh: 12 bytes each, and up to three points of 24. A mandible's surface at 0.1 mm has 4 million. Two bytes of
/// an OBJ can make one.
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 27;

}  // namespace kerf
