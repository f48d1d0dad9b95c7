// The readers behind ReadMesh, one for each format. Each takes the file's bytes, checks every count and index against
// them before it asks for memory, and throws Error with one sentence. `path` names the file in messages.
//
// They are read here and not by VTK, whose readers believe the counts and indices in the file and crash when they lie.
#pragma once

#include <string>
#include <string_view>

#include "kerf/geometry.h"

namespace kerf {

TriangleMesh ReadStl(std::string_view bytes, const std::string& path);
TriangleMesh ReadObj(std::string_view bytes, const std::string& path);
TriangleMesh ReadPly(std::string_view bytes, const std::string& path);

/// Throws Error when there are more than kMaxTriangles.
void CheckTriangles(std::size_t count, const std::string& path);
/// "1,234,567" for messages.
std::string WithSeparators(std::uint64_t count);

}  // namespace kerf
