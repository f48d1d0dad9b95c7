// Check of an image file's header against its actual bytes, before any library reads the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/voxel_values.h"

namespace kerf {

enum class VoxelPacking { kRaw, kGzip, kText, kUnknown };

/// Location of the voxels of an image file, and their storage format.
struct ImageLayout {
  std::vector<double> sizes;                  // along each dimension; trailing sizes of 1 beyond the third are omitted
  VoxelType type = VoxelType::kInt16;         // of one value; for NIfTI set by its own reader
  double components = 1;                      // values per voxel
  double bytes_per_voxel = 0;                 // unpacked
  VoxelPacking packing = VoxelPacking::kRaw;  // kGzip: gzip or zlib
  std::string encoding;                       // name of the packing in the header
  std::string data_file;
  std::uint64_t offset = 0;  // of the first voxel, or of the compressed stream, in data_file
  bool at_end = false;       // the voxels are the last bytes of data_file; `offset` is ignored
  double lead = 0;           // bytes of the unpacked stream before the first voxel
  bool swapped = false;      // stored in the other byte order
};

enum class ImageContent { kCt, kLabels };

struct ImageCheck {
  ImageLayout layout;
  std::vector<std::string> warnings;  // one sentence each, e.g. for more slices than the header gives
};

/// Checks the NRRD, NIfTI or MetaImage file at `path`, chosen by its extension: .nrrd .nhdr .nii .nii.gz .mha .mhd.
/// Throws kerf::Error with one sentence if it cannot hold the voxels that its header states, has more than
/// kMaxVoxels, would take more memory than its content is allowed to (kMaxUnpackedBytes), or is not such a file.
/// Allocates no voxels.
ImageCheck CheckImageHeader(const std::string& path, ImageContent content = ImageContent::kCt);

/// Reads the voxels of a checked file, unpacked and in this machine's byte order; text becomes VoxelType::kDouble in
/// `layout`. Throws kerf::Error if there are fewer than `count`.
std::vector<char> ReadVoxels(ImageLayout& layout, std::size_t count, const std::string& path);

/// Returns whether `path` has one of the extensions listed at CheckImageHeader().
bool HasImageExtension(const std::string& path);

/// Returns whether `path` has a NIfTI extension.
bool HasNiftiExtension(const std::string& path);

}  // namespace kerf
