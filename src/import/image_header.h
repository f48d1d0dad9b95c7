// What the header of an image file promises, held against the bytes that are there, before any library is let at it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

struct ImageCheck {
  std::uint64_t bytes = 0;            // that the voxels take as the file has them, unpacked
  std::vector<std::string> warnings;  // a sentence each: more slices than the header names
};

/// Throws Error with one sentence when the NRRD, NIfTI or MetaImage file at `path` (chosen by its extension: .nrrd
/// .nhdr .nii .nii.gz .mha .mhd) can't hold the voxels that its header names, names more than kMaxVoxels, or is no such
/// file. Allocates no voxels.
ImageCheck CheckImageHeader(const std::string& path);

/// Whether the extension is one of those.
bool HasImageExtension(const std::string& path);

/// Whether the extension is one of NIfTI's.
bool HasNiftiExtension(const std::string& path);

}  // namespace kerf
