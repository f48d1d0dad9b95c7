#include "import/ct_solid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {

namespace {

constexpr double kHuScale = 1000;  // makes the two parts of the value alike in slope
constexpr double kBoxMargin_vox = 3;

// One pass of the binomial filter (1 2 1)/4 along each axis: with the spline's own smoothing, 0.9 voxels.
void Smooth(const std::array<int, 3>& size, std::vector<float>& values) {
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(size[0]),
                                             static_cast<std::size_t>(size[0]) * size[1]};
  std::vector<float> line;
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3;
    const int c = (axis + 2) % 3;
    const int n = size[axis];
    line.resize(static_cast<std::size_t>(n));
    for (int q = 0; q < size[c]; ++q) {
      for (int p = 0; p < size[b]; ++p) {
        float* start = &values[static_cast<std::size_t>(p) * stride[b] + static_cast<std::size_t>(q) * stride[c]];
        for (int i = 0; i < n; ++i) line[i] = start[static_cast<std::size_t>(i) * stride[axis]];
        for (int i = 0; i < n; ++i) {
          start[static_cast<std::size_t>(i) * stride[axis]] =
              0.25f * line[std::max(i - 1, 0)] + 0.5f * line[i] + 0.25f * line[std::min(i + 1, n - 1)];
        }
      }
    }
  }
}

}  // namespace

CtSolid::CtSolid(const Isolation& isolation, const std::vector<std::uint8_t>& cavities, double iso_hu, double fill_hu)
    : iso_hu_(iso_hu), origin_W_(isolation.ct.origin_W) {
  const Volume& ct = isolation.ct;
  const glm::dmat3 inverse = glm::inverse(ct.axes_W);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      voxel_from_world_[column][row] = inverse[column][row] / ct.spacing_mm[row];
    // The ball's image is an ellipsoid; its extent along a voxel axis is the length of that row.
    reach_V_[row] = glm::length(Vec3(voxel_from_world_[0][row], voxel_from_world_[1][row], voxel_from_world_[2][row]));
  }
  std::vector<float> hu(ct.count());
  std::vector<float> wanted(ct.count());
  for (std::size_t v = 0; v < hu.size(); ++v) {
    const bool cavity = cavities[v] != 0;
    hu[v] = cavity ? std::max(static_cast<float>(ct.hu[v]), static_cast<float>(fill_hu)) : static_cast<float>(ct.hu[v]);
    wanted[v] = isolation.keep[v] != 0 || cavity ? 1.0f : 0.0f;
  }
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        if (isolation.bone[ct.Index(i, j, k)] == 0) continue;
        for (int corner = 0; corner < 8; ++corner) {
          const double m = kBoxMargin_vox;
          box_.Include(ct.WorldFromVoxel(
              {i + ((corner & 1) != 0 ? m : -m), j + ((corner & 2) != 0 ? m : -m), k + ((corner & 4) != 0 ? m : -m)}));
        }
      }
    }
  }
  Smooth(ct.size, wanted);
  hu_ = std::make_unique<SplineField>(ct.size, std::move(hu), true);
  wanted_ = std::make_unique<SplineField>(ct.size, std::move(wanted), false);
}

double CtSolid::Value(const Vec3& p_W) const {
  const Vec3 p_V = VoxelFromWorld(p_W);
  const double by_hu = (iso_hu_ - hu_->At(p_V)) / kHuScale;
  const double by_side = 0.5 - wanted_->At(p_V);
  return std::max(by_hu, by_side);
}

BlockClass CtSolid::Classify(const Vec3& centre_W, double radius_mm) const {
  const Vec3 p_V = VoxelFromWorld(centre_W);
  const Vec3 r_V = radius_mm * reach_V_;
  const SplineField::Bounds hu = hu_->CalcBounds(p_V - r_V, p_V + r_V);
  if (hu.upper < iso_hu_) return BlockClass::kOutside;
  const SplineField::Bounds side = wanted_->CalcBounds(p_V - r_V, p_V + r_V);
  if (side.upper < 0.5) return BlockClass::kOutside;
  return hu.lower > iso_hu_ && side.lower > 0.5 ? BlockClass::kInside : BlockClass::kMixed;
}

}  // namespace kerf
