// A bone, its pieces, what a cut removed and its structures as a segmentation.
#pragma once

#include <functional>
#include <string>

#include "bone/segmentation/write_segmentation.h"
#include "kerf/bone.h"

namespace kerf {

inline constexpr Range kSegmentVoxelRange_mm{0.05, 5};
/// Smaller pieces are not segments, mm^3.
inline constexpr double kMinSegment_mm3 = 1;

/// Writes a .seg.nrrd, or a DICOM segmentation of the CT that `study` describes (null: none), with voxels of `voxel_mm`
/// along the axes of the bone's frame. Its segments: the bone; its pieces, if there are several or `before` is given;
/// what was removed from `before` (optional; null: unknown); and canals, teeth, lesions and metal of `before`, or of
/// the bone if that is null. The segments have the names of the report. `progress` (optional) is called with values
/// from 0 to 1. Returns what was written. Throws kerf::Error if there is no bone, if more than 0.1 % of its volume is
/// outside `before`, if there are more than 250 pieces or structures, or if the file cannot be written.
SegmentationWriting WriteSegments(const Bone& bone, const Bone* before, double voxel_mm, const std::string& path,
                                  const DicomStudy* study = nullptr, const std::function<void(double)>& progress = {});

}  // namespace kerf
