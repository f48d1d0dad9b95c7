// Compares a cut with its plan.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "session/plan/fit_plane.h"
#include "session/plan/plan.h"

namespace kerf {

/// Result for a planned plane.
struct PlaneResult {
  PlannedPlane planned;
  std::optional<FittedPlane> cut;  // none: no kerf was found near it,
  NoKerf no_kerf;                  // for this reason
  double reach_mm = 0;             // largest distance from the plane at which it was searched for
  double offset_mm = 0;            // of the kerf's centre from the planned plane, positive on the side of the normal
  double furthest_mm = 0;          // signed distance of the kerf rectangle's furthest corner from that plane
  PlaneAngles angles;              // angles of the kerf; depth direction: of a stop in the plane, otherwise of the kerf
  bool within_margin = false;      // true if |furthest_mm| is at most the margin
};

/// Result for a planned stop.
struct StopResult {
  DepthStop planned;
  std::optional<double> depth_mm;  // of the deepest removed bone; none: no bone was removed beyond the stop's point
  double over_mm = 0;              // depth_mm minus the planned depth
};

struct Assessment {
  std::vector<PlaneResult> planes;
  std::vector<StopResult> stops;
  double before_mm3 = 0;
  double after_mm3 = 0;
  double removed_mm3 = 0;              // before minus after
  std::optional<double> outside_mm3;   // part further from every plane than its margin + half the blade's width
  std::optional<double> too_deep_mm3;  // part beyond a stop of its nearest plane; none: no stops
};

struct AssessOptions {
  double reach_mm = 5;
  double max_tilt_deg = 30;  // maximum angle between a plane and its kerf
};

template <typename V>
void Describe(AssessOptions& p, V&& visit) {
  visit("reach_mm", p.reach_mm, Range{0.1, 100}, "largest distance from a plane at which its kerf is searched for");
}

/// Compares the bone before and after the cut with the plan. `blade_mm`: CalcCutWidth() of the tool.
/// Throws kerf::Error for an invalid plan or for bones with different voxel sizes.
Assessment AssessCut(const Plan& plan, const Bone& before, const Bone& after, double blade_mm,
                     const AssessOptions& options = {});

/// Returns why no kerf was found near a plane, such as "no bone was removed within 5 mm of it".
std::string DescribeNoKerf(const PlaneResult& result);

/// Returns the fitted planes, each named "NAME, as cut", for WritePlaneMarkups().
std::vector<PlaneMarkup> MakeCutMarkups(const Assessment& assessment);

}  // namespace kerf
