// The most that a .vdb may ask for, in one place for this folder (docs/reliability.md lists those of all). A mandible
// at 0.1 mm has a file of 40 MB and takes 240 MB of memory.
#pragma once

#include <cstdint>

namespace kerf {

inline constexpr std::uint64_t kMaxVdbFileBytes = std::uint64_t{8} << 30;
/// Nodes and voxels of all grids that are read, in memory.
inline constexpr std::uint64_t kMaxVdbMemoryBytes = std::uint64_t{8} << 30;
/// A name, or a value of metadata: the region table is the longest.
inline constexpr std::uint64_t kMaxVdbTextBytes = std::uint64_t{16} << 20;
/// Grids, and metadata entries of each and of the file.
inline constexpr std::uint32_t kMaxVdbEntries = 1000;
/// Where nodes may lie, in voxels from the origin.
inline constexpr std::int32_t kMaxVdbCoordinate_vox = 1 << 22;
/// Sides of the box that has all active voxels.
inline constexpr std::int32_t kMaxVdbSide_vox = 1 << 14;

}  // namespace kerf
