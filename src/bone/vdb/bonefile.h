// Reading a bone from a stream, and what a file keeps of a bone (kerf/bone_file.h).
#pragma once

#include <istream>
#include <string>

#include "kerf/bone_file.h"

namespace kerf {

/// Reads a bone from a seekable stream, which must not be read afterwards; `path` names it in messages.
Bone ReadBone(std::istream& in, const std::string& path, const ReadBoneOptions& options = {});
/// Returns what ReadBone() would read from a file that WriteBone() wrote of the bone, without the file: materials that
/// were overridden for a run are restored, and CT numbers are kept only if requested. Shares all grids but phi with
/// `bone`.
Bone CopyAsStored(const Bone& bone, const ReadBoneOptions& options = {});

}  // namespace kerf
