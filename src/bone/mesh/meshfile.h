// Triangle surfaces on disk: STL, OBJ, PLY.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// A surface and what its file says about it.
struct MeshFile {
  TriangleMesh mesh;
  std::string space;               // "LPS" or "RAS": frame of the points, if the file has SPACE= as 3D Slicer writes it
  std::string unit;                // mm, cm, m, in or um, if the file says so, as those of kerf do; otherwise empty
  std::string unknown_space;       // another word after SPACE=
  std::string unknown_unit;        // another word after UNITS= or alone after "units:"
  std::vector<std::string> notes;  // what was left out or assumed, one sentence each
};

/// Reads a surface; the format follows from the extension (.stl, .obj, .ply; any case). Points that coincide exactly
/// are merged, degenerate triangles are dropped, and polygons are split into triangles. The coordinates are those of
/// the file; those of binary files have float precision. Throws kerf::Error if the file cannot be read, or contains no
/// triangle or a non-finite point.
MeshFile ReadMeshFile(const std::string& path);

/// Turns a surface whose file says SPACE=RAS to LPS, by half a turn about z. Adds a note of it, or of an unknown frame.
void TurnToLps(MeshFile& file);

/// Returns the surface of ReadMeshFile(), turned to LPS, without its notes.
TriangleMesh ReadMesh(const std::string& path);

/// Writes a surface whose coordinates are mm in LPS; its header says so. The format follows from the extension: binary
/// STL and PLY, text OBJ. Coordinates are written with float precision. Writes through a temporary file. Throws
/// kerf::Error if this fails.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);

/// sRGB, 0 to 255.
using Rgb8 = std::array<std::uint8_t, 3>;

/// Writes a PLY with a colour for each point. Throws kerf::Error if `path` is not a .ply or the number of colours
/// differs from the number of points.
void WriteColouredMesh(const TriangleMesh& mesh, const std::vector<Rgb8>& point_colours, const std::string& path);

}  // namespace kerf
