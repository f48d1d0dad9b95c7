// Distances near the zero level of a field of which only the signs and the zero level count.
#pragma once

#include <openvdb/openvdb.h>

namespace kerf {

/// Sets the active voxels of the leaves to their distances from the zero level, with the field's signs, and the others
/// to +-FLT_MAX. Voxels beside a change of sign get the distance to the plane through the points where the field,
/// linear between neighbouring voxels, is zero; the others are solved from these by the fast sweeping method (Zhao
/// 2005), one sweep in each of the eight diagonal directions. The values have the same bits as those of
/// openvdb::tools::sdfToSdf(field, 0, 1), which takes several times as long, and are the same for any number of
/// threads. Tiles are not changed; they must be inactive. Returns false, with the field unchanged, if no active voxel
/// is beside a change of sign. Allocates 2 kB a leaf.
bool SolveDistances(openvdb::FloatTree& field, float voxel_mm);

/// Deactivates voxels that are farther from a change of sign than `voxels` steps to one of the 18 nearest neighbours.
void KeepNearSurface(openvdb::FloatTree& field, int voxels);

}  // namespace kerf
