// Upper limits for surfaces, in one place for this folder (docs/reliability.md lists those of all folders).
#pragma once

#include <cstddef>

namespace kerf {

/// Bytes of a mesh file. The whole file is kept in memory while it is read.
inline constexpr std::size_t kMaxMeshFileBytes = std::size_t{4} << 30;
/// Triangles of a mesh: 12 bytes each, and up to three points of 24 bytes. The surface of a mandible at 0.1 mm has 4
/// million. Two bytes of an OBJ file can define one.
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 27;
/// Corners of a face that is not convex. The time to split it grows with their square: 0.5 s for this many.
inline constexpr std::size_t kMaxConcaveCorners = 10'000;

}  // namespace kerf
