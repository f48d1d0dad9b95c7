// Unit of a surface's coordinates, which its file does not give.
#pragma once

#include <string>

#include "kerf/geometry.h"

namespace kerf {

/// Returns the length of mm, cm, m, in or um in mm. Throws kerf::Error for another unit.
double CalcMmPerUnit(const std::string& unit);

/// Converts the surface to mm. If `unit` is empty, mm are assumed, unless the largest side is then not plausible for a
/// bone, or the surface is as plausible as a skull or a long bone in cm: then throws kerf::Error, whose message begins
/// with `path` and lists the units to choose from with the size in each. A surface larger than a metre is rejected in
/// any unit.
void ScaleToMm(TriangleMesh& mesh, const std::string& unit, const std::string& path);

/// Throws kerf::Error, whose message begins with `path`, if the surface encloses more than can be voxelised with voxels
/// of `voxel_mm` within minutes.
void CheckEnclosed(const TriangleMesh& mesh, double voxel_mm, const std::string& path);

}  // namespace kerf
