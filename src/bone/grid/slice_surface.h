// Surface of a thin slice of a bone.
#pragma once

#include <vector>

#include "bone/grid/grids.h"

namespace kerf {

/// Makes the surface of the volume within `thickness_mm` / 2 of the plane where phi (voxels of voxel_mm, linear on the
/// tetrahedra of cell_volume.h) is negative. `blocks`: origins of the leaves of `phi` that the slice may reach; the
/// inside must have no tiles there.
///
/// Uses a lattice along the plane. Its spacing is half a voxel within the plane. Across the plane it has an odd number
/// of steps, chosen by the thickness, so that both faces lie midway between two layers. The faces are flat for any
/// thickness, and the number of triangles does not grow as the slice gets thinner.
TriangleMesh MakeSliceSurface(const openvdb::FloatTree& phi, double voxel_mm, const std::vector<openvdb::Coord>& blocks,
                              const CutPlane& plane, double thickness_mm);

}  // namespace kerf
