// NIfTI-1 and NIfTI-2 images in one file or a pair, and Analyze pairs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Fields of a NIfTI or Analyze header, checked for impossible values.
struct NiftiHeader {
  bool analyze = false;       // without forms, slope in NIfTI's sense and sides
  std::string data_file;      // of the voxels
  bool swapped = false;       // stored in the other byte order
  std::vector<double> sizes;  // along each dimension; trailing sizes of 1 beyond the third are omitted
  int datatype = 0;           // NIfTI's code
  int bits = 0;               // per voxel
  double offset = 0;          // bytes before the first voxel, in the unpacked file
  Vec3 spacing{0};
  double handedness = 1;               // NIfTI's qfac
  double slope = 0;                    // 0: none
  double intercept = 0;                //
  int unit = 0;                        // xyzt_units
  int orient = 0;                      // of Analyze
  int qform_code = 0, sform_code = 0;  // 0: not given
  std::array<double, 6> quaternion{};  // b, c, d, and the offset
  std::array<double, 12> rows{};       // of the sform
};

/// Reads the header of a .nii or .nii.gz file, or of the pair that a .hdr or .img file (also with .gz) belongs to.
/// Throws kerf::Error if it is not one, or if a file of the pair is missing.
NiftiHeader ReadNiftiHeader(const std::string& path);

/// Reads the volume: values by scl_slope and scl_inter, position by sform or qform and the unit in xyzt_units. The
/// volume's warnings state what these leave open and where they contradict each other. `frame`: overrides NIfTI's RAS
/// if not empty. The values are multiplied by `scale` before they are rounded; those that are no numbers become
/// `blank`. The header and the length of the file must have been checked (image_header.h).
Volume ReadNifti(const std::string& path, const std::string& frame, double scale = 1, std::int16_t blank = -1024);

}  // namespace kerf
