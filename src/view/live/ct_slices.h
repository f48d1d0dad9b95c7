// Three slices of the CT through the blade, as images.
#pragma once

#include <array>
#include <string>

#include "kerf/bone.h"
#include "kerf/tool.h"
#include "view/picture/image.h"

namespace kerf {

/// Window of CT numbers that is mapped from black to white.
struct CtWindow {
  double level_HU = 600;
  double width_HU = 2400;  // > 0
};

struct CtSlice {
  std::string name;  // "blade plane", "across, upright", "across, level"
  Image image;       // grey, with the bone's outline and the tool's cross-section
  double edge_mm = 0;
  Vec3 right_W{1, 0, 0};  // unit, the image's right direction
  Vec3 up_W{0, 0, 1};
  std::string right_letter;  // patient's side closest to the right edge: L, R, A, P, S or I
  std::string up_letter;
};

struct CtSlices {
  std::array<CtSlice, 3> slices;  // the blade's plane, and two planes perpendicular to it through the tool's centre
};

/// Computes three square slices of `edge_mm` with `pixels` per side, centred on the tool. `bone` must have CT numbers;
/// its level set is the remaining bone. Pure.
CtSlices CalcCtSlices(const Bone& bone, const Tool& tool, const Pose& X_WT, double edge_mm, int pixels,
                      const CtWindow& window = {});

}  // namespace kerf
