// Surfaces and pieces of a bone.
#pragma once

#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// The zero level as a closed triangle surface (world, mm), outward-oriented. `adaptivity` 0 to 1: larger merges flat
/// parts.
TriangleMesh ExtractSurface(const Bone& bone, double adaptivity = 0);

/// What encloses less than this is a crumb and no piece, whatever the voxel: a cube of 0.1 mm.
inline constexpr double kSmallestPiece_mm3 = 1e-3;

/// The bone's separate pieces, largest first. Two voxels belong together when both are inside and share a face, so a
/// kerf at least one voxel wide separates. Volumes sum to the bone's. Pieces below `min_mm3` by their voxels, and those
/// whose surface encloses less than kSmallestPiece_mm3, are counted as dust and not returned.
struct Pieces {
  std::vector<Bone> pieces;
  std::size_t dust_count = 0;
  double dust_mm3 = 0;
};
Pieces SplitPieces(const Bone& bone, double min_mm3 = 0);

}  // namespace kerf
