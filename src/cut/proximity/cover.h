// Cover of a tool by round plates, which are queried one by one.
#pragma once

#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// Round plate perpendicular to the spindle axis that covers a part of the tool. Tool frame.
struct CoverPlate {
  Vec3 centre_T{0};
  double radius_mm = 0;
  double half_thickness_mm = 0;
};

/// Returns plates that cover all of a disc: one in the middle and 6, 12 and 18 in rings around it, each with a radius
/// of less than a quarter of the disc's. Returns none for a ball, which needs no cover. Allocates.
std::vector<CoverPlate> MakeCover(const Tool& tool);

}  // namespace kerf
