// `kerf slab`: writes the three parts of a slab cut and reports on them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bone/grid/slab_parts.h"
#include "view/picture/image.h"

namespace kerf {

inline constexpr double kCrumbFraction = 0.001;
/// Colours of left, slice and right. The segments are pale, so that their shape is visible. The colours are
/// distinguishable with red-green colour blindness.
inline constexpr Rgb8 kPartColours[] = {{158, 196, 224}, {230, 120, 30}, {238, 214, 150}};

struct PartFile {
  std::string name;  // left, slice, right
  double volume_mm3 = 0;
  Box3 bounds_W;
  std::size_t pieces = 0;  // of at least kCrumbFraction of the part's volume
  std::size_t crumbs = 0;  // smaller ones
  double crumbs_mm3 = 0;   // total
  double voxel_mm = 0;
  // Properties of the surface, as read back from the file if one was written.
  std::size_t triangles = 0;
  double surface_volume_mm3 = 0;
  std::size_t open_edges = 0;
  std::vector<std::string> files;  // in the folder
};

struct PartsReport {
  std::string bone;
  double whole_mm3 = 0;
  double sum_mm3 = 0;
  CutPlane plane;
  double thickness_mm = 0;           // as requested
  double measured_thickness_mm = 0;  // between the two faces of the slice's surface
  double section_mm2 = 0;            // of the bone at the plane: the slice's volume / its thickness
  double left_face_mm2 = 0;          // flat part of the slice's surface; its rim is bevelled by about a voxel
  double right_face_mm2 = 0;
  std::size_t places = 0;
  std::size_t cut_places = 0;
  double distance_mm = 0;
  std::vector<PartFile> parts;
  std::vector<std::string> files;  // other files in the folder

  double CalcDifferencePercent() const { return 100 * (sum_mm3 / whole_mm3 - 1); }
};

struct PartsOptions {
  std::string bone_file;   // never overwritten
  std::string plane_file;  // likewise; optional
  std::string folder;
  bool obj = true;
  bool stl = true;
  bool vdb = true;
  bool picture = true;
  std::size_t triangles = 0;  // maximum per part's surface; 0: unlimited
  std::function<void(double)> progress;
};

/// Cuts the bone and writes left, slice and right (.obj, .stl, .vdb), parts.json and parts.png. Throws kerf::Error if
/// the cut cannot be made, if a file cannot be written, or if a file would replace the bone's or the plane's file; in
/// the last case nothing has been written.
PartsReport CutAndWriteParts(const Bone& bone, const SlabCut& cut, const PartsOptions& options);

/// Returns JSON with stable keys that include the units (docs/slab.md).
std::string FormatPartsJson(const PartsReport& report);

/// Flat faces of a slice's surface: the triangles within a degree of the plane.
struct SliceFaces {
  double left_mm = 0;  // position of the face along the normal, from the plane: area-weighted median
  double right_mm = 0;
  double left_mm2 = 0;
  double right_mm2 = 0;
};
SliceFaces MeasureSliceFaces(const TriangleMesh& slice_W, const CutPlane& plane);

}  // namespace kerf
