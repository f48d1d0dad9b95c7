// Construction of a bone from a solid or from closed surfaces.
#pragma once

#include <array>
#include <bitset>
#include <functional>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// Classification of a ball of space, made without evaluating each voxel in it.
enum class BlockClass { kInside, kOutside, kMixed };

inline constexpr int kLeafVoxels = 512;
/// A cube of 8 x 8 x 8 voxels. Voxel n is (x, y, z) with n = (8 x + y) 8 + z.
struct LeafPlace {
  std::array<int, 3> first;  // index of voxel 0; voxel 0 of the grid lies at the world's origin
  double voxel_mm;

  Vec3 CalcPosition(int n) const {
    return voxel_mm * Vec3(first[0] + (n >> 6), first[1] + (n >> 3 & 7), first[2] + (n & 7));
  }
};
using LeafValues = std::array<float, kLeafVoxels>;
using WantedVoxels = std::bitset<kLeafVoxels>;
using LeafRegions = std::array<int, kLeafVoxels>;
inline constexpr int kRegionByPlace = -1;  // see SolidField::region_at_place

/// A solid described by functions of a world point. All functions must be thread-safe.
struct SolidField {
  /// Negative inside, positive outside, zero on the surface; continuous. mm when `is_distance`.
  std::function<double(const Vec3&)> value;
  /// Optional: sets the values at the voxels of a leaf to those of value(), all at once, which may be faster.
  std::function<void(const LeafPlace&, LeafValues&)> leaf_values = {};
  /// Optional: returns a solid whose value() and classify() are the same within a ball (centre, radius in mm), bit for
  /// bit, but may be faster.
  std::function<SolidField(const Vec3&, double)> near = {};
  /// Returns whether the ball (centre, radius in mm) is certainly inside, certainly outside, or neither. A wrong answer
  /// makes holes in the bone.
  std::function<BlockClass(const Vec3&, double)> classify;
  /// Region id at a point; only called inside the solid or within the band of its surface. 0 (no material) is allowed.
  /// Not needed if there is leaf_regions().
  std::function<int(const Vec3&)> region;
  /// Optional: sets the region ids of those voxels of a leaf that are in the mask, instead of region().
  std::function<void(const LeafPlace&, const WantedVoxels&, LeafRegions&)> leaf_regions = {};
  /// Optional: returns the region at the points for which leaf_regions() gives kRegionByPlace.
  std::function<int(const Vec3&)> region_at_place = {};
  /// If true, `value` is a signed distance with an error of at most 1 % within 3 voxels of the surface, and is used
  /// directly. If false, only the zero level of `value` is used and the distance is computed from it (first-order fast
  /// sweeping, accurate to 0.3 voxels within 3 voxels of the surface).
  bool is_distance = true;
  /// If true, value() and leaf_regions() are the same at x and -x, bit for bit. value() is then called only for the
  /// half with x >= 0, leaf_regions() for the other half only at voxels whose mirror image was not needed. The box must
  /// then be symmetric as well. Has an effect only if `is_distance` is false.
  bool is_mirrored = false;
  bool has_mirror() const { return is_mirrored && !is_distance; }
};

/// Returns a classify() function for a field whose value changes by at most 1 per mm.
std::function<BlockClass(const Vec3&, double)> ClassifyByDistance(std::function<double(const Vec3&)> value);

/// Number and total volume of the voids that were filled.
struct FilledVoids {
  std::size_t count = 0;
  double mm3 = 0;  // sum of their voxels
};

struct BuildOptions {
  double voxel_mm = 0.2;                 // edge of a voxel, mm
  double region_voxel_mm = 0.2;          // edge of a voxel of the region grid, mm
  std::function<void(double)> progress;  // optional; called with the progress, 0 to 1, from one thread; may throw
                                         // Cancelled
  int band_voxels = 3;                   // half-width of the level set's band; files support only 3
  double max_bytes = 1e300;              // available memory; a bone that needs more is refused before allocation
  FilledVoids* fill_voids = nullptr;     // if set, voids enclosed by the solid are filled and counted here; has an
                                         // effect only if `is_distance` is false
};

template <typename V>
void Describe(BuildOptions& p, V&& visit) {
  visit("voxel_mm", p.voxel_mm, kVoxelRange_mm, "edge of a voxel");
  visit("band_voxels", p.band_voxels, kBandRange_voxels, "half width of the level set's band");
}

/// Voxelises a solid within `box`. The solid must not touch the box: leave at least 4 voxels around it. Voxel centres
/// lie at integer multiples of voxel_mm in world coordinates. Uses all cores; the result does not depend on their
/// number. Throws kerf::Error if the box needs more than 2^36 voxels, if the bone needs more than `max_bytes` of
/// memory, or if the solid contains no voxel.
Bone MakeBone(const SolidField& solid, const Box3& box, const BuildOptions& options, MaterialTable materials);

/// Makes a bone from closed surfaces; `region` is as in SolidField. The first layer encloses the solid, including any
/// hollows in it. The volume enclosed by the second layer is subtracted, that of the third is added, and so on
/// alternately. Throws kerf::Error if a layer is not closed.
Bone MakeBoneFromMesh(std::span<const TriangleMesh> layers, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials);
Bone MakeBoneFromMesh(const TriangleMesh& mesh, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials);

/// Rounds the significands of all distances to `precision_bits` bits (kPrecisionRange_bits), to nearest, as a coarser
/// number format would. Used for comparisons.
void RoundDistances(Bone& bone, int precision_bits);

/// Replaces the region grid: calls `region`, which must be thread-safe, for every region voxel in or near the bone.
/// `report` is called with the progress, 0 to 1, from one thread.
void SetRegions(Bone& bone, const std::function<int(const Vec3&)>& region, double region_voxel_mm,
                const std::function<void(double)>& report = {});
/// As above, but for all such voxels of a leaf at once; see SolidField::leaf_regions.
void SetRegions(Bone& bone,
                const std::function<void(const LeafPlace&, const WantedVoxels&, LeafRegions&)>& leaf_regions,
                double region_voxel_mm, const std::function<void(double)>& report = {});

}  // namespace kerf
