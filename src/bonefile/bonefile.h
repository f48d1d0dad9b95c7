// A bone on disk: one .vdb that any OpenVDB program opens. Grids "phi" (level set, mm) and "region" (int), with the
// region table, units, frame and provenance in the file's metadata (docs/formats.md).
#pragma once

#include <string>

#include "kerf/bone.h"

namespace kerf {

/// Throws Error with one sentence for anything that is not a whole kerf bone.
Bone ReadBone(const std::string& path);
/// Writes to a temporary beside `path` and renames. Throws Error.
void WriteBone(const Bone& bone, const std::string& path);

}  // namespace kerf
