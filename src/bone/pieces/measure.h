// Distances and angles between picked points and planes.
#pragma once

#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// mm.
double CalcDistance(const Vec3& a_W, const Vec3& b_W);
/// At `corner`, between the ways to the other two, degrees, 0 to 180. None where one of them has no length.
std::optional<double> CalcAngle(const Vec3& a_W, const Vec3& corner_W, const Vec3& b_W);
/// Between two planes, degrees, 0 to 90.
double CalcAngle(const CutPlane& a, const CutPlane& b);
/// Signed, to the side of the normal positive, mm.
double CalcDistance(const Vec3& p_W, const CutPlane& plane);
/// How a pose turns and moves: the angle of its rotation, degrees, 0 to 180.
double CalcTurn(const Pose& X);

}  // namespace kerf
