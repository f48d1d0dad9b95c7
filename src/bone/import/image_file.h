// CT volumes in one file: NRRD, NIfTI, MetaImage.
#pragma once

#include <string>

#include "bone/import/volume.h"

namespace kerf {

/// Reads a volume. Throws kerf::Error with one sentence if the file is not a 3D scalar image or does not give the size
/// of its voxels. Coordinates are converted to LPS, from NRRD's space or NIfTI's RAS; if `frame` (patient_frame.h) is
/// not empty, it overrides the header. The volume's warnings state what the header leaves open.
Volume ReadImageFile(const std::string& path, const std::string& frame = "");

}  // namespace kerf
