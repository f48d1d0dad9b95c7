// CT numbers in a bone, and the Young's modulus that a law computes from them.
#pragma once

#include <cstdint>
#include <functional>

#include "kerf/bone.h"

namespace kerf {

/// Edge of a voxel of CT numbers.
inline constexpr Range kHuVoxelRange_mm{0.1, 5};

/// Stores the CT numbers in the bone and at least two CT voxels around it, on a separate lattice: centres at integer
/// multiples of `voxel_mm`. `hu` returns the CT number at a world point and must be thread-safe. Throws kerf::Error
/// unless voxel_mm is in kHuVoxelRange_mm.
void SetHu(Bone& bone, const std::function<double(const Vec3&)>& hu, double voxel_mm);

/// Replaces the bone's CT numbers and their lattice with those of another bone in the same place. Throws kerf::Error if
/// that bone has none.
void CopyHu(Bone& bone, const Bone& from);

/// Statistics over the CT voxels whose centre lies in the bone and in a region whose E comes from CT numbers.
struct CtModulusReport {
  std::uint64_t voxels = 0;
  double fraction_below = 0;  // fraction with a density below the law's range, clamped to its lower end
  double fraction_above = 0;
  double E_min_MPa = 0, E_p5_MPa = 0, E_p50_MPa = 0, E_p95_MPa = 0, E_max_MPa = 0;  // all 0 if there are no such voxels
};

/// Makes E follow `law`, applied to the CT numbers and interpolated trilinearly between their voxels, in the cancellous
/// regions or in all regions; nu remains that of the region. Throws kerf::Error if the bone has no CT numbers or the
/// law has no calibration.
CtModulusReport UseCtModulus(Bone& bone, const CtLaw& law, bool all_regions);

/// Range of the CT numbers of the voxels whose centre lies in the bone, and the number of these voxels.
struct HuRange {
  std::uint64_t voxels = 0;
  double min = 0;
  double mean = 0;
  double max = 0;
};
HuRange CalcHuRange(const Bone& bone);

}  // namespace kerf
