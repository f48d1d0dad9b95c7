#include "bone/grid/solid_regions.h"

#include <openvdb/tools/Prune.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "bone/grid/build_progress.h"
#include "bone/grid/grids.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using RegionLeaf = openvdb::Int32Tree::LeafNodeType;

constexpr int kUnknownRegion = -2;

LeafPlace PlaceOf(const Coord& block, double voxel_mm) {
  return {{block.x(), block.y(), block.z()}, voxel_mm};
}

/// Sets the regions of a block with x < 0 from those of the half with x >= 0, where they are known.
void CopyMirrored(const std::vector<Coord>& blocks, const std::vector<std::unique_ptr<LeafRegions>>& half,
                  const Coord& block, LeafRegions& ids) {
  constexpr int kLayer = kLeafEdge * kLeafEdge;
  for (int x = 0; x < kLeafEdge; ++x) {
    const int from_x = -block.x() - x;
    const Coord from(from_x & -kLeafEdge, block.y(), block.z());
    const auto found = std::lower_bound(blocks.begin(), blocks.end(), from);
    if (found == blocks.end() || *found != from) continue;
    const std::unique_ptr<LeafRegions>& known = half[static_cast<std::size_t>(found - blocks.begin())];
    if (known) std::copy_n(known->data() + (from_x & (kLeafEdge - 1)) * kLayer, kLayer, ids.data() + x * kLayer);
  }
}

/// Returns the region voxels of a leaf of which any part lies in bone or within two voxels of it: the centre of a cell
/// that the surface cuts may be that far outside. `h`: edge of a voxel of `phi`, mm.
template <typename Accessor>
WantedVoxels FindNear(const Accessor& phi, const LeafPlace& place, double h) {
  // The voxels of phi that are nearest to a voxel's lower corner, centre and upper corner, along each axis.
  std::array<std::array<std::array<int, 3>, kLeafEdge>, 3> nearest;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kLeafEdge; ++i) {
      const double centre_mm = place.voxel_mm * (place.first[axis] + i);
      for (int side = 0; side < 3; ++side) {
        nearest[axis][i][side] = NearestIndex(centre_mm + place.voxel_mm * (0.5 * (side - 1)), h);
      }
    }
  }
  const auto is_near = [&](const Coord& ijk) { return static_cast<double>(phi.getValue(ijk)) < 2 * h; };
  // Most leaves lie in blocks of phi that have one value.
  const Coord first(nearest[0][0][0], nearest[1][0][0], nearest[2][0][0]);
  const Coord last(nearest[0][7][2], nearest[1][7][2], nearest[2][7][2]);
  const bool near = is_near(first);
  bool same = true;
  for (int x = first.x() & -kLeafEdge; same && x <= last.x(); x += kLeafEdge) {
    for (int y = first.y() & -kLeafEdge; same && y <= last.y(); y += kLeafEdge) {
      for (int z = first.z() & -kLeafEdge; same && z <= last.z(); z += kLeafEdge) {
        const Coord block(x, y, z);
        same = phi.probeConstLeaf(block) == nullptr && is_near(block) == near;
      }
    }
  }
  WantedVoxels found;
  if (same) return near ? found.set() : found;
  for (int n = 0; n < kLeafVoxels; ++n) {
    const auto at = [&](int x, int y, int z) {
      return Coord(nearest[0][n >> 6][x], nearest[1][n >> 3 & 7][y], nearest[2][n & 7][z]);
    };
    found[n] = is_near(at(1, 1, 1));
    for (int corner = 0; corner < 8 && !found[n]; ++corner) {
      found[n] = is_near(at(corner >> 1 & 2, corner & 2, corner << 1 & 2));
    }
  }
  return found;
}

}  // namespace

