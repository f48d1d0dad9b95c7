// What was cut against what was planned.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "session/plan/fit_plane.h"
#include "session/plan/plan.h"

namespace kerf {

/// Of a planned plane.
struct PlaneResult {
  PlannedPlane planned;
  std::optional<FittedPlane> cut;  // none: no kerf was found near it
  double offset_mm = 0;            // of the kerf's middle from the planned plane, to the side of the normal positive
  double furthest_mm = 0;          // of the corners of the kerf's rectangle, at most
  PlaneAngles angles;              // of the kerf; depth: that of a stop that lies in the plane, else the kerf's own
  bool within_margin = false;      // furthest_mm is
};

/// Of a planned stop.
struct StopResult {
  DepthStop planned;
  std::optional<double> depth_mm;  // of the deepest bone that was lost; none: none was lost past the stop's point
  double over_mm = 0;              // depth_mm less the planned depth
};

struct Assessment {
  std::vector<PlaneResult> planes;
  std::vector<StopResult> stops;
  double before_mm3 = 0;
  double after_mm3 = 0;
  double removed_mm3 = 0;              // before less after
  std::optional<double> outside_mm3;   // of it, further from every plane than its margin and half the blade; none: no
                                       // planes
  std::optional<double> too_deep_mm3;  // of it, past a stop (of those whose plane it is nearest to); none: no stops
};

struct AssessOptions {
  double reach_mm = 5;        // so far from a plane its kerf is looked for
  double most_tilt_deg = 30;  // and so far turned
};

/// `blade_mm`: its thickness (of a ball: its diameter). Throws Error for a plan at fault, or bones with different
/// voxels.
Assessment AssessCut(const Plan& plan, const Bone& before, const Bone& after, double blade_mm,
                     const AssessOptions& options = {});
/// The thickness of a disc, the diameter of a ball.
double CalcBladeWidth(const Tool& tool);

/// The planes that were cut, for WritePlaneMarkups(): "NAME, as cut".
std::vector<PlaneMarkup> MakeCutMarkups(const Assessment& assessment);

}  // namespace kerf
