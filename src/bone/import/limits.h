// Upper limits for scans, in one place for this folder (docs/reliability.md lists those of all folders).
#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf {

/// Voxels of a volume; their HU take 4 GiB. A CT of 512 x 512 x 2000 voxels has a quarter of this number.
inline constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 31;
/// Bytes of a voxel in a file: one 64-bit number.
inline constexpr double kMaxVoxelBytes = 8;
/// Pixels of a DICOM slice, which is unpacked as a whole. CT slices have 512 x 512 pixels, micro-CT slices up to 4096 x
/// 4096.
inline constexpr std::uint64_t kMaxSlicePixels = std::uint64_t{1} << 26;
/// Frames of a DICOM file. Cone-beam CT has up to 1000, perfusion CT some thousands.
inline constexpr int kMaxFrames = 1 << 14;
/// Bytes of a DICOM file, unless its pixels take more than half of them: then they may be up to kMaxVoxels.
inline constexpr std::uint64_t kMaxSliceBytes = std::uint64_t{512} << 20;
/// Unpacked bytes per byte of a gzip or zlib stream, or of text: the maximum for deflate.
inline constexpr double kMaxUnpackRatio = 1032;
/// The same for bzip2, which packs 46 MB of one value into 45 bytes.
inline constexpr double kMaxBzip2Ratio = 1.1e6;
/// Files of one image, such as one for each slice.
inline constexpr std::size_t kMaxDataFiles = std::size_t{1} << 14;
/// Bytes of the header of an NRRD or MetaImage file. That of a segmentation has up to a kilobyte for each segment.
inline constexpr std::size_t kMaxImageHeaderBytes = std::size_t{1} << 18;
/// Layers of a segmentation: sets of labels on one lattice.
inline constexpr std::size_t kMaxLabelLayers = 256;
/// Bytes of memory that a label map or a compressed CT takes while it is read: its values as the file has them, and two
/// bytes for each. A CT of 512 x 512 x 2000 voxels, or a segmentation of it, has up to 2.1e9.
inline constexpr double kMaxUnpackedBytes = double{3} * (1 << 30);
/// Bytes of that memory per byte of the file of a compressed CT that takes more than kMaxUnpackedBytes. CTs are
/// compressed to a half or a third, and then take 4 to 6 times their file.
inline constexpr double kMaxMemoryRatio = 32;
/// Bytes of one of the lines of text before the voxels that an NRRD header may tell the reader to skip.
inline constexpr std::int64_t kMaxSkippedLine = std::int64_t{1} << 20;
/// Nesting depth of sequences and items in a DICOM file, counted separately; GDCM needs a stack frame for each.
inline constexpr std::size_t kMaxDicomDepth = 64;
/// Files in a ZIP file, and bytes of all of them when unpacked. A CT of 512 x 512 x 2000 voxels has 1.1e9 bytes.
inline constexpr std::uint64_t kMaxPackedFiles = 20'000;
inline constexpr double kMaxPackedBytes = 8e9;
/// Unpacked bytes per byte of a ZIP file that unpacks to more than kFreePackedBytes. CTs are packed to a half or a
/// third, those with much air to a tenth.
inline constexpr double kMaxPackedRatio = 100;
inline constexpr double kFreePackedBytes = 64e6;

}  // namespace kerf
