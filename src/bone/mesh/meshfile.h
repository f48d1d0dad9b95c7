// Triangle surfaces on disk: STL, OBJ, PLY.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Reads a surface; the format follows from the extension (.stl, .obj, .ply; any case). Points that coincide exactly
/// are merged, degenerate triangles are dropped, and polygons are split into triangles. Coordinates are read with float
/// precision. Throws kerf::Error if the file cannot be read, or contains no triangle or a non-finite point.
TriangleMesh ReadMesh(const std::string& path);

/// Writes a surface; the format follows from the extension: binary STL and PLY, text OBJ. Coordinates are written with
/// float precision. Writes through a temporary file. Throws kerf::Error if this fails.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);

/// sRGB, 0 to 255.
using Rgb8 = std::array<std::uint8_t, 3>;

/// Writes a PLY with a colour for each point. Throws kerf::Error if `path` is not a .ply or the number of colours
/// differs from the number of points.
void WriteColouredMesh(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours, const std::string& path);

}  // namespace kerf
