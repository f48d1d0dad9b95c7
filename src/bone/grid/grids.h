// OpenVDB grids of a bone. Includes OpenVDB, and is therefore only for source files that need the grids themselves.
#pragma once

#include "bone/grid/openvdb_templates.h"

#include <array>
#include <cmath>
#include <optional>

#include "bone/grid/interpolate.h"
#include "kerf/bone.h"

namespace kerf {

inline constexpr int kHalfBandVoxels = 3;
inline constexpr int kLeafEdge = openvdb::FloatTree::LeafNodeType::DIM;  // voxels
/// Returns the lowest voxel of a leaf.
inline openvdb::Coord OriginOf(const std::array<int, 3>& leaf) {
  return {kLeafEdge * leaf[0], kLeafEdge * leaf[1], kLeafEdge * leaf[2]};
}

/// The transforms of all grids have a uniform scale and no offset: a voxel's centre lies at its integer index times its
/// edge. The grids except phi, whole and cut are shared between copies: they are replaced, never changed in place.
struct Bone::Grids {
  openvdb::FloatGrid::Ptr phi;
  /// The two fields whose larger one is phi (see BoneField), in the leaves that are split; null if none is. In `cut`, a
  /// tile of the size of a leaf marks one whose phi is that of the cut.
  openvdb::FloatGrid::Ptr whole;
  openvdb::FloatGrid::Ptr cut;
  openvdb::Int32Grid::Ptr region;
  MaterialTable materials;
  std::optional<MaterialTable> stored_materials;  // if set, files get this table, and `materials` overrides it
  std::map<std::string, std::string> notes;
  openvdb::FloatGrid::Ptr hu;          // CT numbers; null if none were kept or read
  openvdb::FloatGrid::Ptr modulus;     // E from the CT numbers, MPa, 0 where unknown; null if not used
  std::array<bool, 256> by_modulus{};  // regions whose E comes from `modulus`

  double voxel_mm() const { return phi->voxelSize()[0]; }
  double region_voxel_mm() const { return region->voxelSize()[0]; }
};

struct BoneInternals {
  using Grids = Bone::Grids;
  static Grids& Get(Bone& bone) { return *bone.grids_; }
  static const Grids& Get(const Bone& bone) { return *bone.grids_; }
};
using BoneGrids = BoneInternals::Grids;
inline BoneGrids& GridsOf(Bone& bone) {
  return BoneInternals::Get(bone);
}
inline const BoneGrids& GridsOf(const Bone& bone) {
  return BoneInternals::Get(bone);
}

openvdb::FloatGrid::Ptr MakePhiGrid(double voxel_mm, int band_voxels = kHalfBandVoxels);
openvdb::Int32Grid::Ptr MakeRegionGrid(double voxel_mm);
/// Adds the grids of the two fields, without leaves, to a bone that has none.
void AddPartGrids(BoneGrids& grids);
/// Clamps the values to the band, deactivates the voxels beyond it, and merges uniform leaves into tiles.
void FinishLevelSet(openvdb::FloatGrid& grid);
/// Makes an empty grid for CT numbers; its background value is air.
openvdb::FloatGrid::Ptr MakeHuGrid(double voxel_mm);
/// Like ExtractSurface(), but for any level set with a right-handed transform.
TriangleMesh ExtractZeroLevel(const openvdb::FloatGrid& grid, double adaptivity);

/// Calls visit(box of voxels, value) for each tile whose value is not the background.
template <typename Tree, typename Visit>
void ForEachTileBox(const Tree& tree, Visit&& visit) {
  auto it = tree.cbeginValueAll();
  it.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; it; ++it) {
    if (*it == tree.background()) continue;
    openvdb::CoordBBox box;
    if (it.getBoundingBox(box)) visit(box, *it);
  }
}

/// Calls visit(lowest voxel) for each block of the size of a leaf that has its own values or those of a tile.
template <typename Visit>
void ForEachBlock(const openvdb::FloatTree& tree, Visit&& visit) {
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) visit(leaf->origin());
  ForEachTileBox(tree, [&](const openvdb::CoordBBox& box, float) {
    for (int x = box.min().x(); x <= box.max().x(); x += kLeafEdge) {
      for (int y = box.min().y(); y <= box.max().y(); y += kLeafEdge) {
        for (int z = box.min().z(); z <= box.max().z(); z += kLeafEdge) visit(openvdb::Coord(x, y, z));
      }
    }
  });
}

/// Returns the eight values of a cell. Tick-safe.
template <typename Accessor>
auto GetCorners(const Accessor& accessor, const CellPoint& cell) {
  CellValues<typename Accessor::ValueType> v;
  for (int corner = 0; corner < 8; ++corner) {
    v[static_cast<std::size_t>(corner)] = accessor.getValue(
        openvdb::Coord(cell.x + ((corner >> 2) & 1), cell.y + ((corner >> 1) & 1), cell.z + (corner & 1)));
  }
  return v;
}

/// Returns phi, interpolated trilinearly, at a point in phi's index space. Accessor: openvdb::FloatGrid::ConstAccessor.
/// Tick-safe.
template <typename Accessor>
double SampleTrilinear(const Accessor& accessor, const Vec3& p_vox) {
  const CellPoint cell = FindCell(p_vox);
  return Interpolate(GetCorners(accessor, cell), cell.f);
}

/// Returns E from the CT at a point, MPa: interpolated trilinearly between those of the eight voxels around it that
/// have a value; 0 if none has. `p_vox`: in the index space of the grid. Tick-safe.
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

/// Returns the origin of the block with `edge` voxels along each axis that contains a point, in voxels.
inline openvdb::Coord FloorToBlock(const Vec3& p_vox, int edge) {
  const auto down = [edge](double x) { return static_cast<int>(std::floor(x / edge)) * edge; };
  return {down(p_vox.x), down(p_vox.y), down(p_vox.z)};
}

/// Returns the index of the voxel nearest to a point. Tick-safe.
inline openvdb::Coord NearestVoxel(const Vec3& p_W, double voxel_mm) {
  return {NearestIndex(p_W.x, voxel_mm), NearestIndex(p_W.y, voxel_mm), NearestIndex(p_W.z, voxel_mm)};
}

}  // namespace kerf
