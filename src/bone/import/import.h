// Import of a bone from a CT or a surface.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/grid/build.h"
#include "bone/grid/ct_modulus.h"
#include "bone/import/closed_surface.h"
#include "bone/import/fill.h"
#include "bone/import/hu_check.h"
#include "bone/import/isolate.h"
#include "bone/import/surface_error.h"
#include "bone/import/tissue.h"
#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/material.h"

namespace kerf {

/// What a DICOM file of many slices does not give and was therefore assumed.
struct AssumedPlacing {
  std::optional<double> spacing_mm;  // between the slices; nullopt: the file gives their places
  std::string spacing_from;          // element that suggests it; empty: none does, so that it is that of the pixels
  bool has_orientation = true;       // false: rows were taken from right to left, columns from front to back
  int axis = 2;                      // of the patient, LPS, which the slices lie along
};

/// The places of a CT's slices were assumed, and the user is to check them.
class NotPlaced : public Error {
 public:
  NotPlaced(const std::string& what, AssumedPlacing placing, std::optional<NotHu> values)
      : Error(what), placing_(std::move(placing)), values_(std::move(values)) {}
  const AssumedPlacing& placing() const { return placing_; }
  /// If the values are no Hounsfield units either.
  const std::optional<NotHu>& values() const { return values_; }

