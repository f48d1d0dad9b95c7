// The bone as a plain array, cut by brute force: the baseline for the results and the times of the fast path.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Difference between two representations of one bone.
struct DenseDifference {
  double max_phi_mm = 0;     // largest difference of phi at a voxel
  double volume_mm3 = 0;     // difference of the volumes by occupancy, other minus dense
  std::uint64_t voxels = 0;  // number of compared voxels whose phi differs
};

/// Stores phi in a box as one float for each voxel, with z as the fastest index. Uses one thread and no optimisation.
class DenseBone {
 public:
  /// Copies the voxels whose centres lie in `box_W`. Throws Error if there are none or more than 2^31.
  DenseBone(const Bone& bone, const Box3& box_W);

  double voxel_mm() const { return voxel_mm_; }
  const std::array<int, 3>& lowest() const { return lowest_; }  // index of the first voxel: its centre / voxel_mm
  const std::array<int, 3>& size() const { return size_; }
  /// Returns phi, mm, of a voxel; its index must be in the box.
  float at(int x, int y, int z) const { return phi_[Row(x, y) + static_cast<std::size_t>(z - lowest_[2])]; }

  /// Sets phi to max(phi, -distance) for every voxel in `box_W`. `distance(p_W)` is the signed distance to the removed
  /// shape, mm, negative inside.
  template <typename Distance>
  void Cut(const Box3& box_W, Distance&& distance) {
    std::array<int, 3> first;
    std::array<int, 3> last;
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = std::clamp(box_W.lower[axis] / voxel_mm_, -1e9, 1e9);
      const double upper = std::clamp(box_W.upper[axis] / voxel_mm_, -1e9, 1e9);
      first[axis] = std::max(lowest_[axis], static_cast<int>(std::floor(lower)));
      last[axis] = std::min(lowest_[axis] + size_[axis] - 1, static_cast<int>(std::ceil(upper)));
    }
    for (int x = first[0]; x <= last[0]; ++x) {
      for (int y = first[1]; y <= last[1]; ++y) {
        float* row = &phi_[Row(x, y)];
        for (int z = first[2]; z <= last[2]; ++z) {
          const double d = distance(Vec3(x, y, z) * voxel_mm_);
          float& phi = row[z - lowest_[2]];
          phi = std::max(phi, static_cast<float>(std::min(-d, band_mm_)));
        }
      }
    }
  }

  /// Removes the sweep of the tool along the straight path from X_from to X_to. A disc has the orientation of X_to and
  /// moves in its own plane; the caller's substeps handle the motion along its spindle, as in Cutter.
  void Cut(const Tool& tool, const Pose& X_from, const Pose& X_to);

  /// Returns the sum of clamp(1/2 - phi/h, 0, 1) h^3 over the box.
  double CalcOccupancy_mm3() const;
  /// Compares with the same voxels of a bone on the same grid. phi is compared where one of the two is within `near_mm`
  /// of the surface, the volume everywhere.
  DenseDifference Compare(const Bone& other, double near_mm = std::numeric_limits<double>::infinity()) const;
  std::size_t CalcMemoryBytes() const { return phi_.capacity() * sizeof(float); }

 private:
  std::size_t Row(int x, int y) const {
    return (static_cast<std::size_t>(x - lowest_[0]) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(y - lowest_[1])) *
           static_cast<std::size_t>(size_[2]);
  }

  double voxel_mm_;
  double band_mm_;
  std::array<int, 3> lowest_{};
  std::array<int, 3> size_{};
  std::vector<float> phi_;
};

/// Returns the distance to the sweep of a ball along a straight line from `from_W` to `to_W`, which is a capsule, mm.
double CalcBallSweepDistance(const Vec3& p_W, const Vec3& from_W, const Vec3& to_W, double radius_mm);
/// Returns the distance to the sweep of a disc that moves in its own plane, mm. It starts at the centre of X_from,
/// projected into the plane of X_to, and ends at X_to.
double CalcDiscSweepDistance(const Vec3& p_W, const Pose& X_from, const Pose& X_to, double radius_mm,
                             double thickness_mm);

}  // namespace kerf
