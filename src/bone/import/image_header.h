// What the header of an image file promises, held against the bytes that are there, before any library is let at it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/voxel_values.h"

namespace kerf {

enum class VoxelPacking { kRaw, kGzip, kText, kUnknown };

/// Where an image file has its voxels, and how they are stored.
struct ImageLayout {
  std::vector<double> sizes;                  // along each dimension; those of 1 at the end are left out, down to three
  VoxelType type = VoxelType::kInt16;         // of one value; NIfTI's is found by its own reader
  double components = 1;                      // values of a voxel
  double bytes_per_voxel = 0;                 // unpacked
  VoxelPacking packing = VoxelPacking::kRaw;  // kGzip: gzip or zlib
  std::string encoding;                       // the header's word for the packing
  std::string data_file;
  std::uint64_t offset = 0;  // of the first voxel, or of the compressed stream, in data_file
  bool at_end = false;       // the voxels are the last bytes of data_file, whatever the offset
  double lead = 0;           // bytes of the unpacked stream before the first voxel
  bool swapped = false;      // stored in the other byte order
};

struct ImageCheck {
  ImageLayout layout;
  std::vector<std::string> warnings;  // a sentence each: more slices than the header names
};

/// Throws Error with one sentence when the NRRD, NIfTI or MetaImage file at `path` (chosen by its extension: .nrrd
/// .nhdr .nii .nii.gz .mha .mhd) can't hold the voxels that its header names, names more than kMaxVoxels, or is no such
/// file. Allocates no voxels.
ImageCheck CheckImageHeader(const std::string& path);

/// The voxels of a file that was checked, unpacked and in this machine's byte order; text becomes VoxelType::kDouble in
/// `layout`. Throws Error when there are fewer than `count`.
std::vector<char> ReadVoxels(ImageLayout& layout, std::size_t count, const std::string& path);

/// Whether the extension is one of those.
bool HasImageExtension(const std::string& path);

/// Whether the extension is one of NIfTI's.
bool HasNiftiExtension(const std::string& path);

}  // namespace kerf
