// Fits a plane to removed bone.
#pragma once

#include <optional>
#include <span>

#include "bone/grid/removed.h"

namespace kerf {

/// Mid-plane of the removed bone.
struct MidPlane {
  CutPlane plane;           // through the centre of the removed volume
  double extent_mm = 0;     // root mean square extent in the plane, along the shorter direction
  double thickness_mm = 0;  // root mean square extent across the plane
};

/// Fits the mid-plane. The fit starts from the plane with the least mean square distance from the removed volume. The
/// result is fitted to points half-way between the kerf's walls, a voxel apart, without those near the surface and the
/// kerf's bottom. A smaller cut apart, beside that plane, does not count. Returns none if too little was
/// removed, or if its shape has no plane. `cells`: result of FindRemoved() for the two bones. Error for a flat kerf two
/// voxels wide and 2 mm deep, in any direction: below 0.2 mm and 0.4 degrees (tests/session/score).
std::optional<MidPlane> FitMidPlane(const Bone& before, const Bone& after, std::span<const RemovedCell> cells);

}  // namespace kerf
