// NIfTI-1 images.
#pragma once

#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Fields of a NIfTI-1 header that describe the storage of its voxels, checked for impossible values.
struct NiftiHeader {
  std::string bytes;          // all 348 bytes
  bool swapped = false;       // stored in the other byte order
  std::vector<double> sizes;  // along each dimension; trailing sizes of 1 beyond the third are omitted
  int datatype = 0;           // NIfTI's code
  int bits = 0;               // per voxel
  double offset = 0;          // bytes before the first voxel
};

/// Reads the header of a .nii or .nii.gz file. Throws kerf::Error if it is not one.
NiftiHeader ReadNiftiHeader(const std::string& path);

/// Reads the volume: values by scl_slope and scl_inter, position by sform or qform and the unit in xyzt_units. The
/// volume's warnings state what these leave open and where they contradict each other. `frame`: overrides NIfTI's RAS
/// if not empty. The values are multiplied by `scale` before they are rounded. The header and the length of the file
/// must have been checked (image_header.h).
Volume ReadNifti(const std::string& path, const std::string& frame, double scale = 1);

}  // namespace kerf
