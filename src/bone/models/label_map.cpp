#include "kerf/label_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bone/grid/build.h"
#include "bone/grid/interpolate.h"
#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kBandVoxels = 3;

/// The regions of a label map on a lattice with a margin of one voxel without bone.
class LabelSolid {
 public:
  LabelSolid(const LabelMap& map, const std::map<int, int>& region_of_label) : map_(map) {
    std::array<std::uint8_t, 256> region{};
    for (const auto& [label, id] : region_of_label)
      region[static_cast<std::size_t>(label)] = static_cast<std::uint8_t>(id);
    for (int axis = 0; axis < 3; ++axis) size_[axis] = map.size[axis] + 2;
    regions_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], 0);
    for (int k = 0; k < map.size[2]; ++k) {
      for (int j = 0; j < map.size[1]; ++j) {
        for (int i = 0; i < map.size[0]; ++i) {
          const std::size_t from =
              i + static_cast<std::size_t>(map.size[0]) * (j + static_cast<std::size_t>(map.size[1]) * k);
          regions_[Index(i + 1, j + 1, k + 1)] = region[map.labels[from]];
        }
      }
    }
    SumUp();
  }

  bool empty() const { return sums_.back() == 0; }

  Box3 CalcBounds() const {
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 p{0};
      for (int axis = 0; axis < 3; ++axis) p[axis] = (corner >> axis & 1) * (size_[axis] - 1.0) - 1;
      box.Include(map_.X_WL.Point(p * map_.spacing_mm));
    }
    return box;
  }

  /// Fraction of bone subtracted from 1/2, interpolated between voxel centres.
  double CalcValue(const Vec3& p_W) const {
    const CellPoint cell = FindCell(ToVoxels(p_W));
    CellValues<float> bone{};
    for (int corner = 0; corner < 8; ++corner) {
      bone[static_cast<std::size_t>(corner)] =
          RegionOf(cell.x + (corner >> 2 & 1), cell.y + (corner >> 1 & 1), cell.z + (corner & 1)) != 0 ? 1.0F : 0.0F;
    }
    return 0.5 - Interpolate(bone, cell.f);
  }

  BlockClass Classify(const Vec3& centre_W, double radius_mm) const {
    const Vec3 centre = ToVoxels(centre_W);
    std::array<int, 3> lower{}, upper{};
    bool beyond = false;
    for (int axis = 0; axis < 3; ++axis) {
      const double reach = radius_mm / map_.spacing_mm[axis];
      const double first = std::floor(centre[axis] - reach), last = std::ceil(centre[axis] + reach);
      beyond = beyond || first < 0 || last > size_[axis] - 1;
      lower[axis] = static_cast<int>(std::clamp(first, 0.0, size_[axis] - 1.0));
      upper[axis] = static_cast<int>(std::clamp(last, 0.0, size_[axis] - 1.0));
    }
    const std::uint64_t bone = CountBone(lower, upper);
    if (bone == 0) return BlockClass::kOutside;
    const std::uint64_t all =
        static_cast<std::uint64_t>(upper[0] - lower[0] + 1) * (upper[1] - lower[1] + 1) * (upper[2] - lower[2] + 1);
    return bone == all && !beyond ? BlockClass::kInside : BlockClass::kMixed;
  }

  /// Gives voxels without bone the region of a neighbour with bone, out to `reach_mm`, so that a tooth that touches the
  /// surface finds a material. Call after the counts are no longer needed for the surface.
  std::vector<std::uint8_t> GrowRegions(double reach_mm) const {
    std::vector<std::uint8_t> grown = regions_;
    const double least_mm = std::min({map_.spacing_mm.x, map_.spacing_mm.y, map_.spacing_mm.z});
    for (int step = 0; step < static_cast<int>(std::ceil(reach_mm / least_mm)) + 1; ++step) {
      for (int axis = 0; axis < 3; ++axis) GrowAlong(axis, grown);
    }
    return grown;
  }
  int RegionAt(const std::vector<std::uint8_t>& grown, const Vec3& p_W) const {
    const Vec3 p = ToVoxels(p_W);
    std::array<int, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<int>(std::clamp(std::round(p[axis]), 0.0, size_[axis] - 1.0));
    return grown[Index(at[0], at[1], at[2])];
  }

 private:
  std::size_t Index(int i, int j, int k) const {
    return i + static_cast<std::size_t>(size_[0]) * (j + static_cast<std::size_t>(size_[1]) * k);
  }
  Vec3 ToVoxels(const Vec3& p_W) const { return map_.X_WL.InversePoint(p_W) / map_.spacing_mm + Vec3{1}; }
  int RegionOf(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || i >= size_[0] || j >= size_[1] || k >= size_[2]) return 0;
    return regions_[Index(i, j, k)];
  }
  /// Counts of bone in the boxes from the first voxel.
  void SumUp() {
    sums_.assign(regions_.size(), 0);
    for (int k = 0; k < size_[2]; ++k) {
      for (int j = 0; j < size_[1]; ++j) {
        std::uint64_t row = 0;
        for (int i = 0; i < size_[0]; ++i) {
          row += regions_[Index(i, j, k)] != 0 ? 1 : 0;
          sums_[Index(i, j, k)] = row + SumTo(i, j - 1, k) + SumTo(i, j, k - 1) - SumTo(i, j - 1, k - 1);
        }
      }
    }
  }
  std::uint64_t SumTo(int i, int j, int k) const { return i < 0 || j < 0 || k < 0 ? 0 : sums_[Index(i, j, k)]; }
  std::uint64_t CountBone(const std::array<int, 3>& lower, const std::array<int, 3>& upper) const {
    std::uint64_t count = 0;
    for (int corner = 0; corner < 8; ++corner) {
      int at[3];
      int sign = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const bool low = (corner >> axis & 1) != 0;
        at[axis] = low ? lower[axis] - 1 : upper[axis];
        if (low) sign = -sign;
      }
      count += static_cast<std::uint64_t>(sign) * SumTo(at[0], at[1], at[2]);
    }
    return count;
  }
  void GrowAlong(int axis, std::vector<std::uint8_t>& grown) const {
    const std::vector<std::uint8_t> from = grown;
    const std::array<std::size_t, 3> strides{1, static_cast<std::size_t>(size_[0]),
                                             static_cast<std::size_t>(size_[0]) * size_[1]};
    const std::size_t stride = strides[axis];
    for (std::size_t n = 0; n < from.size(); ++n) {
      if (from[n] != 0) continue;
      const int at = static_cast<int>(n / stride % size_[axis]);
      if (at > 0 && from[n - stride] != 0) {
        grown[n] = from[n - stride];
      } else if (at + 1 < size_[axis] && from[n + stride] != 0) {
        grown[n] = from[n + stride];
      }
    }
  }

  const LabelMap& map_;
  std::array<int, 3> size_{};
  std::vector<std::uint8_t> regions_;
  std::vector<std::uint64_t> sums_;
};

