// The OpenVDB side of a bone. Only bone, bonefile, contact and removal include this.
#pragma once

#include <openvdb/openvdb.h>

#include <cmath>

#include "kerf/bone.h"

namespace kerf {

inline constexpr int kHalfBandVoxels = 3;

/// Both grids have transforms of uniform scale without offset: a voxel's centre lies at its integer index times its
/// edge.
struct Bone::Grids {
  openvdb::FloatGrid::Ptr phi;
  openvdb::Int32Grid::Ptr region;  // shared between copies: replaced, never changed in place
  MaterialTable materials;
  std::map<std::string, std::string> notes;

  double voxel_mm() const { return phi->voxelSize()[0]; }
  double region_voxel_mm() const { return region->voxelSize()[0]; }
};

openvdb::FloatGrid::Ptr MakePhiGrid(double voxel_mm);
openvdb::Int32Grid::Ptr MakeRegionGrid(double voxel_mm);

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

/// Index of the voxel nearest to a point. Tick-safe.
inline openvdb::Coord NearestVoxel(const Vec3& p_W, double voxel_mm) {
  return {static_cast<int>(std::floor(p_W.x / voxel_mm + 0.5)), static_cast<int>(std::floor(p_W.y / voxel_mm + 0.5)),
          static_cast<int>(std::floor(p_W.z / voxel_mm + 0.5))};
}

}  // namespace kerf
