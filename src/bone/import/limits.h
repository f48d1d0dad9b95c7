// The most that a scan may ask for, in one place for this folder (docs/reliability.md lists those of all).
#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf {

/// Voxels of a volume: 4 GiB of HU. A CT of 512 x 512 x 2000 has a quarter.
inline constexpr std::uint64_t kMaxVoxels = std::uint64_t{1} << 31;
/// Bytes of a voxel in a file: a number of 64 bits.
inline constexpr double kMaxVoxelBytes = 8;
/// Pixels of a DICOM slice, which are unpacked as a whole. CT slices have 512 x 512, micro-CT up to 4096 x 4096.
inline constexpr std::uint64_t kMaxSlicePixels = std::uint64_t{1} << 26;
/// A DICOM file of one slice; kerf reads it as a whole.
inline constexpr std::uint64_t kMaxSliceBytes = std::uint64_t{512} << 20;
/// Bytes that one byte of a gzip, zlib or bzip2 stream, or of text, may be unpacked to: deflate can't do more.
inline constexpr double kMaxUnpackRatio = 1032;
/// Header of an NRRD or MetaImage file.
inline constexpr std::size_t kMaxImageHeaderBytes = std::size_t{1} << 16;
/// A line of text before the voxels of an NRRD, which its header leaves out.
inline constexpr std::int64_t kMaxSkippedLine = std::int64_t{1} << 20;
/// Sequences and items of a DICOM file within each other, counted apart; GDCM takes a frame of the stack for each.
inline constexpr std::size_t kMaxDicomDepth = 64;

}  // namespace kerf
