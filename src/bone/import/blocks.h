// Coarser lattices for what needs no fine one: which bone is wanted, and where its cavities are.
#pragma once

#include <array>

#include "bone/import/volume.h"

namespace kerf {

/// Returns the voxels along each axis of the blocks on which a scan is isolated: 1 if its voxels are 0.35 mm or more in
/// the geometric mean, otherwise the largest count with which a block measures at most 0.7 mm.
std::array<int, 3> ChooseBlocks(const Volume& ct);

/// Returns a volume whose voxels are the means of blocks of `step` voxels, the last of which may be cut off by the edge
/// of the scan. A block is raised to `iso_hu` if as much of it is bone as a layer of one voxel takes, so that thin bone
/// is not lost.
Volume JoinBlocks(const Volume& ct, const std::array<int, 3>& step, double iso_hu);

}  // namespace kerf
