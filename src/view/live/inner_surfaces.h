// What lies within the bone and is shown when it is translucent: the nerve's canal and the roots of the teeth.
#pragma once

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

struct InnerSurfaces {
  TriangleMesh canal_W;
  TriangleMesh teeth_W;
};

/// From the region grid, its steps smoothed away: true to a voxel. Empty where the bone has no such region.
InnerSurfaces MakeInnerSurfaces(const Bone& bone);

}  // namespace kerf
