// Point lists of 3D Slicer.
#pragma once

#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// The control points of all markups in a .mrk.json file, LPS mm. Its coordinateSystem (LPS or RAS) is honoured; points
/// that were not placed are left out. Throws Error with one sentence when it is no such file, or holds no point.
std::vector<Vec3> ReadMarkups(const std::string& path);

}  // namespace kerf
