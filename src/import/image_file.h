// CT volumes in one file: NRRD, NIfTI, MetaImage.
#pragma once

#include <string>

#include "import/volume.h"

namespace kerf {

/// Throws Error with one sentence for whatever is not a 3D scalar image. NIfTI's RAS becomes LPS; NRRD's space field is
/// honoured.
Volume ReadImageFile(const std::string& path);

}  // namespace kerf
