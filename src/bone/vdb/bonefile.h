// A bone on disk: one .vdb that any OpenVDB program opens. Grids "phi" (level set, mm), "region" (int) and,
// where an import kept them, "hu" (CT numbers), with the region table, units, frame and provenance in the file's
// metadata (docs/formats.md).
#pragma once

#include <istream>
#include <string>

#include "kerf/bone.h"

namespace kerf {

struct ReadBoneOptions {
  bool hu = false;  // load the CT numbers too, if there are any; else they are skipped and cost nothing
};

/// Throws Error with one sentence for anything that is not a whole kerf bone.
Bone ReadBone(const std::string& path, const ReadBoneOptions& options = {});
/// The same of a stream that can seek and must not be read any more afterwards; `path` names it in messages.
Bone ReadBone(std::istream& in, const std::string& path, const ReadBoneOptions& options = {});
/// Writes to a temporary beside `path` and renames. Throws Error.
void WriteBone(const Bone& bone, const std::string& path);

}  // namespace kerf
