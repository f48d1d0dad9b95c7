// Upper limits for .vdb files, in one place for this folder (docs/reliability.md lists those of all folders). A
// mandible at 0.1 mm has a file of 40 MB and needs 240 MB of memory.
#pragma once

#include <cstdint>

namespace kerf {

inline constexpr std::uint64_t kMaxVdbFileBytes = std::uint64_t{8} << 30;
/// Memory for the nodes and voxels of all grids that are read.
inline constexpr std::uint64_t kMaxVdbMemoryBytes = std::uint64_t{8} << 30;
/// Length of a name or of a metadata value; the region table is the longest.
inline constexpr std::uint64_t kMaxVdbTextBytes = std::uint64_t{16} << 20;
/// Number of grids, and number of metadata entries of each grid and of the file.
inline constexpr std::uint32_t kMaxVdbEntries = 1000;
/// Greatest distance of a node from the origin along each axis, voxels.
inline constexpr std::int32_t kMaxVdbCoordinate_vox = 1 << 22;
/// Sides, in voxels, of the box that contains all active voxels.
inline constexpr std::int32_t kMaxVdbSide_vox = 1 << 14;

}  // namespace kerf
