// Where a point of an edge that a drive moves lies along the edge. Tick-safe.
#pragma once

#include <cmath>

#include "cut/tool/edge_motion.h"

namespace kerf {

/// Returns the displacement that takes the origin of T to a point of the edge, mm; of another point of an arc's plane,
/// that to the point of the edge in its direction from the swing axis.
inline double CalcAlongEdge(const EdgeMotion& motion, const Vec3& p_T) {
  return motion.is_straight() ? p_T.y : motion.radius_mm() * std::atan2(p_T.y, p_T.x + motion.radius_mm());
}

}  // namespace kerf
