// Cavities of bone, such as marrow spaces and canals: voxels within the bone whose HU are not those of bone.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

struct FillOptions {
  double reach_mm = 15;    // search radius for bone
  double enclosed = 0.88;  // minimum fraction of the directions in which bone must be found; the rest allows for
                           // foramina and gaps in thin cortex
};

/// Returns 1 for each voxel that is not bone but enclosed by it: no path leads out, or bone is found in at least a
/// fraction `enclosed` of 60 directions distributed evenly over the sphere. A gap between teeth or a notch is open on
/// one side, and stays open. `progress`, which is optional, is called with values from 0 to 1, from the calling thread,
/// and may throw Cancelled.
std::vector<std::uint8_t> FindCavities(const Volume& lattice, const std::vector<std::uint8_t>& bone,
                                       const FillOptions& options, const std::function<void(double)>& progress = {});

}  // namespace kerf
