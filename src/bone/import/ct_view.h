// Pictures of a CT along the patient's axes: each pixel is a point of the patient, so that coordinates can be read off.
#pragma once

#include <string>
#include <vector>

#include "bone/import/volume.h"
#include "bone/mesh/meshfile.h"

namespace kerf {

/// The patient's axis (LPS) that a picture looks along.
enum class CtAxis {
  kX,  // sagittal, seen from the patient's left: y (to the back) goes right, z (to the head) up
  kY,  // coronal, seen from the front: x (to the patient's left) goes right, z up
  kZ   // axial, seen from the feet as radiologists do: x goes right, y down
};

struct CtView {
  int columns = 0;
  int rows = 0;
  // Patient coordinates at the picture's edges, mm: of y or x across, of z or y down.
  double left_mm = 0, right_mm = 0, top_mm = 0, bottom_mm = 0;
  std::vector<Rgb8> pixels;  // rows from the top
};

/// Which part of the patient is shown, and how.
struct CtViewOptions {
  Box3 box_W;             // not empty
  double pixel_mm = 0.5;  // edge of a pixel, about: the box is divided evenly
  double iso_hu = 300;    // what is above is bone, and tinted
};

/// The plane at `at_mm` of the axis.
CtView DrawCtSlice(const Volume& ct, CtAxis axis, double at_mm, const CtViewOptions& options);
/// The bone's surface, shaded: the first of it that meets the eye.
CtView DrawCtSurface(const Volume& ct, CtAxis axis, const CtViewOptions& options);

/// A box around the largest piece of bone above `iso_hu` and those of 1 cm3 and more that have their middle within
/// 10 mm of its box or below it, so that the table is left out; 5 mm larger, but within the scan. Throws Error, which
/// begins with `name`, when there is no such bone.
Box3 FindBoneBox(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
