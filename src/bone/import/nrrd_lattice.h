// Position of the voxels of an NRRD or MetaImage, from its header.
#pragma once

#include <string>

#include "bone/import/image_fields.h"
#include "bone/import/volume.h"

namespace kerf {

/// Sets the frame of `volume` (patient_frame.h) from an NRRD's space, or to `stated` if that is not empty. If the space
/// does not give the orientation in the patient, LPS is assumed and a warning is added. Throws kerf::Error, with `path`
/// in the message, for a left-handed or unknown space, and for one without directions.
void SetNrrdFrame(const ImageFields& fields, const std::string& path, const std::string& stated, Volume& volume);

/// Sets spacing, origin and axes of `volume`, whose frame is set, from an NRRD's space directions or spacings, space
/// origin and units. Throws kerf::Error, with `path` in the message, if the size of a voxel is not given.
void PlaceNrrd(const ImageFields& fields, const std::string& path, Volume& volume);

/// Returns the length of a MetaImage's unit, mm. Throws kerf::Error, with `path` in the message, if the header gives no
/// spacing; the library would assume 1 mm.
double CheckMetaSpacing(const ImageFields& fields, const std::string& path);

}  // namespace kerf
