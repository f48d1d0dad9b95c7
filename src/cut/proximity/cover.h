// A tool covered by plates that are asked one by one.
#pragma once

#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// A round plate across the spindle axis that covers part of the tool. Tool frame.
struct CoverPlate {
  Vec3 centre_T{0};
  double radius_mm = 0;
  double half_thickness_mm = 0;
};

/// Plates that cover all of a disc: one in the middle and 6, 12 and 18 in rings round it, each of less than a quarter
/// of the disc's radius. None for a ball, which is its own cover. Allocates.
std::vector<CoverPlate> MakeCover(const Tool& tool);

}  // namespace kerf
