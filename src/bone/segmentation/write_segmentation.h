// Writing of segmentations, as 3D Slicer and as DICOM have them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bone/import/dicom_study.h"
#include "bone/segmentation/roles.h"
#include "kerf/geometry.h"

namespace kerf {

struct WrittenSegment {
  std::string name;
  std::array<std::uint8_t, 3> colour{};  // sRGB
  int layer = 0;
  int label = 1;                            // 1 to 255; its value in the voxels of its layer
  std::optional<SegmentMeaning> meaning{};  // none: some bone
  std::size_t voxels = 0;                   // set by the functions below
};

/// Segments on a lattice of cubes along the axes of the world frame, LPS. Segments of different layers may overlap.
struct SegmentationWriting {
  std::array<int, 3> size{0, 0, 0};
  double voxel_mm = 0;
  Vec3 origin_W{0};  // centre of voxel (0, 0, 0)
  int layers = 1;
  std::vector<WrittenSegment> segments;
  std::vector<std::string> without_voxels{};  // names of segments that were left out
  /// Sets the labels of slice k, which are 0 before: x fastest of the voxels, and the layers of one voxel side by side.
  std::function<void(int k, std::span<std::uint8_t> labels)> fill;
};

/// Writes a .seg.nrrd through a temporary file. Segments without voxels are left out, and are moved from
/// `writing.segments` to `without_voxels`. Throws kerf::Error if the file cannot be written.
void WriteSegmentation(SegmentationWriting& writing, const std::string& path);

/// Does the same as a DICOM segmentation of the CT that `study` describes, in its patient's frame of reference.
void WriteDicomSegmentation(SegmentationWriting& writing, const DicomStudy& study, const std::string& path);

}  // namespace kerf
