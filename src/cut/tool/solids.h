// Solids of which the surfaces of tools are made.
#pragma once

#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Adds a closed solid between z0 and z1 over a star-shaped outline (counter-clockwise around the z axis).
void AddPrism(const std::vector<Vec3>& outline, double z0, double z1, TriangleMesh& mesh);
/// Returns the corners of a regular polygon about the z axis, in the plane z = 0.
std::vector<Vec3> MakeCircle(double radius, int corners);

}  // namespace kerf
