// The isolated bone of a CT as a smooth solid, resolved more finely than the CT's voxels.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bone/grid/build.h"
#include "bone/import/isolate.h"
#include "bone/import/leaf_positions.h"
#include "bone/import/spline_field.h"

namespace kerf {

/// A point is inside if the HU there, interpolated by cubic B-splines, are above iso and the point is on the wanted
/// side of the smoothed border to the dropped bone. If voxels are coarse or unequally spaced, the HU are first limited
/// to a range around iso and blurred along the finer axes (docs/import.md). Thread-safe once constructed.
class CtSolid {
 public:
  /// `cavities` are filled: their voxels are raised to at least `fill_hu`.
  CtSolid(const Isolation& isolation, const std::vector<std::uint8_t>& cavities, double iso_hu, double fill_hu);

  double Value(const Vec3& p_W) const;  // negative inside; dimensionless
  /// Sets the values at the voxels of a leaf to those of Value(), bit for bit. Only if map().HasPositions().
  void EvaluateLeaf(const LeafPlace& leaf, LeafValues& values) const;
  BlockClass Classify(const Vec3& centre_W, double radius_mm) const;
  /// The CT's HU with the cavities raised, neither limited nor blurred.
  const SplineField& hu() const { return *hu_; }
  /// The HU whose iso level is the surface.
  double SurfaceHu(const Vec3& p_W) const { return surface_hu_->At(map_.VoxelFromWorld(p_W)); }
  double Hu(const Vec3& p_W) const { return hu_->At(map_.VoxelFromWorld(p_W)); }
  const LatticeMap& map() const { return map_; }
  double iso_hu() const { return iso_hu_; }
  /// Box around the solid's voxels with a margin of three voxels, LPS, mm.
  const Box3& box() const { return box_; }

 private:
  double iso_hu_;
  LatticeMap map_;
  LatticeMap side_map_;                // of the border to the dropped bone
  Vec3 reach_V_{0}, side_reach_V_{0};  // half extent, in voxels, of the box around a ball of radius 1 mm
  Box3 box_;
  std::shared_ptr<SplineField> hu_;
  std::shared_ptr<SplineField> surface_hu_;  // the same as hu_ for a CT that is fine and equally spaced
  std::unique_ptr<SplineField> wanted_;      // 1 on the wanted side, 0 on the other
};

}  // namespace kerf
