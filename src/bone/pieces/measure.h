// Distances and angles between picked points and planes.
#pragma once

#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Returns the distance between two points, mm.
double CalcDistance(const Vec3& a_W, const Vec3& b_W);
/// Returns the angle at `corner_W` between the directions to the other two points, degrees, 0 to 180; empty if one of
/// them coincides with the corner.
std::optional<double> CalcAngle(const Vec3& a_W, const Vec3& corner_W, const Vec3& b_W);
/// Returns the angle between two planes, degrees, 0 to 90.
double CalcAngle(const CutPlane& a, const CutPlane& b);
/// Returns the signed distance from a plane, mm; positive on the side of the normal.
double CalcDistance(const Vec3& p_W, const CutPlane& plane);
/// Returns the angle of a pose's rotation, degrees, 0 to 180.
double CalcRotationAngle(const Pose& X);

}  // namespace kerf
