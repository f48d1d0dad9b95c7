// Smoothing values on a lattice.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Smooths along each axis with a standard deviation of `sigma_vox` voxels, 0 to 1.4: one to four passes of the filter
/// (w, 1 - 2 w, w), each of which adds the variance 2 w. Values beyond the lattice are those at its border.
void Smooth(const std::array<int, 3>& size, const Vec3& sigma_vox, std::vector<float>& values);

/// From means over voxels to values at their centres, to second order: takes off a 24th of the second difference along
/// each axis, times `share` (0 to 1).
void Sharpen(const std::array<int, 3>& size, const Vec3& share, std::vector<float>& values);

}  // namespace kerf
