#include <array>
#include <cstdlib>

#include "bone/segmentation/label_table.h"
#include "bone/segmentation/roles.h"
#include "bone/segmentation/segmentation.h"
#include "target.h"

namespace kerf::fuzz {

/// The first byte selects the format.
KERF_FUZZ_TARGET(segmentation) {
  constexpr std::array<const char*, 4> kNames{"f.seg.nrrd", "f.nhdr", "f.nii", "f.mha"};
  if (bytes.empty()) return;
  static const MemoryFolder folder;
  const std::string path = folder.Write(kNames[static_cast<unsigned char>(bytes[0]) % kNames.size()], bytes.substr(1));
  Accepts([&] {
    const Segmentation segmentation = ReadSegmentation(path);
    LabelOptions options;
    if (!segmentation.named) options.preset = "dentalsegmentator";
    const BoneMask mask = MakeBoneMask(segmentation, FindRoles(segmentation, options));
    if (mask.tissue.hu.size() != mask.tissue.count()) std::abort();
  });
  ParseLabelTable(bytes.substr(1));
}

}  // namespace kerf::fuzz
