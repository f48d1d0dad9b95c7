// A bone on disk: one .vdb file that any OpenVDB program can open. It has the grids "phi" (level set, mm), "region"
// (float; int32 in files of format 1) and, if an import kept them, "hu" (CT numbers). Region table, units, frame and
// provenance are in the file's metadata (docs/formats.md).
#pragma once

#include <string>

#include "kerf/bone.h"

namespace kerf {

struct ReadBoneOptions {
  bool hu = false;  // load the CT numbers too, if there are any; otherwise they are skipped at no cost
};

/// Reads a bone. Throws kerf::Error with one sentence for anything that is not a complete kerf bone.
Bone ReadBone(const std::string& path, const ReadBoneOptions& options = {});
/// Writes to a temporary file next to `path` and renames it. Throws kerf::Error if this fails.
void WriteBone(const Bone& bone, const std::string& path);

}  // namespace kerf
