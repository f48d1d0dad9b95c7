// What was cut, held against what was wanted: from the bone before and after alone.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "bone/grid/removed.h"
#include "session/scene/exercise.h"
#include "session/score/columns.h"
#include "session/score/measures.h"

namespace kerf {

/// The middle plane of what was removed.
struct MiddlePlane {
  CutPlane plane;           // through the removed volume's centre
  double extent_mm = 0;     // root mean square, along its shorter direction
  double thickness_mm = 0;  // root mean square, across
};

/// The plane from which what was removed has the least mean square distance, by volume; then that half-way between the
/// kerf's walls, at places a voxel apart, without those by the surface and by the kerf's bottom. None where so little
/// was removed, or in such a shape, that it has no plane. `cells`: FindRemoved() of the two. Error on a plane kerf of
/// two voxels' width and 2 mm depth, in any direction: below 0.2 mm and 0.4 degrees (tests/session/score).
std::optional<MiddlePlane> FitMiddlePlane(const Bone& before, const Bone& after, std::span<const RemovedCell> cells);

/// Of the fitted plane against the wanted one.
struct PlaneError {
  double offset_mm = 0;  // signed, along WantedCut::across_W, at `p_W`
  double roll_deg = 0;   // about the line
  double yaw_deg = 0;    // about the way into the bone
  double angle_deg = 0;  // between the normals, 0 to 90
};
PlaneError CalcPlaneError(const CutPlane& fitted, const WantedCut& cut, const Vec3& p_W);

/// Depths below the surface that was cut to, for columns of the line itself; 0: nothing was cut there.
std::vector<double> MeasureDepths(const Bone& before, const Bone& after, const WantedCut& cut,
                                  std::span<const CutColumn> columns, std::span<const RemovedCell> cells);

/// Fills the sheet's measures that need no recording: volumes, planes, depths. `cut`: none when nothing was planned.
void MeasureCut(const Bone& before, const Bone& after, const std::optional<WantedCut>& cut, ScoreSheet& sheet);

}  // namespace kerf
