// Pictures of a CT along the patient's axes. Each pixel corresponds to a point of the patient, so that coordinates can
// be read off.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bone/import/volume.h"
#include "bone/mesh/meshfile.h"

namespace kerf {

/// Viewing direction of a picture, along an axis of the patient (LPS).
enum class CtAxis {
  kX,  // sagittal, seen from the patient's left: y (to the back) to the right, z (to the head) up
  kY,  // coronal, seen from the front: x (to the patient's left) to the right, z up
  kZ   // axial, seen from the feet as in radiology: x to the right, y down
};

struct CtView {
  int columns = 0;
  int rows = 0;
  // Patient coordinates at the picture's edges, mm: y or x horizontally, z or y vertically.
  double left_mm = 0, right_mm = 0, top_mm = 0, bottom_mm = 0;
  std::vector<Rgb8> pixels;  // row by row from the top
};

/// Part of the patient that is shown, and its appearance.
struct CtViewOptions {
  Box3 box_W;                                                  // must not be empty
  double pixel_mm = 0.5;                                       // approximate edge of a pixel: the box is divided evenly
  double iso_hu = 300;                                         // voxels above this are bone, and are tinted
  std::function<std::optional<Rgb8>(const Vec3& p_W)> tint{};  // of a slice, in place of that of bone; optional
};

/// Draws the plane at `at_mm` on the axis.
CtView DrawCtSlice(const Volume& ct, CtAxis axis, double at_mm, const CtViewOptions& options);
/// Draws the bone's surface, shaded: its first point on each line of sight.
CtView DrawCtSurface(const Volume& ct, CtAxis axis, const CtViewOptions& options);

/// Range of CT numbers that is drawn from black to white, as a radiologist sets it.
struct CtGreys {
  double level_HU = 600;                // middle grey
  double width_HU = 2400;               // > 0
  std::optional<double> tinted_from{};  // voxels from this value on are tinted
};

/// Draws the plane at `at_mm` on the axis through the whole scan in greys, black outside the scan, with pixels of
/// `pixel_mm` at most, of which there are at most 8192 on a side. Takes a few milliseconds; may be called by any
/// thread.
CtView SliceVolume(const Volume& ct, CtAxis axis, double at_mm, const CtGreys& greys, double pixel_mm = 0.5);

/// Returns the box around all voxels with their full extent, LPS, mm.
Box3 CalcScanBox(const Volume& ct);

/// Returns a box around the largest piece of bone above `iso_hu` and all pieces of at least 1 cm3 whose centre lies
/// within 10 mm of its box (below it: within 60 mm). This excludes the scanner's table. The box is enlarged by 5 mm,
/// but limited to the scan. Throws kerf::Error, whose message begins with `name`, if there is no such bone.
Box3 FindBoneBox(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
