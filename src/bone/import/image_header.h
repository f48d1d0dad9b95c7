// Check of an image file's header against its actual bytes, before any library reads the file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/unpack.h"
#include "bone/import/voxel_values.h"

namespace kerf {

enum class VoxelPacking { kRaw, kGzip, kBzip2, kText, kVti, kUnknown };

/// Location of the voxels of an image file, and their storage format.
struct ImageLayout {
  std::vector<double> sizes;                  // along each dimension; trailing sizes of 1 beyond the third are omitted
  VoxelType type = VoxelType::kInt16;         // of one value; for NIfTI set by its own reader
  double components = 1;                      // values per voxel
  double bytes_per_voxel = 0;                 // unpacked
  VoxelPacking packing = VoxelPacking::kRaw;  // kGzip: gzip or zlib
  std::string encoding;                       // name of the packing in the header
  std::string data_file;
  std::vector<std::string> data_files;  // if not empty: several files like data_file, each with as many voxels
  std::uint64_t offset = 0;             // of the first voxel, or of the compressed stream, in data_file
  bool at_end = false;                  // the voxels are the last bytes of data_file; `offset` is ignored
  double lead = 0;                      // bytes of the unpacked stream before the first voxel
  bool swapped = false;                 // stored in the other byte order
  // Of kVti.
  bool base64 = false;
  bool zlib_blocks = false;
  bool wide_counts = false;  // its counts of bytes have 64 bits instead of 32
};

enum class ImageContent { kCt, kLabels };

struct ImageCheck {
  ImageLayout layout;
  std::vector<std::string> warnings;  // one sentence each, e.g. for more slices than the header gives
};

/// Checks the NRRD, NIfTI, Analyze or MetaImage file at `path`, chosen by its extension.
/// Throws kerf::Error with one sentence if it cannot hold the voxels that its header states, has more than
/// kMaxVoxels, would take more memory than its content is allowed to (kMaxUnpackedBytes), or is not such a file.
/// Allocates no voxels.
ImageCheck CheckImageHeader(const std::string& path, ImageContent content = ImageContent::kCt);

/// Reads the voxels of a checked file, unpacked and in this machine's byte order; text becomes VoxelType::kDouble in
/// `layout`. Throws kerf::Error if there are fewer than `count`.
std::vector<char> ReadVoxels(ImageLayout& layout, std::size_t count, const std::string& path);

/// Extensions of images, in lower case.
inline constexpr std::array kNiftiExtensions{".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"};
inline constexpr std::array kOtherImageExtensions{".nrrd", ".nhdr", ".mha", ".mhd", ".vti"};

/// Unpacks the stream of a layout that is kGzip or kBzip2, as Unpack() does.
Unpacked UnpackStream(const ImageLayout& layout, double max_bytes, double skip = 0, std::vector<char>* out = nullptr);

/// Returns the extensions of images with blanks between them, for help and messages.
std::string ListImageExtensions();

/// Returns whether `path` has an extension of an image.
bool HasImageExtension(const std::string& path);

/// Returns whether `path` has a NIfTI extension.
bool HasNiftiExtension(const std::string& path);

}  // namespace kerf
