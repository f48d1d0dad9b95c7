// Material in front of the blade: from the paper's table, or from a bone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "kerf/error.h"
#include "kerf/slab.h"

namespace kerf {
namespace {

/// Sums over the area of one step of depth.
struct Row {
  std::map<int, std::size_t> samples_by_region;
  std::size_t samples = 0;
  std::size_t with_material = 0;
  double E_sum_MPa = 0;
  double nu_sum = 0;
};

void Add(Row& row, const Bone& bone, const Vec3& p_W) {
  ++row.samples;
  const double E_MPa = bone.ModulusAt(p_W);
  if (!(E_MPa > 0)) return;
  ++row.samples_by_region[bone.RegionAt(p_W)];
  ++row.with_material;
  row.E_sum_MPa += E_MPa;
  row.nu_sum += bone.PoissonRatioAt(p_W);
}

SlabProfile::Layer MakeLayer(double top_mm, const Row& row) {
  SlabProfile::Layer layer;
  layer.top_mm = top_mm;
  if (row.with_material == 0) return layer;
  std::size_t max_count = 0;
  for (const auto& [region, count] : row.samples_by_region) {
    if (count > max_count) {
      max_count = count;
      layer.region = region;
    }
  }
  layer.E_MPa = row.E_sum_MPa / static_cast<double>(row.with_material);
  layer.nu = row.nu_sum / static_cast<double>(row.with_material);
  return layer;
}

bool SameMaterial(const SlabProfile::Layer& a, const SlabProfile::Layer& b) {
  return a.region == b.region && a.E_MPa == b.E_MPa && a.nu == b.nu;
}

}  // namespace

const SlabProfile::Layer* SlabProfile::Find(double depth_mm) const {
  if (!(depth_mm >= 0 && depth_mm <= end_mm)) return nullptr;
  const auto after = std::upper_bound(layers.begin(), layers.end(), depth_mm,
                                      [](double depth, const Layer& layer) { return depth < layer.top_mm; });
  return after == layers.begin() ? nullptr : &*std::prev(after);
}

SlabProfile MakePaperProfile(const MaterialTable& materials, double entry_mm) {
  constexpr std::array<int, 4> kRegions{24, 21, 13, 6};
  constexpr std::array<double, 4> kTops_mm{0, 7.5, 17.5, 20};
  SlabProfile profile;
  for (std::size_t i = 0; i < kRegions.size(); ++i) {
    if (!materials.Contains(kRegions[i])) {
      throw Error(fmt::format("the table of regions has no row {}, which the paper's Table 2 uses", kRegions[i]));
    }
    const Region& region = materials.At(kRegions[i]);
    profile.layers.push_back({kTops_mm[i], region.id, region.E_MPa, region.nu});
  }
  profile.end_mm = 32.5;
  profile.entry_mm = entry_mm;
  return profile;
}

SlabProfile MakeBoneProfile(const Bone& bone, const CutPlane& plane, double thickness_mm, const Vec3& direction_W,
                            double reach_mm) {
  const double step = 0.25 * bone.voxel_mm();
  const double across_step = bone.voxel_mm();
  const Vec3 across_W = glm::cross(plane.normal_W, direction_W);
  // Range of the bone's box along the direction.
  const Box3 box = bone.CalcBounds();
  if (box.empty()) throw Error("the bone is empty, so there is nothing to slice");
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? box.upper.x : box.lower.x, (corner & 2) ? box.upper.y : box.lower.y,
                 (corner & 4) ? box.upper.z : box.lower.z);
    lowest = std::min(lowest, glm::dot(p, direction_W));
    highest = std::max(highest, glm::dot(p, direction_W));
  }
  lowest -= bone.voxel_mm();
  const auto rows_count = static_cast<std::size_t>(std::ceil((highest + bone.voxel_mm() - lowest) / step));
  std::vector<Row> rows(rows_count);
  const int across_count = static_cast<int>(std::floor(reach_mm / across_step));
  const double base = glm::dot(plane.p_W, direction_W);
  for (int side = -1; side <= 1; ++side) {
    for (int j = -across_count; j <= across_count; ++j) {
      const Vec3 foot_W = plane.p_W + (side * thickness_mm / 3) * plane.normal_W + (j * across_step) * across_W;
      for (std::size_t i = 0; i < rows_count; ++i) {
        const double along = lowest + (static_cast<double>(i) + 0.5) * step;
        const Vec3 p_W = foot_W + (along - base) * direction_W;
        const double distance = bone.SignedDistance(p_W);
        if (distance < 0) {
          Add(rows[i], bone, p_W);
        } else if (distance > 2 * step) {
          // No bone is nearer than this distance. Only 0.7 of it is skipped, because a stored distance has an error of
          // a fifth of a voxel.
          i += static_cast<std::size_t>(std::max(0.0, std::floor(0.7 * distance / step) - 1));
        }
      }
    }
  }
  const auto has_bone = [](const Row& row) { return row.samples > 0; };
  const auto first = std::find_if(rows.begin(), rows.end(), has_bone);
  if (first == rows.end()) throw Error("the cut plane does not intersect any bone within the disc's reach");
  const auto last = std::find_if(rows.rbegin(), rows.rend(), has_bone).base();

  SlabProfile profile;
  profile.entry_mm = lowest + static_cast<double>(first - rows.begin()) * step;
  profile.end_mm = static_cast<double>(last - first) * step;
  std::size_t samples = 0;
  for (auto row = first; row != last; ++row) {
    samples += row->samples;
    const SlabProfile::Layer layer = MakeLayer(static_cast<double>(row - first) * step, *row);
    if (profile.layers.empty() || !SameMaterial(profile.layers.back(), layer)) profile.layers.push_back(layer);
  }
  profile.slice_mm3 = static_cast<double>(samples) / 3 * step * across_step * thickness_mm;
  return profile;
}

}  // namespace kerf
