// From a CT or a surface to a bone.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/grid/build.h"
#include "bone/grid/ct_modulus.h"
#include "bone/import/closed_surface.h"
#include "bone/import/fill.h"
#include "bone/import/isolate.h"
#include "bone/import/surface_error.h"
#include "bone/import/tissue.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

struct ImportOptions {
  std::string series;      // of a DICOM folder: UID or its end; empty: the only CT series
  std::string frame;       // of the file's coordinates, such as "RAS" (patient_frame.h); empty: as the header says
  double voxel_mm = 0.1;   // 0.05 to 2
  IsolateOptions isolate;  // with the iso value
  bool fill = true;  // of a CT: cavities become bone; false, of a surface: whatever an inner shell encloses is hollow
  FillOptions cavities;
  TissueOptions tissue;
  double mesh_shell_mm = 2.0;              // of a surface, which has no HU: cortex is this thick
  std::string mesh_units;                  // of its coordinates: mm, cm, m, in, um; empty: mm, if that gives a bone
  std::optional<MaterialTable> materials;  // instead of the built-in one
  std::string materials_name;              // where it came from, for messages and provenance
  bool keep_hu = false;                    // store the CT numbers in the bone
  double hu_voxel_mm = 0;                // on this lattice, 0.1 to 5; 0: the CT's finest spacing, but at least voxel_mm
  std::function<void(double)> progress;  // 0 to 1, one thread; may be empty
};

/// What was read, found and made. Volumes mm^3.
struct ImportReport {
  std::string kind;  // "DICOM", "image" or "surface"
  std::string series_uid;
  std::array<int, 3> size{0, 0, 0};  // of the CT, voxels
  Vec3 spacing_mm{0};
  std::uint64_t input_hash = 0;
  std::vector<std::string> warnings;  // what was assumed or looks wrong, a sentence each
  std::string isolation;
  double contact_mm2 = 0;          // of the bone with what it was parted from
  double iso_mm3 = 0;              // above iso, by voxels of the CT
  double filled_mm3 = 0;           // cavities, by voxels of the CT
  FilledVoids voids;               // that were left in the level set, and filled too
  double tooth_mm3 = 0;            // by voxels of the CT
  double solid_mm3 = 0;            // of the level set
  Box3 box;                        // of its surface, LPS mm
  std::size_t pieces = 0;          // separate pieces of the level set
  std::size_t dropped_pieces = 0;  // small ones left out, at the CT's resolution and at the level set's
  double dropped_mm3 = 0;
  bool mandible = false;        // has the shape of one; the atlas was laid on it
  std::string shape_objection;  // why not
  bool cut_by_scan = false;     // the bone reaches the edge of the scan
  SurfaceError surface_error;   // of a CT
  std::uint64_t active_voxels = 0;
  std::uint64_t memory_bytes = 0;  // of the bone
  double hu_voxel_mm = 0;          // of the CT numbers kept; 0: none
  HuRange hu;                      // of those, in the bone
  std::map<int, double> region_mm3;
  SurfaceReport surface;                                // of a closed surface
  std::vector<std::pair<std::string, double>> seconds;  // by stage
};

struct ImportResult {
  Bone bone;
  ImportReport report;
};

/// By the extension.
bool IsSurfacePath(const std::string& path);

/// `path`: a DICOM folder, an image (.nrrd .nhdr .nii .nii.gz .mha .mhd) or a closed surface (.stl .obj .ply). The
/// bone's coordinates are the patient's (LPS, mm), a surface's its own. Throws Error with a sentence for whatever can't
/// become a bone.
ImportResult Import(const std::string& path, const ImportOptions& options);

/// The CT that Import() would begin with, by `options.series` and `options.progress`; fills in what `report` has of it.
Volume ReadCt(const std::string& path, const ImportOptions& options, ImportReport& report);

}  // namespace kerf
