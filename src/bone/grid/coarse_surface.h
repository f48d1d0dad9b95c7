// A bone's surface with fewer triangles, for pictures.
#pragma once

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

/// Like ExtractSurface(), but from every second voxel, with about a quarter of the triangles. Their corners are moved
/// onto the full surface where it is not folded. What is thinner than two voxels may be missing; a bone that has been
/// cut therefore has its full surface.
TriangleMesh ExtractCoarseSurface(const Bone& bone);

}  // namespace kerf
