#include "bone/import/mask_overlay.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {

std::vector<std::uint8_t> FindAdded(const Isolation& isolation, const std::vector<std::uint8_t>& solid, double iso_hu) {
  std::vector<std::uint8_t> added(solid.size(), 0);
  for (std::size_t v = 0; v < solid.size(); ++v) {
    added[v] = solid[v] == 0 && isolation.mask->certain[v] != 0 && isolation.ct.hu[v] < iso_hu ? 1 : 0;
  }
  return added;
}

MaskOverlay::MaskOverlay(const Volume& ct, const ImportOptions& options)
    : isolation_(Isolate(ct, options.isolate, {})) {
  std::vector<std::uint8_t> solid = isolation_.bone;
  const std::vector<std::uint8_t> cavities = FindCavities(isolation_.ct, isolation_.bone, options.cavities, {});
  for (std::size_t v = 0; v < solid.size(); ++v) solid[v] |= cavities[v];
  added_ = FindAdded(isolation_, solid, options.isolate.iso_hu);
  const auto volume_mm3 = [&](const std::vector<std::uint8_t>& voxels) {
    return static_cast<double>(std::count(voxels.begin(), voxels.end(), 1)) * isolation_.ct.CalcVoxelVolume();
  };
  added_mm3_ = volume_mm3(added_);
  cut_off_mm3_ = volume_mm3(isolation_.mask->cut_off);
  given_away_mm3_ = volume_mm3(isolation_.mask->given_away);
}

std::optional<std::size_t> MaskOverlay::FindVoxel(const Vec3& p_W) const {
  const Vec3 p_V = isolation_.ct.VoxelFromWorld(p_W);
  const std::array<int, 3> at{static_cast<int>(std::lround(p_V.x)), static_cast<int>(std::lround(p_V.y)),
                              static_cast<int>(std::lround(p_V.z))};
  if (!isolation_.ct.Contains(at)) return std::nullopt;
  return isolation_.ct.Index(at[0], at[1], at[2]);
}

MaskOverlay::What MaskOverlay::At(const Vec3& p_W) const {
  const std::optional<std::size_t> v = FindVoxel(p_W);
  if (!v) return What::kNothing;
  if (added_[*v] != 0) return What::kAdded;
  if (isolation_.mask->cut_off[*v] != 0) return What::kCutOff;
  if (isolation_.mask->given_away[*v] != 0) return What::kGivenAway;
  return isolation_.bone[*v] != 0 ? What::kKept : What::kNothing;
}

bool MaskOverlay::IsInMask(const Vec3& p_W) const {
  const std::optional<std::size_t> v = FindVoxel(p_W);
  return v && isolation_.mask->samples.wanted[*v] != 0;
}

}  // namespace kerf
