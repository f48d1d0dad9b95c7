#include "bone/grid/ct_modulus.h"

#include <fmt/format.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bone/grid/dilate.h"
#include "bone/grid/grids.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;

/// Calls visit(CT number, region id) for each CT voxel whose centre lies in the bone.
template <typename Visit>
void ForEachHuInBone(const Bone& bone, Visit visit) {
  const BoneGrids& grids = GridsOf(bone);
  const double hu_h = grids.hu->voxelSize()[0];
  openvdb::FloatGrid::ConstUnsafeAccessor phi(grids.phi->constTree());
  openvdb::Int32Grid::ConstUnsafeAccessor regions(grids.region->constTree());
  for (auto leaf = grids.hu->constTree().cbeginLeaf(); leaf; ++leaf) {
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      const Coord ijk = it.getCoord();
      const Vec3 p_W = hu_h * Vec3(ijk.x(), ijk.y(), ijk.z());
      if (SampleTrilinear(phi, p_W / grids.voxel_mm()) >= 0) continue;
      visit(static_cast<double>(*it), regions.getValue(NearestVoxel(p_W, grids.region_voxel_mm())));
    }
  }
}

/// Returns the cells of a lattice of edge `hu_h` that contain an inside voxel of the bone.
openvdb::MaskTree FindCells(const openvdb::FloatTree& phi, double h, double hu_h) {
  openvdb::MaskTree cells;
  openvdb::tree::ValueAccessor<openvdb::MaskTree> mark(cells);
  const auto cell_of = [&](const Coord& ijk) {
    const auto down = [&](int i) { return static_cast<int>(std::floor(i * h / hu_h)); };
    return Coord(down(ijk.x()), down(ijk.y()), down(ijk.z()));
  };
  for (auto leaf = phi.cbeginLeaf(); leaf; ++leaf) {
    for (auto it = leaf->cbeginValueAll(); it; ++it) {
      if (*it < 0) mark.setValueOn(cell_of(it.getCoord()));
    }
  }
  auto tile = phi.cbeginValueAll();
  tile.setMaxDepth(openvdb::FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (*tile >= 0 || !tile.getBoundingBox(box)) continue;
    const openvdb::CoordBBox covered(cell_of(box.min()), cell_of(box.max()));
    for (auto ijk = covered.begin(); ijk; ++ijk) mark.setValueOn(*ijk);
  }
  return cells;
}

}  // namespace

void SetHu(Bone& bone, const std::function<double(const Vec3&)>& hu, double voxel_mm) {
  CheckRange("voxel_mm", voxel_mm, kHuVoxelRange_mm, "CT");
  BoneGrids& grids = GridsOf(bone);
  const double h = grids.voxel_mm();
  openvdb::MaskTree cells = FindCells(grids.phi->constTree(), h, voxel_mm);
  // A point in the bone lies within a voxel of phi from the centre of an inside voxel, and needs all corners of its
  // cell.
  const int reach = 1 + static_cast<int>(std::ceil(h / voxel_mm));
  Dilate(cells, reach, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::EXPAND_TILES);
  const auto grid = MakeHuGrid(voxel_mm);
  grid->setTree(std::make_shared<openvdb::FloatTree>(cells, grid->background(), openvdb::TopologyCopy()));
  grid->tree().voxelizeActiveTiles();
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(grid->tree());
  leaves.foreach ([&](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
    for (auto it = leaf.beginValueOn(); it; ++it) {
      const Coord ijk = it.getCoord();
      it.setValue(static_cast<float>(hu(voxel_mm * Vec3(ijk.x(), ijk.y(), ijk.z()))));
    }
  });
  grids.hu = grid;
  grids.modulus.reset();
  grids.by_modulus.fill(false);
}

void CopyHu(Bone& bone, const Bone& from) {
  if (!GridsOf(from).hu) throw Error("the bone has no CT numbers");
  GridsOf(bone).hu = GridsOf(from).hu;
  GridsOf(bone).modulus.reset();
  GridsOf(bone).by_modulus.fill(false);
}

CtModulusReport UseCtModulus(Bone& bone, const CtLaw& law, bool all_regions) {
  BoneGrids& grids = GridsOf(bone);
  if (!grids.hu) throw Error("the bone has no CT numbers");
  if (law.calibration.empty()) throw Error(fmt::format("the law \"{}\" has no calibration", law.name));
  CheckCtLaw(law);
  auto modulus = openvdb::FloatGrid::create(0.0f);
  modulus->setTransform(grids.hu->transformPtr());
  modulus->setName("modulus");
  modulus->setTree(std::make_shared<openvdb::FloatTree>(grids.hu->constTree(), 0.0f, openvdb::TopologyCopy()));
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(modulus->tree());
  const openvdb::FloatTree& hu = grids.hu->constTree();
  leaves.foreach ([&](openvdb::FloatTree::LeafNodeType& leaf, std::size_t) {
    const auto* numbers = hu.probeConstLeaf(leaf.origin());
    for (auto it = leaf.beginValueOn(); it; ++it) {
      const double HU = static_cast<double>(numbers->getValue(it.pos()));
      it.setValue(static_cast<float>(CalcModulus(law, CalcDensity(law, HU))));
    }
  });
  grids.modulus = modulus;
  grids.by_modulus.fill(false);
  for (const auto& [id, region] : grids.materials.regions()) {
    grids.by_modulus[id] = all_regions || region.tissue == Tissue::kCancellous;
  }

  CtModulusReport report;
  const auto [lowest_HU, highest_HU] = CalcValidHu(law);
  std::uint64_t below = 0;
  std::uint64_t above = 0;
  std::vector<float> E_MPa;
  ForEachHuInBone(bone, [&, low = lowest_HU, high = highest_HU](double HU, int region) {
    if (region <= 0 || region > 255 || !grids.by_modulus[region]) return;
    below += HU < low ? 1 : 0;
    above += HU > high ? 1 : 0;
    E_MPa.push_back(static_cast<float>(CalcModulus(law, CalcDensity(law, HU))));
  });
  if (E_MPa.empty()) return report;
  report.voxels = E_MPa.size();
  const double n = static_cast<double>(E_MPa.size());
  report.fraction_below = static_cast<double>(below) / n;
  report.fraction_above = static_cast<double>(above) / n;
  std::sort(E_MPa.begin(), E_MPa.end());
  const auto rank = [&](double fraction) {
    return static_cast<double>(E_MPa[static_cast<std::size_t>(std::max(0.0, std::ceil(fraction * n) - 1))]);
  };
  report.E_min_MPa = rank(0);
  report.E_p5_MPa = rank(0.05);
  report.E_p50_MPa = rank(0.5);
  report.E_p95_MPa = rank(0.95);
  report.E_max_MPa = rank(1);
  return report;
}

HuRange CalcHuRange(const Bone& bone) {
  HuRange range;
  if (!bone.has_hu()) return range;
  double sum = 0;
  ForEachHuInBone(bone, [&](double HU, int) {
    range.min = range.voxels == 0 ? HU : std::min(range.min, HU);
    range.max = range.voxels == 0 ? HU : std::max(range.max, HU);
    sum += HU;
    ++range.voxels;
  });
  if (range.voxels > 0) range.mean = sum / static_cast<double>(range.voxels);
  return range;
}

}  // namespace kerf
