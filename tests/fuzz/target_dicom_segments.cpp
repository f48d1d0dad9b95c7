#include "bone/segmentation/dicom_segmentation.h"
#include "bone/segmentation/roles.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(dicom_segments) {
  static const MemoryFolder folder;
  const std::string path = folder.Write("f.dcm", bytes);
  Accepts([&] {
    const Segmentation segmentation = ReadDicomSegmentation(path);
    const BoneMask mask = MakeBoneMask(segmentation, FindRoles(segmentation, {}));
    if (mask.tissue.hu.size() != mask.tissue.count()) Finding("a mask without its voxels");
  });
}

}  // namespace kerf::fuzz
