// Triangle surfaces on disk: STL, OBJ, PLY.
#pragma once

#include <string>

#include "kerf/geometry.h"

namespace kerf {

/// By extension (.stl, .obj, .ply; any case). Points that coincide exactly are merged, degenerate triangles dropped.
/// Throws Error when it can't be read, or holds no triangle or a non-finite point.
TriangleMesh ReadMesh(const std::string& path);
/// By extension; binary STL and PLY, text OBJ. Through a temporary. Throws Error.
void WriteMesh(const TriangleMesh& mesh, const std::string& path);
/// At most about `triangles` triangles, shape kept by quadric error. Stays closed when it was closed.
TriangleMesh Decimate(const TriangleMesh& mesh, std::size_t triangles);

}  // namespace kerf
