// The unit of a surface's coordinates, which its file does not say.
#pragma once

#include <string>

#include "kerf/geometry.h"

namespace kerf {

/// mm in one of mm, cm, m, in, um. Throws Error for another.
double CalcMmPerUnit(const std::string& unit);

/// Brings the surface to mm. With an empty `unit` its coordinates are taken for mm unless its largest side is then that
/// of no bone: that is refused with an Error, beginning with `path`, that names the units in which it would be. More
/// than a metre is refused in any unit. Returns a sentence where the surface may as well be a skull in cm, else "".
std::string ScaleToMm(TriangleMesh& mesh, const std::string& unit, const std::string& path);

/// Throws Error, beginning with `path`, when the surface encloses more than is turned into voxels of that size within
/// minutes.
void CheckEnclosed(const TriangleMesh& mesh, double voxel_mm, const std::string& path);

}  // namespace kerf
