// What holds a tool and does not cut: the hub of a disc, the shank of a bur, the neck and the handle of the handpiece.
#pragma once

#include <vector>

#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Circle in the x-y plane of a frame S.
struct HolderSection {
  Vec3 middle_T{0};
  Quat R_TS{1, 0, 0, 0};
  double radius_mm = 1;
};

/// Solid around an axis. Between two neighbouring sections it is convex: a cylinder or a cone.
struct HolderBody {
  enum class Part { kHub, kShank, kHandpiece };
  Part part = Part::kHandpiece;
  std::vector<HolderSection> sections;  // at least 2, from the tool to the hand
};

/// Returns neck and handle. The neck begins at the end of the spindle (disc) or shank (ball) and follows the z axis;
/// the handle leads through the grip and ends 25 mm behind it. A tool whose grip is not on the side of the spindle has
/// a straight handle. A blade with a stroke has its handpiece behind it; the handpiece does not move with the stroke.
HolderBody MakeHandpiece(const Tool& tool);

/// Returns all that holds a tool: of a disc also the two flanges of its hub and the end of its spindle, of a bur or
/// drill its shank. The shapes and proportions are assumptions. A guard is left out: it is turned away from the cut.
std::vector<HolderBody> MakeHolder(const Tool& tool);

}  // namespace kerf
