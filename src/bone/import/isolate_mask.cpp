#include "bone/import/isolate_mask.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/import/depth.h"
#include "bone/import/watershed.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr double kLeastInBone = 0.25;  // of a mask that belongs to the scan; marrow is not bone by its HU

// Returns the fraction of the mask's wanted voxels that lie outside the scan, and includes the others, and those that
// are undecided, in the box of voxels from `lower` to `upper`.
double FindMaskInScan(const Volume& ct, const BoneMask& mask, std::array<int, 3>& lower, std::array<int, 3>& upper) {
  const Volume& map = mask.tissue;
  std::size_t wanted = 0, outside = 0;
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(map.size[2]); ++k) {
    for (int j = 0; j < map.size[1]; ++j) {
      for (int i = 0; i < map.size[0]; ++i, ++v) {
        if (!IsWanted(mask.At(v)) && !IsUndecided(mask.At(v))) continue;
        const Vec3 p_V = ct.VoxelFromWorld(map.WorldFromVoxel({i, j, static_cast<double>(k)}));
        const std::array<int, 3> at = {static_cast<int>(std::lround(p_V.x)), static_cast<int>(std::lround(p_V.y)),
                                       static_cast<int>(std::lround(p_V.z))};
        wanted += IsWanted(mask.At(v)) ? 1 : 0;
        if (!ct.Contains(at)) {
          outside += IsWanted(mask.At(v)) ? 1 : 0;
          continue;
        }
        for (std::size_t a = 0; a < 3; ++a) {
          lower[a] = std::min(lower[a], at[a]);
          upper[a] = std::max(upper[a], at[a]);
        }
      }
    }
  }
  return wanted == 0 ? 1 : static_cast<double>(outside) / static_cast<double>(wanted);
}

// Returns for each voxel of a mask the depth of the middle of the thickest part that it belongs to, mm: the radius of
// the largest ball within the mask from which the voxel is less than `slack_mm` away. A bump that is lower than that is
// no part of its own.
std::vector<float> CalcThickness(const Volume& lattice, const std::vector<float>& depth_mm, double slack_mm) {
  constexpr double kRidgeSlope = 0.6;  // of the depth, 1 beside the middle of a part and less along it
  const Vec3& h = lattice.spacing_mm;
  std::vector<float> thickness_mm = depth_mm;
  const auto is_ridge = [&](int i, int j, int k, float depth) {
    for (int side = 0; side < 27; ++side) {
      const std::array<int, 3> at = {i + side % 3 - 1, j + side / 3 % 3 - 1, k + side / 9 - 1};
      if (!lattice.Contains(at)) continue;
      const double step_mm = glm::length(h * Vec3(side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1));
      if (static_cast<double>(depth_mm[lattice.Index(at[0], at[1], at[2])] - depth) > kRidgeSlope * step_mm)
        return false;
    }
    return true;
  };
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i) {
        const float depth = depth_mm[lattice.Index(i, j, k)];
        if (depth <= 0 || !is_ridge(i, j, k, depth)) continue;
        const double reach_mm = static_cast<double>(depth) + slack_mm;
        const auto from = [&](int at, int a) { return std::max(at - static_cast<int>(reach_mm / h[a]), 0); };
        const auto to = [&](int at, int a) {
          return std::min(at + static_cast<int>(reach_mm / h[a]), lattice.size[static_cast<std::size_t>(a)] - 1);
        };
        for (int z = from(k, 2); z <= to(k, 2); ++z) {
          for (int y = from(j, 1); y <= to(j, 1); ++y) {
            const double across_mm2 = std::pow(h.z * (z - k), 2) + std::pow(h.y * (y - j), 2);
            for (int x = from(i, 0); x <= to(i, 0); ++x) {
              float& here = thickness_mm[lattice.Index(x, y, z)];
              if (here >= depth || across_mm2 + std::pow(h.x * (x - i), 2) >= reach_mm * reach_mm) continue;
              here = depth;
            }
          }
        }
      }
    }
  }
  return thickness_mm;
}

