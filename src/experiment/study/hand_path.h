// A recorded motion of a hand as a smooth function of time.
#pragma once

#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "session/scene/scene.h"

namespace kerf {

/// Interpolates between the rows of a file of poses (scene/path_csv.h). Positions and quaternions are cubics
/// (Catmull-Rom) with continuous velocities. Immutable.
class HandPath {
 public:
  /// Throws Error as ParsePathCsv() does.
  HandPath(const std::string& csv, const std::string& file);
  double duration_s() const { return rows_.back().time_s; }
  /// `t_s` is clamped to the rows.
  Pose CalcPose(double t_s) const;

 private:
  std::vector<TimedPose> rows_;  // the first at 0
};

/// volumes/free_form_hand.csv and free_form_tool.csv, built in: the motion of the handle for a tool coupled to
/// it, and of the tool itself.
HandPath FreeFormHandPath();
HandPath FreeFormToolPath();

}  // namespace kerf
