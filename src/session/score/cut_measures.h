// Compares the cut with the wanted cut, using only the bone before and after.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bone/grid/removed.h"
#include "session/scene/exercise.h"
#include "session/score/columns.h"
#include "session/score/measures.h"

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

/// Deviation of the fitted plane from the wanted one.
struct PlaneError {
  double offset_mm = 0;  // signed, along WantedCut::across_W, at `p_W`
  double roll_deg = 0;   // about the line
  double yaw_deg = 0;    // about the direction into the bone
  double angle_deg = 0;  // between the normals, 0 to 90
};
PlaneError CalcPlaneError(const CutPlane& fitted, const WantedCut& cut, const Vec3& p_W);

/// Returns depths of the cut below the surface, for columns of the line itself; 0: no cut there.
std::vector<double> MeasureDepths(const Bone& before, const Bone& after, const WantedCut& cut,
                                  std::span<const CutColumn> columns, std::span<const RemovedCell> cells);

/// Sets the sheet's measures that need no recording: volumes, planes, depths. `cuts`: empty if nothing was planned. Of
/// several cuts, the sheet has the sums of the volumes, and the largest errors.
void MeasureCut(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts, ScoreSheet& sheet);

}  // namespace kerf
