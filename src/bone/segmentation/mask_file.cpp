#include "bone/segmentation/mask_file.h"

#include <utility>

#include "bone/import/dicom_segments.h"
#include "bone/segmentation/dicom_segmentation.h"

namespace kerf {

MaskFile ReadMaskFile(const std::string& path, const std::string& frame, const LabelOptions& labels, bool has_ct) {
  Segmentation segmentation = IsDicomFile(path) ? ReadDicomSegmentation(path) : ReadSegmentation(path, frame);
  SegmentationRoles roles = FindRoles(segmentation, labels);
  BoneMask mask = MakeBoneMask(segmentation, roles);
  std::vector<std::string>& warnings = mask.tissue.warnings;
  if (has_ct) {
    for (std::string& warning : warnings) warning.insert(0, path + ": ");
  }
  warnings.insert(warnings.end(), roles.warnings.begin(), roles.warnings.end());
  return {.mask = std::make_shared<const BoneMask>(std::move(mask)),
          .segments = std::move(segmentation.segments),
          .meanings = std::move(roles.meanings)};
}

}  // namespace kerf
