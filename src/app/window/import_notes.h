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
/// Returns the assumptions and possible faults of the import as sentences; empty if there are none. `translate`
/// receives each sentence, without its capital and its full stop.
std::string DescribeImport(const Bone& bone, const std::function<std::string(const std::string&)>& translate);

}  // namespace kerf
