// The OpenVDB side of a bone. Only bone, bonefile, contact and removal include this.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <cmath>
#include <optional>

#include "kerf/bone.h"

namespace kerf {

inline constexpr int kHalfBandVoxels = 3;

/// All grids have transforms of uniform scale without offset: a voxel's centre lies at its integer index times its
/// edge. All but phi are shared between copies: replaced, never changed in place.
struct Bone::Grids {
  openvdb::FloatGrid::Ptr phi;
  openvdb::Int32Grid::Ptr region;
  MaterialTable materials;
  std::optional<MaterialTable> stored_materials;  // what a file of the bone gets when `materials` is not the bone's own
  std::map<std::string, std::string> notes;
  openvdb::FloatGrid::Ptr hu;          // CT numbers; null when none were kept or asked for
  openvdb::FloatGrid::Ptr modulus;     // E from them, MPa, 0 where unknown; null when E is by the table alone
  std::array<bool, 256> by_modulus{};  // regions whose E is taken from `modulus`

  double voxel_mm() const { return phi->voxelSize()[0]; }
  double region_voxel_mm() const { return region->voxelSize()[0]; }
};

openvdb::FloatGrid::Ptr MakePhiGrid(double voxel_mm);
openvdb::Int32Grid::Ptr MakeRegionGrid(double voxel_mm);
/// Clamps to the band, switches off what lies beyond it, and merges uniform leaves into tiles.
void FinishLevelSet(openvdb::FloatGrid& grid);
/// Of CT numbers; the background is air.
openvdb::FloatGrid::Ptr MakeHuGrid(double voxel_mm);
/// As ExtractSurface(), of any level set with a right-handed transform.
TriangleMesh ExtractZeroLevel(const openvdb::FloatGrid& grid, double adaptivity);

/// phi at a point given in phi's index space, trilinear. Accessor: openvdb::FloatGrid::ConstAccessor. Tick-safe.
template <typename Accessor>
double SampleTrilinear(const Accessor& accessor, const Vec3& p_vox) {
  const Vec3 base = glm::floor(p_vox);
  const Vec3 f = p_vox - base;
  const openvdb::Coord ijk(static_cast<int>(base.x), static_cast<int>(base.y), static_cast<int>(base.z));
  double plane[2];
  for (int dx = 0; dx < 2; ++dx) {
    double line[2];
    for (int dy = 0; dy < 2; ++dy) {
      const double v0 = static_cast<double>(accessor.getValue(ijk.offsetBy(dx, dy, 0)));
      const double v1 = static_cast<double>(accessor.getValue(ijk.offsetBy(dx, dy, 1)));
      line[dy] = v0 + f.z * (v1 - v0);
    }
    plane[dx] = line[0] + f.y * (line[1] - line[0]);
  }
  return plane[0] + f.x * (plane[1] - plane[0]);
}

/// E from the CT at a point, MPa: trilinear between those of the eight voxels around it that have one, 0 where none
/// has. `p_vox`: in the index space of the grid. Tick-safe.
template <typename Accessor>
double SampleModulus(const Accessor& modulus, const Vec3& p_vox) {
  const Vec3 base = glm::floor(p_vox);
  const Vec3 f = p_vox - base;
  const openvdb::Coord ijk(static_cast<int>(base.x), static_cast<int>(base.y), static_cast<int>(base.z));
  double sum = 0;
  double weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = (corner >> 2) & 1;
    const int dy = (corner >> 1) & 1;
    const int dz = corner & 1;
    const double E_MPa = static_cast<double>(modulus.getValue(ijk.offsetBy(dx, dy, dz)));
    if (!(E_MPa > 0)) continue;
    const double weight = (dx ? f.x : 1 - f.x) * (dy ? f.y : 1 - f.y) * (dz ? f.z : 1 - f.z);
    sum += weight * E_MPa;
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
}

/// Calls visit(region id, weight) for those of the eight region voxels around a point that have a material; the weights
/// are those of trilinear interpolation. `p_vox`: in the region grid's index space. Tick-safe.
template <typename Accessor, typename Visit>
void ForEachRegionAround(const Accessor& region, const Vec3& p_vox, Visit&& visit) {
  const Vec3 base = glm::floor(p_vox);
  const Vec3 f = p_vox - base;
  const openvdb::Coord ijk(static_cast<int>(base.x), static_cast<int>(base.y), static_cast<int>(base.z));
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = (corner >> 2) & 1;
    const int dy = (corner >> 1) & 1;
    const int dz = corner & 1;
    const int id = region.getValue(ijk.offsetBy(dx, dy, dz));
    if (id <= 0 || id > 255) continue;
    visit(id, (dx ? f.x : 1 - f.x) * (dy ? f.y : 1 - f.y) * (dz ? f.z : 1 - f.z));
  }
}

/// Index of the voxel nearest to a point. Tick-safe.
inline openvdb::Coord NearestVoxel(const Vec3& p_W, double voxel_mm) {
  return {static_cast<int>(std::floor(p_W.x / voxel_mm + 0.5)), static_cast<int>(std::floor(p_W.y / voxel_mm + 0.5)),
          static_cast<int>(std::floor(p_W.z / voxel_mm + 0.5))};
}

}  // namespace kerf