void CheckLabelMap(const LabelMap& map, const std::map<int, int>& region_of_label, const MaterialTable& materials) {
  double count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (map.size[axis] < 1)
      throw Error(fmt::format("a label map of {} voxels along an axis has no voxel", map.size[axis]));
    CheckRange("spacing_mm", map.spacing_mm[axis], kLabelSpacingRange_mm);
    count *= map.size[axis];
  }
  if (!IsValid(map.X_WL) || !IsInWorld(map.X_WL.p_AB)) throw Error("the pose of the label map is not valid");
  if (count != static_cast<double>(map.labels.size())) {
    throw Error(fmt::format("a label map of {} x {} x {} voxels has {:.0f} labels, not {}", map.size[0], map.size[1],
                            map.size[2], count, map.labels.size()));
  }
  if (count > 4e9) throw Error(fmt::format("a label map of {:.1f} billion voxels is too large", count / 1e9));
  if (region_of_label.empty()) throw Error("no label of the label map is bone");
  for (const auto& [label, region] : region_of_label) {
    if (label < 0 || label > 255) throw Error(fmt::format("{} is not a label; labels are 0 to 255", label));
    materials.At(region);
  }
}

}  // namespace

Bone MakeBoneFromLabels(const LabelMap& map, const std::map<int, int>& region_of_label, double voxel_mm,
                        const MaterialTable& materials, const std::function<void(double)>& progress) {
  CheckLabelMap(map, region_of_label, materials);
  BuildOptions options;
  options.voxel_mm = voxel_mm;
  options.region_voxel_mm = std::max(voxel_mm, 0.2);
  CheckParameters(options);
  options.progress = progress;
  const auto check = [&progress] {
    if (progress) progress(0);
  };
  const LabelSolid solid(map, region_of_label);
  if (solid.empty()) throw Error("no voxel of the label map has a label that is bone");
  check();
  const std::vector<std::uint8_t> grown = solid.GrowRegions((kBandVoxels + 1) * options.region_voxel_mm);
  check();
  return MakeBone({.value = [&](const Vec3& p_W) { return solid.CalcValue(p_W); },
                   .classify = [&](const Vec3& p_W, double radius_mm) { return solid.Classify(p_W, radius_mm); },
                   .region = [&](const Vec3& p_W) { return solid.RegionAt(grown, p_W); },
                   .is_distance = false},
                  solid.CalcBounds().Grown(6 * voxel_mm), options, materials);
}

}  // namespace kerf
