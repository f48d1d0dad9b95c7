// What a bone's notes say about its import.
#pragma once

#include <functional>
#include <string>

#include "kerf/bone.h"

namespace kerf {

/// Returns true if the bone was imported from a CT.
bool IsFromCt(const Bone& bone);
/// Returns a note; empty if there is none.
std::string GetNote(const Bone& bone, const std::string& key);
inline constexpr const char* kSurfaceErrorNote = "import_surface_error_mm";
/// Returns the expected error of the surface in words; empty if it is not known. `translate` receives the words.
std::string DescribeSurfaceError(const Bone& bone, const std::function<std::string(const std::string&)>& translate);
/// Returns the assumptions and possible faults of the import as sentences; empty if there are none. `translate`
/// receives each sentence, without its capital and its full stop.
std::string DescribeImport(const Bone& bone, const std::function<std::string(const std::string&)>& translate);

}  // namespace kerf
