#include <array>

#include "bone/import/image_fields.h"
#include "bone/import/image_header.h"
#include "bone/import/nifti.h"
#include "bone/import/nrrd_lattice.h"
#include "bone/import/vti.h"
#include "target.h"

namespace kerf::fuzz {

/// The first byte selects the format.
KERF_FUZZ_TARGET(image_header) {
  constexpr std::array<const char*, 8> kNames{"f.nrrd", "f.nhdr", "f.nii", "f.nii.gz",
                                              "f.mha",  "f.mhd",  "f.vti", "f.hdr"};
  if (bytes.empty()) return;
  static const MemoryFolder folder;
  static const std::string voxels_of_pair = folder.Write("f.img", std::string(64, '\1'));
  const std::string path = folder.Write(kNames[static_cast<unsigned char>(bytes[0]) % kNames.size()], bytes.substr(1));
  Accepts([&] {
    CheckImageHeader(path);
    if (IsVtiPath(path)) {
      ReadVti(path, "", 1, 0);
    } else if (HasNiftiExtension(path)) {
      ReadNifti(path, "");
    } else if (EndsWith(path, ".nrrd") || EndsWith(path, ".nhdr")) {
      const ImageFields fields = ParseNrrdFields(ReadHead(path));
      Volume volume;
      SetNrrdFrame(fields, path, "", volume);
      PlaceNrrd(fields, path, volume);
    } else {
      CheckMetaSpacing(ParseMetaFields(ReadHead(path)), path);
    }
  });
}

}  // namespace kerf::fuzz
