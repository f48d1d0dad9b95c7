// A bone as others see it: its surface, its separate pieces, and the voxels of its level set.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// Returns the zero level as a closed triangle surface (world, mm), outward-oriented. `adaptivity`: 0 to 1; larger
/// values merge flat parts.
TriangleMesh ExtractSurface(const Bone& bone, double adaptivity = 0);

/// Pieces that enclose less than this are crumbs, whatever the voxel size; it is the volume of a cube with an edge of
/// 0.1 mm.
inline constexpr double kSmallestPiece_mm3 = 1e-3;

/// What SplitPieces() counts; all volumes are those of Bone::CalcVolume().
struct PieceCounts {
  std::size_t dust_count = 0;
  double dust_mm3 = 0;
  std::optional<std::size_t> old_dust_count;  // of these, crumbs in crumbs of the bone before the cut, if it is known
  double old_dust_mm3 = 0;
  /// Pieces and other crumbs no voxel of which is deeper than half a voxel, as in walls thinner than about a voxel.
  std::size_t thin_count = 0;
  double thin_mm3 = 0;
};

/// Separate pieces of a bone, largest first. Two voxels are connected if both are inside and share a face, so a kerf at
/// least one voxel wide separates them. Their sum is the bone within the bounds of docs/physics.md. Those that enclose
/// less than `min_mm3` or kSmallestPiece_mm3 are crumbs, which are counted as dust.
struct Pieces : PieceCounts {
  std::vector<Bone> pieces;
  Bone dust;  // all of it; empty() if there is none
};
/// `before`: the bone before it was cut; null: not known.
Pieces SplitPieces(const Bone& bone, double min_mm3 = 0, const Bone* before = nullptr);

/// A leaf of a bone's level set: 8 x 8 x 8 voxels near the surface.
struct BoneLeaf {
  std::array<int, 3> first_voxel;  // index of the voxel with the lowest coordinates; its centre is at index * voxel_mm
  std::span<const float, 512> phi_mm;  // the bone's own memory; voxel (x, y, z) of the leaf is at 64 x + 8 y + z
};

/// Returns all leaves of the level set, without copying a voxel. They are valid until the bone is changed, moved or
/// destroyed.
std::vector<BoneLeaf> ListLeaves(const Bone& bone);

}  // namespace kerf
