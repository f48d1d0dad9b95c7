// A hand's way that was recorded, as a smooth function of time.
#pragma once

#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "session/scene/scene.h"

namespace kerf {

/// Between the rows of a file of poses (scene/path_csv.h): positions and quaternions by cubics through them
/// (Catmull-Rom), whose speeds go on from row to row. Immutable.
class HandPath {
 public:
  /// Throws Error as ParsePathCsv().
  HandPath(const std::string& csv, const std::string& file);
  double duration_s() const { return rows_.back().time_s; }
  /// Clamped to the rows.
  Pose CalcPose(double t_s) const;

 private:
  std::vector<TimedPose> rows_;  // the first at 0
};

/// volumes/free_form_hand.csv and free_form_tool.csv, built in: of the handle where a hand holds it, and of the tool
/// itself.
HandPath FreeFormHandPath();
HandPath FreeFormToolPath();

}  // namespace kerf
