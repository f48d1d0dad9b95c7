// Readers used by ReadMeshFile(), one per format. Each takes the file's bytes, checks every count and index against
// them before it allocates memory, and throws kerf::Error with one sentence. `path` names the file in messages.
//
// VTK's readers are not used, because they trust the counts and indices in the file and crash if these are wrong.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "bone/mesh/meshfile.h"
#include "kerf/geometry.h"

namespace kerf {

MeshFile ReadStl(std::string_view bytes, const std::string& path);
MeshFile ReadObj(std::string_view bytes, const std::string& path);
MeshFile ReadPly(std::string_view bytes, const std::string& path);

/// Sets `file.space` and `file.unit` from a header or a comment, unless an earlier one did.
void ReadComment(std::string_view text, MeshFile& file);

/// Splits a face with at least three corners into triangles and adds them: a fan from the first corner if the face is
/// convex or the fan covers it, otherwise ears that are cut off one by one. Throws kerf::Error if the face then has
/// more than kMaxConcaveCorners.
void AddFace(std::span<const std::uint32_t> corners, const std::string& path, TriangleMesh& mesh);

/// Throws kerf::Error if there are more than kMaxTriangles.
void CheckTriangles(std::size_t count, const std::string& path);
/// Returns a number such as "1,234,567" for messages.
std::string WithSeparators(std::uint64_t count);

}  // namespace kerf
