// Readers used by ReadMesh(), one per format. Each takes the file's bytes, checks every count and index against them
// before it allocates memory, and throws kerf::Error with one sentence. `path` names the file in messages.
//
// VTK's readers are not used, because they trust the counts and indices in the file and crash if these are wrong.
#pragma once

#include <string>
#include <string_view>

#include "kerf/geometry.h"

namespace kerf {

TriangleMesh ReadStl(std::string_view bytes, const std::string& path);
TriangleMesh ReadObj(std::string_view bytes, const std::string& path);
TriangleMesh ReadPly(std::string_view bytes, const std::string& path);

/// Throws kerf::Error if there are more than kMaxTriangles.
void CheckTriangles(std::size_t count, const std::string& path);
/// Returns a number such as "1,234,567" for messages.
std::string WithSeparators(std::uint64_t count);

}  // namespace kerf
