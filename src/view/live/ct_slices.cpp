#include "view/live/ct_slices.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/grid/grids.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr Rgb8 kOutline{255, 200, 40};
constexpr Rgb8 kToolOutline{80, 200, 255};

std::string LetterOf(const Vec3& direction) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(direction[i]) > std::abs(direction[axis])) axis = i;
  }
  constexpr const char* kLetters[3][2] = {{"R", "L"}, {"A", "P"}, {"I", "S"}};
  return kLetters[axis][direction[axis] > 0 ? 1 : 0];
}

// Returns the signed distance to the tool, negative inside; for a disc, without its teeth.
double ToolDistance(const Tool& tool, const Vec3& p_T) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    return std::max(std::hypot(p_T.x, p_T.y) - disc->radius_mm(), std::abs(p_T.z) - 0.5 * disc->thickness_mm);
  }
  return glm::length(p_T) - std::get<BallBurr>(tool).radius_mm();
}

CtSlice MakeSlice(const std::string& name, const Bone& bone, const Tool& tool, const Pose& X_WT, const Vec3& right_T,
                  const Vec3& up_T, double edge_mm, int pixels, const CtWindow& window) {
  CtSlice slice;
  slice.name = name;
  slice.edge_mm = edge_mm;
  slice.right_W = X_WT.Vector(right_T);
  slice.up_W = X_WT.Vector(up_T);
  slice.right_letter = LetterOf(slice.right_W);
  slice.up_letter = LetterOf(slice.up_W);
  slice.image.width = pixels;
  slice.image.height = pixels;
  slice.image.pixels.resize(static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels));
  const Bone::Grids& grids = bone.grids();
  auto hu = grids.hu->getConstAccessor();
  auto phi = grids.phi->getConstAccessor();
  const double hu_mm = grids.hu->voxelSize()[0];
  const double phi_mm = grids.voxel_mm();
  const double pixel_mm = edge_mm / pixels;
  for (int row = 0; row < pixels; ++row) {
    for (int column = 0; column < pixels; ++column) {
      const double a = (column + 0.5) * pixel_mm - 0.5 * edge_mm;
      const double b = 0.5 * edge_mm - (row + 0.5) * pixel_mm;
      const Vec3 p_T = a * right_T + b * up_T;
      const Vec3 p_W = X_WT.Point(p_T);
      const double value = SampleTrilinear(hu, p_W / hu_mm);
      const double grey = 255 * std::clamp((value - window.level_HU) / window.width_HU + 0.5, 0.0, 1.0);
      const auto g = static_cast<std::uint8_t>(grey + 0.5);
      Rgb8 colour{g, g, g};
      // Lines are 1.5 pixels wide.
      if (std::abs(SampleTrilinear(phi, p_W / phi_mm)) < 0.75 * pixel_mm) colour = kOutline;
      // A blade thinner than a pixel is drawn as one line.
      const double to_tool = ToolDistance(tool, p_T);
      if (std::abs(to_tool) < 0.75 * pixel_mm) colour = kToolOutline;
      slice.image
          .pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(pixels) + static_cast<std::size_t>(column)] =
          colour;
    }
  }
  return slice;
}

}  // namespace

CtSlices CalcCtSlices(const Bone& bone, const Tool& tool, const Pose& X_WT, double edge_mm, int pixels,
                      const CtWindow& window) {
  if (!bone.has_hu()) throw Error("the bone has no CT numbers, so slices can't be shown");
  if (!(edge_mm > 0) || pixels < 8 || pixels > 1024 || !(window.width_HU > 0)) {
    throw Error("CT slices must have an edge above 0 mm, 8 to 1024 pixels and a window wider than 0 HU");
  }
  const auto make = [&](const char* name, const Vec3& right_T, const Vec3& up_T) {
    return MakeSlice(name, bone, tool, X_WT, right_T, up_T, edge_mm, pixels, window);
  };
  // In the blade's plane, the direction closest to the patient's upright points up.
  const Vec3 z_T = X_WT.InverseVector({0, 0, 1});
  Vec3 up_T{z_T.x, z_T.y, 0};
  up_T = glm::length(up_T) > 0.1 ? glm::normalize(up_T) : Vec3{0, 1, 0};
  const Vec3 side_T = glm::cross(up_T, Vec3{0, 0, 1});
  return {{make("blade plane", side_T, up_T), make("across, upright", {0, 0, 1}, up_T),
           make("across, level", {0, 0, 1}, side_T)}};
}

}  // namespace kerf
