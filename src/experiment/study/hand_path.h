// A recorded motion of a hand as a smooth function of time.
#pragma once

#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "session/scene/scene.h"

namespace kerf {

/// Interpolates between the rows of a file of poses (scene/path_csv.h). Positions and quaternions are cubics
/// (Catmull-Rom) with continuous velocities. The object is immutable.
class HandPath {
 public:
  /// Throws Error as ParsePathCsv() does.
  HandPath(const std::string& csv, const std::string& file);
  double duration_s() const { return rows_.back().time_s; }
  /// `t_s` is clamped to the times of the rows.
  Pose CalcPose(double t_s) const;

 private:
  std::vector<TimedPose> rows_;  // the first one has time 0
};

/// The built-in copies of volumes/free_form_hand.csv and free_form_tool.csv: the motion of the handle for a tool that
/// is coupled to it, and the motion of the tool itself.
HandPath FreeFormHandPath();
HandPath FreeFormToolPath();

}  // namespace kerf
