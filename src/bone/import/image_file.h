// CT volumes in one file: NRRD, NIfTI, MetaImage.
#pragma once

#include <string>

#include "bone/import/volume.h"

namespace kerf {

/// Throws Error with one sentence for whatever is not a 3D scalar image, and where the size of its voxels is not given.
/// Coordinates become LPS by NRRD's space and from NIfTI's RAS; `frame` (patient_frame.h) is taken instead of what the
/// header says, when not empty. What the header leaves open is in the volume's warnings.
Volume ReadImageFile(const std::string& path, const std::string& frame = "");

}  // namespace kerf
