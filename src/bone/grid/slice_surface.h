// The surface of a thin slice of a bone.
#pragma once

#include <vector>

#include "bone/grid/grids.h"

namespace kerf {

/// The surface of what lies within `thickness_mm` / 2 of the plane, where phi (voxels of voxel_mm, linear on the
/// tetrahedra of cell_volume.h) is negative. `blocks`: origins of the leaves of `phi` that the slice may reach; the
/// inside must have no tiles there.
///
/// Taken on a lattice along the plane: half a voxel within it, and across it as many steps as the thickness wants, an
/// odd number of them, so that both faces lie midway between two layers. The faces are planes however thin the slice,
/// and the number of triangles doesn't grow when it gets thinner.
TriangleMesh MakeSliceSurface(const openvdb::FloatTree& phi, double voxel_mm, const std::vector<openvdb::Coord>& blocks,
                              const CutPlane& plane, double thickness_mm);

}  // namespace kerf
