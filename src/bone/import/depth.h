// Distance of voxels from the border of a mask.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// mm to the border of `inside` (which lies half a voxel outside its outermost voxels), positive inside. Euclidean,
/// with the lattice's spacing (itk::SignedMaurerDistanceMapImageFilter); exact to about a third of a voxel.
std::vector<float> CalcDepth(const Volume& lattice, const std::vector<std::uint8_t>& inside);

}  // namespace kerf
