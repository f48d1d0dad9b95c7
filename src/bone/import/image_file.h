// CT volumes in one file: NRRD, NIfTI, MetaImage.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// Reads a volume. Throws kerf::Error with one sentence if the file is not a 3D scalar image or does not give the size
/// of its voxels. Coordinates are converted to LPS, from NRRD's space or NIfTI's RAS; if `frame` (patient_frame.h) is
/// not empty, it overrides the header. The volume's warnings state what the header leaves open.
Volume ReadImageFile(const std::string& path, const std::string& frame = "");

/// An image with one or more values per voxel.
struct LayeredImage {
  Volume lattice;  // without values; `exact` is that of the values
  std::vector<std::vector<std::int16_t>> layers;
  std::map<std::string, std::string> keys;  // of an NRRD header: its lines "key:=value"
};

/// Reads a volume as ReadImageFile() does, or an NRRD whose first or last axis runs over up to kMaxLabelLayers values
/// of a voxel and whose other axes run through space, as 3D Slicer writes segmentations that overlap. The values are
/// multiplied by `scale` before they are rounded.
LayeredImage ReadLayeredImage(const std::string& path, const std::string& frame = "", double scale = 1);

}  // namespace kerf
