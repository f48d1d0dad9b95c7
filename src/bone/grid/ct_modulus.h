// CT numbers in a bone, and the modulus that a law makes of them.
#pragma once

#include <cstdint>
#include <functional>

#include "kerf/bone.h"

namespace kerf {

/// Stores the CT numbers at and within two voxels around the bone, on a lattice of its own: centres at integer
/// multiples of `voxel_mm`. `hu` gives them at world points and must be thread-safe. Throws Error when voxel_mm is not
/// within 0.05 to 10.
void SetHu(Bone& bone, const std::function<double(const Vec3&)>& hu, double voxel_mm);

/// Those of another bone in the same place, lattice and all. Throws Error when it has none.
void TakeHu(Bone& bone, const Bone& from);

/// Over the CT voxels with their centre in the bone and in a region that takes its E from them.
struct CtModulusReport {
  std::uint64_t voxels = 0;
  double share_below = 0;  // of them: density under the law's range, held to its lower end
  double share_above = 0;
  double E_min_MPa = 0, E_p5_MPa = 0, E_p50_MPa = 0, E_p95_MPa = 0, E_max_MPa = 0;  // 0 when there are none
};

/// From here on E is `law` of the CT numbers, trilinear between their voxels, in the cancellous regions or in all; nu
/// stays the region's own. Throws Error when the bone has no CT numbers or the law no calibration.
CtModulusReport UseCtModulus(Bone& bone, const CtLaw& law, bool all_regions);

/// Smallest and largest CT number with its voxel's centre in the bone, and how many there are.
struct HuRange {
  std::uint64_t voxels = 0;
  double min = 0;
  double mean = 0;
  double max = 0;
};
HuRange CalcHuRange(const Bone& bone);

}  // namespace kerf