// Returns the distance from the border of the mask up to which interpolation between its voxels leaves unclear on which
// side a voxel lies: 0 if the lattices have their voxels in common, or those of the mask are much smaller.
double CalcUnclear(const Volume& mask, const Volume& lattice) {
  const auto largest = [](const Vec3& h) { return std::max({h.x, h.y, h.z}); };
  const double mask_mm = largest(mask.spacing_mm), lattice_mm = largest(lattice.spacing_mm);
  if (mask_mm < 0.75 * lattice_mm) return 0;
  const auto is_at_voxel = [&](const Vec3& p_V) {
    const Vec3 at = mask.VoxelFromWorld(lattice.WorldFromVoxel(p_V));
    return glm::length(at - glm::round(at)) < 0.1;
  };
  const Vec3 last(lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1);
  const bool is_same = is_at_voxel(Vec3(0)) && is_at_voxel({last.x, 0, 0}) && is_at_voxel({0, last.y, 0}) &&
                       is_at_voxel({0, 0, last.z}) && is_at_voxel(Vec3(1));
  return is_same ? 0 : 0.5 * (mask_mm + lattice_mm);
}

}  // namespace

std::vector<std::uint8_t> MarkMask(const Volume& ct, const IsolateOptions& options, Isolation& result) {
  const BoneMask& mask = *options.mask;
  MaskUse& use = result.mask.emplace();
  use.reach_mm = options.mask_reach_mm > 0 ? options.mask_reach_mm : CalcDefaultReach(mask);
  std::array<int, 3> lower = ct.size, upper = {0, 0, 0};
  use.outside_scan = FindMaskInScan(ct, mask, lower, upper);
  if (use.outside_scan > 0.5) {
    throw Error(
        fmt::format("{:.0f} % of the wanted bone of the mask lies outside the scan; the mask belongs to another "
                    "scan, or its coordinates are in another frame",
                    100 * use.outside_scan));
  }
  // Kept bone must not reach the edge of the crop, also about keep points outside the mask.
  for (const Vec3& p_W : options.keep_W) {
    const std::array<int, 3> at = Snap(ct, options.iso_hu, p_W, "keep");
    for (std::size_t a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], at[a]);
      upper[a] = std::max(upper[a], at[a]);
    }
  }
  result.ct = CropAround(ct, lower, upper, use.reach_mm + kMargin_mm);
  const Volume& crop = result.ct;
  use.samples = SampleMask(mask, crop, use.reach_mm);
  std::size_t wanted = 0, in_bone = 0, undecided = 0;
  for (std::size_t v = 0; v < crop.count(); ++v) {
    wanted += use.samples.wanted[v];
    in_bone += use.samples.wanted[v] != 0 && crop.hu[v] >= options.iso_hu ? 1 : 0;
    undecided += use.samples.undecided[v];
  }
  if (wanted == 0) throw Error("the wanted bone of the mask is smaller than a voxel of the scan");
  use.wanted_mm3 = static_cast<double>(wanted) * crop.CalcVoxelVolume();
  use.in_bone = static_cast<double>(in_bone) / static_cast<double>(wanted);
  if (use.in_bone < kLeastInBone) {
    throw Error(
        fmt::format("only {:.0f} % of the wanted bone of the mask lies in bone above {:.0f} HU; the mask belongs "
                    "to another scan, its coordinates are in another frame, or --iso is too high",
                    100 * use.in_bone, options.iso_hu));
  }
  const std::vector<float> depth_mm = CalcDepth(crop, use.samples.wanted);
  std::vector<float> outer_mm = depth_mm;
  if (undecided > 0) {
    std::vector<std::uint8_t> either = use.samples.wanted;
    for (std::size_t v = 0; v < either.size(); ++v) either[v] |= use.samples.undecided[v];
    outer_mm = CalcDepth(crop, either);
  }
  // Where the mask is thinner than twice the reach, its middle is the marker, also where that is marrow.
  const std::vector<float> thickness_mm = CalcThickness(crop, depth_mm, use.reach_mm);
  const double unclear_mm = CalcUnclear(mask.tissue, crop);
  std::vector<std::uint8_t> markers(crop.count(), kUnmarked);
  use.certain.assign(crop.count(), 0);
  use.named = markers;
  for (std::size_t v = 0; v < crop.count(); ++v) {
    const auto depth = static_cast<double>(depth_mm[v]), outside = -static_cast<double>(outer_mm[v]);
    const bool is_bone = crop.hu[v] >= options.iso_hu;
    use.certain[v] = depth > use.reach_mm ? 1 : 0;
    if (depth > std::min(use.reach_mm, 0.5 * static_cast<double>(thickness_mm[v]))) markers[v] = kKeep;
    if (is_bone && outside > use.reach_mm) markers[v] = kDrop;
    if (!is_bone || markers[v] != kUnmarked) continue;
    if (use.samples.wanted[v] != 0) {
      if (depth > unclear_mm && options.drop_W.empty()) use.named[v] = kKeep;
    } else if (use.samples.other[v] != 0 && options.keep_W.empty() && (unclear_mm == 0 || outside > unclear_mm)) {
      use.named[v] = kDrop;
    }
  }
  result.how = fmt::format("{}, where it and the CT differ by more than {:.4g} mm", mask.how, use.reach_mm);
  return markers;
}

