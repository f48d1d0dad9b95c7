// The isolated bone of a CT as a solid: smooth, and finer than its voxels.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bone/grid/build.h"
#include "bone/import/isolate.h"
#include "bone/import/spline_field.h"

namespace kerf {

/// Inside is where the HU, interpolated by cubic B-splines, are above iso, on the wanted side of the smoothed border to
/// what was dropped. HU of coarse or unequally spaced voxels are first limited to a range around iso and blurred along
/// the finer axes: see docs/import.md. Thread-safe once made.
class CtSolid {
 public:
  /// `cavities` are filled: their voxels are raised to `fill_hu`.
  CtSolid(const Isolation& isolation, const std::vector<std::uint8_t>& cavities, double iso_hu, double fill_hu);

  double Value(const Vec3& p_W) const;  // negative inside; of no unit
  BlockClass Classify(const Vec3& centre_W, double radius_mm) const;
  /// The CT's HU with the cavities raised, neither limited nor blurred.
  const SplineField& hu() const { return *hu_; }
  /// The HU whose iso level is the surface.
  double SurfaceHu(const Vec3& p_W) const { return surface_hu_->At(VoxelFromWorld(p_W)); }
  double Hu(const Vec3& p_W) const { return hu_->At(VoxelFromWorld(p_W)); }
  double iso_hu() const { return iso_hu_; }
  /// Box around the solid's voxels with a margin of three of them, LPS mm.
  const Box3& box() const { return box_; }

 private:
  Vec3 VoxelFromWorld(const Vec3& p_W) const { return voxel_from_world_ * (p_W - origin_W_); }

  double iso_hu_;
  Vec3 origin_W_;
  glm::dmat3 voxel_from_world_{1};
  Vec3 reach_V_{0};  // half extent, in voxels, of the box around a ball of 1 mm
  Box3 box_;
  std::shared_ptr<SplineField> hu_;
  std::shared_ptr<SplineField> surface_hu_;  // hu_ itself for a CT that is fine and equally spaced
  std::unique_ptr<SplineField> wanted_;      // 1 on the wanted side, 0 on the other
};

}  // namespace kerf
