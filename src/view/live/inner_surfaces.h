// Structures inside the bone that are shown when it is translucent: the nerve canal and the roots of the teeth.
#pragma once

#include "kerf/bone.h"
#include "kerf/geometry.h"

namespace kerf {

struct InnerSurfaces {
  TriangleMesh canal_W;
  TriangleMesh teeth_W;
};

/// Extracts the surfaces from the region grid and smooths the grid's steps; accurate to a voxel. A mesh is empty if the
/// bone has no such region.
InnerSurfaces MakeInnerSurfaces(const Bone& bone);

}  // namespace kerf