void GiveBack(const Isolation& result, double iso_hu, std::vector<std::uint8_t> markers,
              std::vector<std::uint8_t>& grown) {
  constexpr double kMany = 0.01;  // of the mask
  const Volume& ct = result.ct;
  const MaskUse& use = *result.mask;
  const Components given = FindComponents(ct, [&](std::size_t v) {
    return use.named[v] != kUnmarked && markers[v] == kUnmarked && grown[v] != use.named[v];
  });
  double all_mm3 = 0;
  for (const Component& part : given.list) all_mm3 += part.volume_mm3;
  if (all_mm3 == 0) return;
  // A layer of one voxel is left to the CT, unless it is much: masks leak.
  const double layer_mm = std::max({ct.spacing_mm.x, ct.spacing_mm.y, ct.spacing_mm.z});
  std::vector<bool> is_deep(given.list.size(), all_mm3 > kMany * use.wanted_mm3);
  for (const Marker side : {kKeep, kDrop}) {
    std::vector<std::uint8_t> of_side(grown.size());
    for (std::size_t v = 0; v < grown.size(); ++v) of_side[v] = grown[v] == side ? 1 : 0;
    const std::vector<float> depth_mm = CalcDepth(ct, of_side);
    for (std::size_t v = 0; v < grown.size(); ++v) {
      if (given.labels[v] == 0 || use.named[v] != side || -static_cast<double>(depth_mm[v]) <= layer_mm) continue;
      is_deep[static_cast<std::size_t>(given.labels[v] - 1)] = true;
    }
  }
  if (std::ranges::find(is_deep, true) == is_deep.end()) return;
  for (std::size_t v = 0; v < grown.size(); ++v) {
    if (given.labels[v] != 0 && is_deep[static_cast<std::size_t>(given.labels[v] - 1)]) markers[v] = use.named[v];
  }
  grown = GrowMarkers(ct, iso_hu, markers, {});
}

std::vector<std::uint8_t> FindCutOff(const Isolation& result, double iso_hu, const std::vector<std::uint8_t>& markers) {
  const Volume& ct = result.ct;
  const Components all = FindComponents(ct, [&](std::size_t v) { return ct.hu[v] >= iso_hu; });
  std::vector<bool> has_bone(all.list.size() + 1, false);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    if (result.bone[v] != 0) has_bone[all.labels[v]] = true;
  }
  std::vector<std::uint8_t> cut_off(ct.count(), 0);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    if (markers[v] != kDrop || !has_bone[all.labels[v]]) continue;
    cut_off[v] = result.bone[v] == 0 && result.mask->samples.other[v] == 0 ? 1 : 0;
  }
  return cut_off;
}

void FindGivenAway(Isolation& result, double iso_hu) {
  constexpr double kSpeck_mm3 = 10;  // noise at the border of a mask; counted, but its distance is not
  const Volume& ct = result.ct;
  MaskUse& use = *result.mask;
  use.given_away.assign(ct.count(), 0);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    use.given_away[v] = use.samples.wanted[v] != 0 && ct.hu[v] >= iso_hu && result.bone[v] == 0 ? 1 : 0;
  }
  const Components parts = FindComponents(ct, [&](std::size_t v) { return use.given_away[v] != 0; });
  if (parts.list.empty() || parts.list.front().volume_mm3 < kSpeck_mm3) return;
  const std::vector<float> depth_mm = CalcDepth(ct, result.bone);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    const std::int32_t label = parts.labels[v];
    if (label == 0 || parts.list[static_cast<std::size_t>(label - 1)].volume_mm3 < kSpeck_mm3) continue;
    use.given_away_mm = std::max(use.given_away_mm, -static_cast<double>(depth_mm[v]));
  }
}

}  // namespace kerf
