// Three slices of the CT through the blade, as pictures.
#pragma once

#include <array>
#include <string>

#include "kerf/bone.h"
#include "kerf/tool.h"
#include "view/picture/image.h"

namespace kerf {

/// CT numbers from black to white.
struct CtWindow {
  double level_HU = 600;
  double width_HU = 2400;  // > 0
};

struct CtSlice {
  std::string name;  // "blade plane", "across, upright", "across, level"
  Image image;       // grey, the bone's outline and the tool's cross-section drawn in
  double edge_mm = 0;
  Vec3 right_W{1, 0, 0};  // unit, of the picture
  Vec3 up_W{0, 0, 1};
  std::string right_letter;  // the patient's side that the right edge is nearest to: L, R, A, P, S or I
  std::string up_letter;
};

struct CtSlices {
  std::array<CtSlice, 3> slices;  // the blade's plane; two at right angles to it through the tool's centre
};

/// `bone` must have CT numbers, and its level set is what is left of it. Squares of `edge_mm` with `pixels` a side
/// about the tool's centre. Pure.
CtSlices CalcCtSlices(const Bone& bone, const Tool& tool, const Pose& X_WT, double edge_mm, int pixels,
                      const CtWindow& window = {});

}  // namespace kerf
