// A bone from a CT, from a segmentation, or from a closed surface.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

/// How a bone is imported; `kerf import` has an option of the same name for each.
struct ImportSettings {
  double voxel_mm = 0.1;  // 0.05 to 2
  // For a CT.
  std::string series;        // of DICOM: UID or an end of it; empty: the CT that suits a jaw, if one clearly does
  bool as_ct = false;        // DICOM: read a series that is not stated to be a CT, such as modality OT, as one
  std::string frame;         // of the file's coordinates: "LPS" or "RAS"; empty: that of the header
  double spacing_z_mm = 0;   // between the slices of DICOM files that do not state it; 0: as stated
  double iso_hu = 300;       // CT number of the bone's surface, in the file's own values, -32767 to 32767
  bool iso_auto = false;     // find it in the histogram of the CT, whose values may be no HU; iso_hu is then not used
  bool isolate = true;       // separate the mandible from other bone; false: keep all bone
  std::vector<Vec3> keep_W;  // points in wanted and in unwanted bone, LPS, mm, where the mandible cannot be separated
  std::vector<Vec3> drop_W;  // automatically
  bool fill = true;          // cavities become bone; of a surface: hollows stay hollow if they are marked as such
  bool keep_hu = false;      // keep the CT numbers in the bone, for materials of the kind "ct"
  // Of a segmentation; `kerf import --mask`. With an empty `path` it alone makes the bone.
  std::string mask;         // .seg.nrrd, or a label map (.nrrd .nhdr .mha .mhd .nii .nii.gz .hdr .img); empty: none
  std::string mask_labels;  // the program that wrote a label map without names, such as "dentalsegmentator"
  std::vector<std::string> mask_label;  // what one label or segment is, such as "2=mandible"
  double mask_threshold = 0.5;  // fraction from which on a voxel of a fractional segmentation or soft map counts
  double mask_reach_mm = 0;     // distance from the border of the mask beyond which it overrides the CT; 0: automatic
  // For a surface.
  std::string mesh_units;    // mm, cm, m, in, um; empty: mm, if the size is that of a bone
  double mesh_shell_mm = 2;  // thickness of the cortex, 0 to 10
  /// Replaces the built-in table of regions.
  std::optional<MaterialTable> materials;
  /// Called with values from 0 to 1, in the calling thread. Returning false cancels the import.
  std::function<bool(double)> progress;
};

struct ImportedBone {
  Bone bone;
  bool mandible = false;              // the bone has the shape of a mandible, and its cortex is divided into 31 regions
  double surface_error_mm = 0;        // expected error of the surface, rms; 0: unknown
  std::vector<std::string> warnings;  // assumptions and possible faults, one sentence each
};

/// Imports a bone. `path`: DICOM (a folder, a DICOMDIR, a slice or a .zip), an image (.nrrd .nhdr .nii .nii.gz .mha
/// .mhd .vti .nii.gz .hdr .img) or a closed surface (.stl .obj .ply); empty: the mask alone. The bone's coordinates are
/// the patient's (LPS, mm), or those of the surface. Throws kerf::Error with one sentence if the input cannot be
/// converted to a bone, or if the import is cancelled.
ImportedBone ImportBone(const std::string& path, const ImportSettings& settings = {});

}  // namespace kerf
