// Deviation of the plane that was cut from the wanted one.
#pragma once

#include <optional>
#include <vector>

#include "bone/grid/removed.h"
#include "session/scene/exercise.h"
#include "session/score/measures.h"

namespace kerf {

/// Deviation of the fitted plane from the wanted one.
struct PlaneError {
  double offset_mm = 0;  // signed, along WantedCut::across_W, at `p_W`
  double roll_deg = 0;   // about the line
  bool has_roll = true;  // false: it is not known, and `angle_deg` is that of the yaw
  double yaw_deg = 0;    // about the direction into the bone
  double angle_deg = 0;  // between the normals, 0 to 90
};
PlaneError CalcPlaneError(const CutPlane& fitted, const WantedCut& cut, const Vec3& p_W);

/// Returns the deviation of the plane that fits what was removed for one cut; none if it has no plane. `lean_deg`: of a
/// solid of revolution, the roll of its axis; none: not known.
std::optional<PlaneError> FindPlaneError(const Bone& before, const Bone& after, const WantedCut& cut,
                                         const std::vector<RemovedCell>& cells, const Vec3& middle_W,
                                         const std::optional<double>& lean_deg);

/// Sets the largest offset and the largest angle; none if the plane of a cut is unknown.
void SetPlaneErrors(const std::vector<std::optional<PlaneError>>& errors, ScoreSheet& sheet);

}  // namespace kerf
