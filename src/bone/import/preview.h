// Coarse bone of a CT, to look at while the import goes on.
#pragma once

#include <functional>

#include "bone/import/volume.h"
#include "kerf/bone.h"

namespace kerf {

/// Makes a bone of everything above `iso_hu` in the CT: nothing is isolated or filled, there is one region, and no CT
/// numbers are kept. The surface of bone that is thicker than two voxels lies within about half a voxel of that of an
/// import. `voxel_mm`: edge of a voxel, also used to sample the CT if its own voxels are smaller. `progress`, which is
/// optional, is called with values from 0 to 1 and may throw Cancelled. Throws kerf::Error if nothing is above
/// `iso_hu` or memory is insufficient.
Bone MakePreview(const Volume& ct, double iso_hu, double voxel_mm, const std::function<void(double)>& progress = {});

}  // namespace kerf
