// Smoothing of values on a lattice.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Smooths along each axis with a standard deviation of `sigma_vox` voxels, 0 to 1.4: one to four passes of the filter
/// (w, 1 - 2 w, w), each of which adds the variance 2 w. Beyond the lattice, the outermost values are assumed to
/// continue unchanged.
void Smooth(const std::array<int, 3>& size, const Vec3& sigma_vox, std::vector<float>& values);

/// Converts means over voxels to values at their centres, to second order: subtracts a 24th of the second difference
/// along each axis, times `fraction` (0 to 1).
void Sharpen(const std::array<int, 3>& size, const Vec3& fraction, std::vector<float>& values);

}  // namespace kerf
