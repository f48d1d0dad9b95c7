#include "bone/segmentation/mask_file.h"

#include <fmt/format.h>

#include <utility>

#include "base/files/extension.h"
#include "base/files/files.h"
#include "bone/import/dicom_segments.h"
#include "bone/segmentation/dicom_segmentation.h"
#include "kerf/error.h"

namespace kerf {

MaskFile ReadMaskFile(const std::string& path, const std::string& frame, const LabelOptions& labels, bool has_ct) {
  CheckIsRegularFile(path);
  const bool is_dicom = IsDicomFile(path);
  if (!is_dicom && LowerExtension(path) == ".dcm") {
    throw Error(fmt::format("{}: not a DICOM file despite its name", path));
  }
  Segmentation segmentation =
      is_dicom ? ReadDicomSegmentation(path, labels.threshold) : ReadSegmentation(path, frame, labels.threshold);
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
