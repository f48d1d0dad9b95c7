// Smoothing values on a lattice.
#pragma once

#include <array>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Smooths along each axis with a standard deviation of `sigma_vox` voxels, 0 to 1.4: one to four passes of the filter
/// (w, 1 - 2 w, w), each of which adds the variance 2 w. Values beyond the lattice are those at its border.
void Smooth(const std::array<int, 3>& size, const Vec3& sigma_vox, std::vector<float>& values);

}  // namespace kerf