 private:
  AssumedPlacing placing_;
  std::optional<NotHu> values_;
};

/// Of the bone's surface, in the file's own values.
inline constexpr Range kIsoRange_HU{-32767, 32767};
/// Between the slices of DICOM files that do not state it.
inline constexpr Range kSliceSpacingRange_mm{0.01, 20};

struct ImportOptions {
  std::string series;       // of DICOM files: name, UID or an end of either; if empty, as ChooseSeries() does
  bool as_ct = false;       // DICOM: read a series that is not stated to be a CT, such as modality OT, as one
  std::string frame;        // of the file's coordinates, such as "RAS" (patient_frame.h); if empty, that of the header
  double spacing_z_mm = 0;  // between DICOM slices, for files that do not state it; 0: as stated
  bool check_placing = false;  // DICOM: throws NotPlaced, after take_ct, if the places of the slices were assumed
  double voxel_mm = 0.1;
  IsolateOptions isolate;  // includes the iso value, in the file's own values
  bool iso_auto = false;   // the iso value is found in the CT's histogram instead (hu_check.h)
  bool fill = true;  // CT: if true, cavities become bone; surface: if false, all volume enclosed by an inner shell is
                     // hollow
  FillOptions cavities;
  TissueOptions tissue;
  double mesh_shell_mm = 2.0;              // for a surface, which has no HU
  std::string mesh_units;                  // of a surface's coordinates: mm, cm, m, in, um; if empty: mm, if the size
                                           // is that of a bone
  std::optional<MaterialTable> materials;  // replaces the built-in table
  std::string materials_name;              // its origin, for messages and provenance
  bool keep_hu = false;                    // store the CT numbers in the bone
  double hu_voxel_mm = 0;                  // 0: the CT's finest spacing, but at least voxel_mm
  std::function<void(double)> progress;    // optional; 0 to 1, from one thread; may throw Cancelled
  // For looking at the input during the import; optional. Both are called in the thread that imports.
  std::function<void(std::shared_ptr<const Volume>)> take_ct;  // the CT, along the patient's axes, once it is read
  std::function<void(Bone)> take_preview;                      // a coarse bone: see MakePreview()
};

template <typename V>
void Describe(ImportOptions& p, V&& visit) {
  visit("voxel_mm", p.voxel_mm, Range{0.05, 2}, "voxel size of the bone");
  visit("spacing_z_mm", p.spacing_z_mm, Range{kSliceSpacingRange_mm.lower, kSliceSpacingRange_mm.upper, kOrZero},
        "distance between the slices of DICOM files that do not state it; 0: as stated");
  visit("iso_hu", p.isolate.iso_hu, kIsoRange_HU, "CT number of the bone's surface");
  visit("cortical_hu", p.tissue.cortical_hu, Range{-500, 4000}, "minimum CT number of cortical bone");
  visit("tooth_hu", p.tissue.tooth_hu, Range{0, 32767}, "minimum CT number of enamel");
  visit("shell_mm", p.tissue.shell_mm, Range{0, 10}, "depth to which bone is cortical whatever its CT number");
  visit("mesh_shell_mm", p.mesh_shell_mm, Range{0, 10}, "thickness of the cortex of an imported surface");
  visit("mask_reach_mm", p.isolate.mask_reach_mm, Range{0.1, 20, kOrZero},
        "distance from the border of the mask beyond which the mask overrides the CT; 0: two of the mask's voxels, but "
        "at least 1.5 mm");
  visit("hu_voxel_mm", p.hu_voxel_mm, Range{kHuVoxelRange_mm.lower, kHuVoxelRange_mm.upper, kOrZero},
        "voxel size of the stored CT numbers; 0: the CT's finest spacing, but at least the bone's voxel size");
}

/// How a mask was used. Volumes in mm^3; of the mask, on the lattice of the CT or, without a CT, on its own.
struct MaskReport {
  bool used = false;
  double reach_mm = 0;        // 0 without a CT
  double wanted_mm3 = 0;      // of the wanted bone in the mask
  double added_mm3 = 0;       // bone by the mask alone, where the CT shows none and no cavity
  double cut_off_mm3 = 0;     // bone by the CT alone, as in MaskUse
  double given_away_mm3 = 0;  // bone by CT and mask that is not in the result, as in MaskUse
  double given_away_mm = 0;   // its greatest distance from the result
  double beyond_mm3 = 0;      // bone by the CT, within the reach, that the mask does not name
};

/// Results of an import. Volumes in mm^3.
struct ImportReport {
  std::string kind;  // "DICOM", "image", "surface" or "mask"
  std::string series_uid;
  std::string study_date;            // of DICOM, YYYY-MM-DD; empty: not given
  std::array<int, 3> size{0, 0, 0};  // of the CT, voxels
  Vec3 spacing_mm{0};
  std::uint64_t input_hash = 0;
  std::vector<std::string> warnings;      // assumptions and possible faults, one sentence each
  std::optional<AssumedPlacing> placing;  // of DICOM
  double iso = 300;                       // of the bone's surface, in the file's own values
  bool is_grey = false;                   // the file's values were no HU, and converted to approximate HU
  std::string isolation;
  MaskReport mask;
  double contact_mm2 = 0;          // contact area of the bone with the bone that was separated from it
  double iso_mm3 = 0;              // bone above iso, sum of the CT's voxels
  double input_mm3 = 0;            // solid by the CT's voxels, or enclosed by the surface; 0: unknown
  double filled_mm3 = 0;           // cavities, sum of the CT's voxels
  FilledVoids voids;               // voids that remained in the level set; also filled
  double tooth_mm3 = 0;            // sum of the CT's voxels
  double solid_mm3 = 0;            // of the level set
  Box3 box;                        // of its surface, LPS mm
  std::size_t pieces = 0;          // separate pieces of the level set
  std::size_t dropped_pieces = 0;  // small ones that were removed, in the CT and in the level set
  double dropped_mm3 = 0;
  bool mandible = false;        // true if the bone has the shape of a mandible; then the atlas was used
  std::string shape_objection;  // reason if it is not a mandible
  bool cut_by_scan = false;     // true if the bone reaches the edge of the scan or of the segmentation
  double cut_mm2 = 0;           // area in contact with the edge of the CT, also with padding; 0 without a CT
  SurfaceError surface_error;   // for a CT
  std::uint64_t active_voxels = 0;
  std::uint64_t memory_bytes = 0;  // of the bone
  double hu_voxel_mm = 0;          // of the stored CT numbers; 0: none
  HuRange hu;                      // of the stored CT numbers in the bone
  std::map<int, double> region_mm3;
  SurfaceReport surface;                                // for a closed surface
  std::vector<std::pair<std::string, double>> seconds;  // duration of each stage
};

struct ImportResult {
  Bone bone;
  ImportReport report;
};

/// Returns whether the path has the extension of a surface file.
bool IsSurfacePath(const std::string& path);

/// Imports a bone. `path`: DICOM (a folder, a DICOMDIR, a slice or a .zip), an image (.nrrd .nhdr .nii .nii.gz .mha
/// .mhd) or a closed surface (.stl .obj .ply), or empty for a bone from `options.isolate.mask` alone. The bone's
/// coordinates are the patient's (LPS, mm), or those of the surface. Throws kerf::Error with one sentence if the input
/// cannot be converted to a bone: UnclearSeries, NotHu, NotPlaced or NotIsolated if the user can help. Lets Cancelled
/// pass.
ImportResult Import(const std::string& path, const ImportOptions& options);

/// Reads the CT as Import() does, using the options of a file; sets the kind, the series and the placing in `report`.
Volume ReadCt(const std::string& path, const ImportOptions& options, ImportReport& report);

}  // namespace kerf
