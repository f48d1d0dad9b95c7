// The mask of the mandible from a segmentation's file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bone/import/mask.h"
#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"

namespace kerf {

struct MaskFile {
  std::shared_ptr<const BoneMask> mask;
  std::vector<Segment> segments;
  std::vector<SegmentMeaning> meanings;  // of each segment
};

/// Reads a segmentation, also of DICOM, as a mask, which holds the warnings. `frame`: of the file's coordinates, such
/// as "RAS"; empty: that of its header, as always for DICOM. `has_ct`: the mask is used with a CT; its warnings then
/// name the file. Throws kerf::Error.
MaskFile ReadMaskFile(const std::string& path, const std::string& frame, const LabelOptions& labels, bool has_ct);

}  // namespace kerf
