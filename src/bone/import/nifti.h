// NIfTI-1 images.
#pragma once

#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// The fields of a NIfTI-1 header that say how its voxels are stored, checked for what no image can have.
struct NiftiHeader {
  std::string bytes;          // the 348 of it
  bool swapped = false;       // stored in the other byte order
  std::vector<double> sizes;  // along each dimension; those of 1 at the end are left out, down to three
  int datatype = 0;           // NIfTI's code
  int bits = 0;               // of a voxel
  double offset = 0;          // bytes before the first voxel
};

/// Reads the header of a .nii or .nii.gz file. Throws Error.
NiftiHeader ReadNiftiHeader(const std::string& path);

/// Reads the volume: values by scl_slope and scl_inter, place by sform or qform and the unit in xyzt_units. What these
/// leave open or contradict goes into the volume's warnings. `frame`: instead of NIfTI's RAS, empty for that. The
/// header and the length of the file must have been checked (image_header.h).
Volume ReadNifti(const std::string& path, const std::string& frame);

}  // namespace kerf
