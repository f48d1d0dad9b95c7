// Distance of voxels from the border of a mask.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Returns the distance to the border of `inside`, mm, positive inside. The border lies half a voxel outside the
/// centres of the outermost voxels. Euclidean, with the lattice's spacing (itk::SignedMaurerDistanceMapImageFilter);
/// accurate to about a third of a voxel.
std::vector<float> CalcDepth(const Volume& lattice, const std::vector<std::uint8_t>& inside);

}  // namespace kerf
