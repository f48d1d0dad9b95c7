// Surface and pieces of a bone.
#pragma once

#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Returns the zero level as a closed triangle surface (world, mm), outward-oriented. `adaptivity`: 0 to 1; larger
/// values merge flat parts.
TriangleMesh ExtractSurface(const Bone& bone, double adaptivity = 0);

/// Pieces that enclose less than this are crumbs, whatever the voxel size; it is the volume of a cube with an edge of
/// 0.1 mm.
inline constexpr double kSmallestPiece_mm3 = 1e-3;

/// Separate pieces of a bone, largest first. Two voxels are connected if both are inside and share a face, so a kerf at
/// least one voxel wide separates them. The pieces' volumes and the dust add up to the bone's volume. Pieces whose
/// voxels have a total volume of less than `min_mm3`, and those whose surface encloses less than kSmallestPiece_mm3,
/// are counted as dust and not returned.
struct Pieces {
  std::vector<Bone> pieces;
  std::size_t dust_count = 0;
  double dust_mm3 = 0;
};
Pieces SplitPieces(const Bone& bone, double min_mm3 = 0);

}  // namespace kerf
