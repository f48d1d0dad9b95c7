// Making a bone from a description of space.
#pragma once

#include <functional>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// What is known of a ball of space without looking at each voxel in it.
enum class BlockClass { kInside, kOutside, kMixed };

/// A solid as functions of a world point. All functions must be thread-safe.
struct SolidField {
  /// Negative inside, positive outside, zero on the surface; continuous. mm when `is_distance`.
  std::function<double(const Vec3&)> value;
  /// Whether the ball (centre, radius mm) is certainly inside, certainly outside, or neither. Errors here are holes in
  /// the bone.
  std::function<BlockClass(const Vec3&, double)> classify;
  /// Region id at a point; only asked inside or within band of the surface. 0 is allowed (no material).
  std::function<int(const Vec3&)> region;
  /// True: `value` is a signed distance to 1 % within 3 voxels of the surface and used as it is.
  /// False: only its zero level is used and the distance is solved for (first-order fast sweeping: to a fifth of a
  /// voxel).
  bool is_distance = true;
};

/// classify() for a field whose value changes by at most 1 per mm.
std::function<BlockClass(const Vec3&, double)> ClassifyByDistance(std::function<double(const Vec3&)> value);

/// Voids that were made solid.
struct FilledVoids {
  std::size_t count = 0;
  double mm3 = 0;  // by voxels
};

struct BuildOptions {
  double voxel_mm = 0.2;                 // 0.02 to 4
  double region_voxel_mm = 0.2;          // of the region grid
  std::function<void(double)> progress;  // called with 0..1, from one thread; may be empty
  int band_voxels = 3;                   // half width of the level set's band, 2 to 8; files hold 3 only
  double most_bytes = 1e300;             // of memory, that are free: more is refused before it is asked for
  FilledVoids* fill_voids = nullptr;     // set: voids that the solid encloses become solid and are counted here;
                                         // of a field that is no distance
};

/// Voxelises a solid within `box` (which it must not touch: leave at least 4 voxels around it).
/// Voxel centres lie at integer multiples of voxel_mm in world coordinates.
/// Throws Error when the box would need more than 2^36 voxels, the bone more memory than there is, or nothing is
/// inside. Uses all cores; the result does not depend on their number.
Bone MakeBone(const SolidField& solid, const Box3& box, const BuildOptions& options, MaterialTable materials);

/// The same from closed surfaces; the region function as above. What the first encloses is solid, hollows that lie in
/// it included; what the second encloses is taken away again, what the third encloses is added to that, and so on.
/// Throws Error when one is open.
Bone MakeBoneFromMesh(std::span<const TriangleMesh> layers, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials);
Bone MakeBoneFromMesh(const TriangleMesh& mesh, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials);

/// Keeps so many bits (4 to 24) of the significands of the distances, to nearest, as a coarser number format would: for
/// comparison.
void RoundDistances(Bone& bone, int precision_bits);

/// Replaces the region grid: asks `region` again for every region voxel at or near the bone. Thread-safe function.
/// `report` is called with the last quarter of the progress of making a bone, 0.75 to 0.98.
void SetRegions(Bone& bone, const std::function<int(const Vec3&)>& region, double region_voxel_mm,
                const std::function<void(double)>& report = {});

}  // namespace kerf
