// Where the voxels of an NRRD or MetaImage lie, as its header says.
#pragma once

#include <string>

#include "bone/import/image_fields.h"
#include "bone/import/volume.h"

namespace kerf {

/// Sets the frame of `volume` (patient_frame.h) to what an NRRD's space means, or to `stated` when that is not empty.
/// Where the space does not say how the scan lies in the patient, LPS is taken and a warning added. Throws Error naming
/// `path` for a left-handed space, one not known, and one without directions.
void SetNrrdFrame(const ImageFields& fields, const std::string& path, const std::string& stated, Volume& volume);

/// Fills spacing, origin and axes of `volume`, whose frame is known, from an NRRD's space directions or spacings, space
/// origin and units. Throws Error naming `path` where the size of a voxel is not given.
void PlaceNrrd(const ImageFields& fields, const std::string& path, Volume& volume);

/// The length of a MetaImage's unit, mm. Throws Error naming `path` where the header gives no spacing, which the
/// library would take as 1 mm.
double CheckMetaSpacing(const ImageFields& fields, const std::string& path);

}  // namespace kerf
