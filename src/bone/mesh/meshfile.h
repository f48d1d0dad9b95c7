// Triangle surfaces on disk: STL, OBJ, PLY.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// By extension (.stl, .obj, .ply; any case). Points that coincide exactly are merged, degenerate triangles dropped,
/// polygons split into triangles. Coordinates are read with the precision of a float. Throws Error when it can't be
/// read, or holds no triangle or a non-finite point.
TriangleMesh ReadMesh(const std::string& path);

/// By extension; binary STL and PLY, text OBJ. Coordinates are written with the precision of a float. Through a
/// temporary. Throws Error.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);

/// sRGB, 0 to 255.
using Rgb8 = std::array<std::uint8_t, 3>;

/// A PLY with a colour for each point. Throws Error when `path` is no .ply or there is not one colour for each point.
void WriteColouredMesh(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours, const std::string& path);

}  // namespace kerf