void SetSolidRegions(Bone& bone, const SolidField& solid, double region_voxel_mm,
                     const std::function<void(double)>& report) {
  BoneGrids& grids = GridsOf(bone);
  const double h = grids.voxel_mm();
  const double hr = region_voxel_mm;
  grids.region = MakeRegionGrid(hr);

  std::vector<Coord> blocks;
  const auto add_blocks = [&](const openvdb::CoordBBox& box) {
    const Vec3 lower = h * Vec3(box.min().x(), box.min().y(), box.min().z()) / hr;
    const Vec3 upper = h * Vec3(box.max().x(), box.max().y(), box.max().z()) / hr;
    const Coord first = FloorToBlock(lower - 0.5, kLeafEdge);
    const Coord last = FloorToBlock(upper + 0.5, kLeafEdge);
    for (int x = first.x(); x <= last.x(); x += kLeafEdge) {
      for (int y = first.y(); y <= last.y(); y += kLeafEdge) {
        for (int z = first.z(); z <= last.z(); z += kLeafEdge) blocks.emplace_back(x, y, z);
      }
    }
  };
  for (auto leaf = grids.phi->tree().cbeginLeaf(); leaf; ++leaf) add_blocks(leaf->getNodeBoundingBox());
  auto tile = grids.phi->tree().cbeginValueAll();
  tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (*tile < 0 && tile.getBoundingBox(box)) add_blocks(box);
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());

  // Of a mirrored solid, the regions of the blocks with x >= 0 are found first.
  std::vector<WantedVoxels> near(blocks.size());
  std::vector<std::unique_ptr<LeafRegions>> half(blocks.size());
  const bool mirrors = solid.has_mirror();
  Progress progress(report, 0, 1, 2 * blocks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 16), [&](const auto& range) {
    const openvdb::tree::ValueAccessor<const FloatTree> phi(grids.phi->constTree());
    for (std::size_t n = range.begin(); n < range.end(); ++n, progress.Done(1)) {
      const LeafPlace place = PlaceOf(blocks[n], hr);
      near[n] = FindNear(phi, place, h);
      if (!mirrors || blocks[n].x() < 0 || near[n].none()) continue;
      half[n] = std::make_unique<LeafRegions>();
      half[n]->fill(kUnknownRegion);
      solid.leaf_regions(place, near[n], *half[n]);
    }
  });
  // A block with one region never becomes a leaf. Most blocks are like this, and a leaf for each would exhaust the
  // memory.
  std::vector<std::unique_ptr<RegionLeaf>> leaves(blocks.size());
  std::vector<std::uint8_t> uniform(blocks.size(), 0);
  std::atomic<int> bad_id{0};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 16), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n, progress.Done(1)) {
      if (near[n].none()) continue;
      const LeafPlace place = PlaceOf(blocks[n], hr);
      LeafRegions ids;
      if (half[n]) {
        ids = *half[n];
      } else {
        ids.fill(kUnknownRegion);
        if (mirrors) CopyMirrored(blocks, half, blocks[n], ids);
        WantedVoxels wanted;
        for (int i = 0; i < kLeafVoxels; ++i) wanted[i] = near[n][i] && ids[i] == kUnknownRegion;
        if (wanted.any()) solid.leaf_regions(place, wanted, ids);
      }
      auto leaf = std::make_unique<RegionLeaf>(blocks[n], 0, false);
      bool any = false;
      for (openvdb::Index i = 0; i < RegionLeaf::SIZE; ++i) {
        if (!near[n][i]) continue;
        const int id = ids[i] == kRegionByPlace && solid.region_at_place
                           ? solid.region_at_place(place.CalcPosition(static_cast<int>(i)))
                           : ids[i];
        if (id < 0 || id > 255) bad_id = id;
        if (id == 0) continue;
        leaf->setValueOn(i, id);
        any = true;
      }
      if (!any) continue;
      RegionLeaf::ValueType id = 0;
      bool active = false;
      if (leaf->isConstant(id, active) && active) {
        uniform[n] = static_cast<std::uint8_t>(id);
      } else {
        leaves[n] = std::move(leaf);
      }
    }
  });
  CheckRange("region", bad_id, {kRegionRange.lower, kRegionRange.upper, kOrZero}, "bone");
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    if (leaves[n]) grids.region->tree().addLeaf(leaves[n].release());
    if (uniform[n] != 0) grids.region->tree().addTile(1, blocks[n], uniform[n], true);
  }
  openvdb::tools::prune(grids.region->tree());
}

void SetRegions(Bone& bone, const std::function<int(const Vec3&)>& region, double region_voxel_mm,
                const std::function<void(double)>& report) {
  const auto leaf_regions = [&region](const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) {
    for (int n = 0; n < kLeafVoxels; ++n) {
      if (wanted[n]) ids[n] = region(leaf.CalcPosition(n));
    }
  };
  SetRegions(bone, leaf_regions, region_voxel_mm, report);
}

void SetRegions(Bone& bone,
                const std::function<void(const LeafPlace&, const WantedVoxels&, LeafRegions&)>& leaf_regions,
                double region_voxel_mm, const std::function<void(double)>& report) {
  SolidField solid;
  solid.leaf_regions = leaf_regions;
  SetSolidRegions(bone, solid, region_voxel_mm, report);
}

}  // namespace kerf
