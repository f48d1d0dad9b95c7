// What a bone's notes say about its import.
#pragma once

#include <string>

#include "kerf/bone.h"

namespace kerf {

/// Returns true if the bone was imported from a CT.
bool IsFromCt(const Bone& bone);
/// Returns a note; empty if there is none.
std::string GetNote(const Bone& bone, const std::string& key);
/// Returns the assumptions and possible faults of the import as sentences; empty if there are none.
std::string DescribeImport(const Bone& bone);

}  // namespace kerf
