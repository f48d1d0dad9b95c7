// The OpenVDB side of a bone. Only bone, bonefile, contact and removal include this.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <optional>

#include "bone/grid/interpolate.h"
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

openvdb::FloatGrid::Ptr MakePhiGrid(double voxel_mm, int band_voxels = kHalfBandVoxels);
openvdb::Int32Grid::Ptr MakeRegionGrid(double voxel_mm);
/// Clamps to the band, switches off what lies beyond it, and merges uniform leaves into tiles.
void FinishLevelSet(openvdb::FloatGrid& grid);
/// Of CT numbers; the background is air.
openvdb::FloatGrid::Ptr MakeHuGrid(double voxel_mm);
/// As ExtractSurface(), of any level set with a right-handed transform.
TriangleMesh ExtractZeroLevel(const openvdb::FloatGrid& grid, double adaptivity);

/// The eight values of a cell. Tick-safe.
template <typename Accessor>
auto GetCorners(const Accessor& accessor, const CellPoint& cell) {
  CellValues<typename Accessor::ValueType> v;
  for (int corner = 0; corner < 8; ++corner) {
    v[static_cast<std::size_t>(corner)] = accessor.getValue(
        openvdb::Coord(cell.x + ((corner >> 2) & 1), cell.y + ((corner >> 1) & 1), cell.z + (corner & 1)));
  }
  return v;
}

/// phi at a point given in phi's index space, trilinear. Accessor: openvdb::FloatGrid::ConstAccessor. Tick-safe.
template <typename Accessor>
double SampleTrilinear(const Accessor& accessor, const Vec3& p_vox) {
  const CellPoint cell = FindCell(p_vox);
  return Interpolate(GetCorners(accessor, cell), cell.f);
}

/// E from the CT at a point, MPa: trilinear between those of the eight voxels around it that have one, 0 where none
/// has. `p_vox`: in the index space of the grid. Tick-safe.
template <typename Accessor>
double SampleModulus(const Accessor& modulus, const Vec3& p_vox) {
  const CellPoint cell = FindCell(p_vox);
  return InterpolatePositive(GetCorners(modulus, cell), cell.f);
}

/// Calls visit(region id, weight) for those of the eight region voxels around a point that have a material; the weights
/// are those of trilinear interpolation. `p_vox`: in the region grid's index space. Tick-safe.
template <typename Accessor, typename Visit>
void ForEachRegionAround(const Accessor& region, const Vec3& p_vox, Visit&& visit) {
  const CellPoint cell = FindCell(p_vox);
  VisitRegions(GetCorners(region, cell), cell.f, visit);
}

/// Index of the voxel nearest to a point. Tick-safe.
inline openvdb::Coord NearestVoxel(const Vec3& p_W, double voxel_mm) {
  return {NearestIndex(p_W.x, voxel_mm), NearestIndex(p_W.y, voxel_mm), NearestIndex(p_W.z, voxel_mm)};
}

}  // namespace kerf
