#include "bone/grid/removed.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "bone/grid/cell_volume.h"
#include "bone/grid/grids.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;
using Accessor = openvdb::FloatGrid::ConstAccessor;
using RegionAccessor = openvdb::Int32Grid::ConstAccessor;

/// Returns the centre of the bone lost by a cell with these values, 0 to 1 along each axis.
Vec3 CalcLostMiddle(const std::array<float, 8>& before, const std::array<float, 8>& after) {
  constexpr int kSteps = 4;
  Vec3 sum{0};
  int count = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Vec3 f = (Vec3(i / (kSteps * kSteps), i / kSteps % kSteps, i % kSteps) + 0.5) / static_cast<double>(kSteps);
    if (Interpolate(before, f) >= 0 || Interpolate(after, f) < 0) continue;
    sum += f;
    ++count;
  }
  return count == 0 ? Vec3(0.5) : sum / static_cast<double>(count);
}

void CheckSameVoxels(const Bone& before, const Bone& after) {
  if (before.voxel_mm() == after.voxel_mm()) return;
  throw Error(
      fmt::format("bones of {:g} mm and {:g} mm voxels can't be compared", before.voxel_mm(), after.voxel_mm()));
}

Coord OriginOf(const std::array<int, 3>& leaf) {
  return {8 * leaf[0], 8 * leaf[1], 8 * leaf[2]};
}

/// Finds the changed cells of leaf after leaf.
class CellFinder {
 public:
  CellFinder(const Bone& before, const Bone& after)
      : h_(before.voxel_mm()),
        region_voxel_mm_(before.region_voxel_mm()),
        before_(GridsOf(before).phi->getConstAccessor()),
        after_(GridsOf(after).phi->getConstAccessor()),
        region_(GridsOf(before).region->getConstAccessor()) {}

  void Add(const Coord& origin, std::vector<RemovedCell>& cells) const {
    for (int i = 0; i < 512; ++i) {
      const Coord c = origin + Coord(i >> 6, (i >> 3) & 7, i & 7);
      const CellPoint at{c.x(), c.y(), c.z(), Vec3(0)};
      const std::array<float, 8> was = GetCorners(before_, at);
      const std::array<float, 8> is = GetCorners(after_, at);
      const double lost = CalcCellFraction(was) - CalcCellFraction(is);
      if (lost == 0) continue;
      const Vec3 middle = lost < 0.999 ? CalcLostMiddle(was, is) : Vec3(0.5);
      const Vec3 p_W = h_ * (Vec3(c.x(), c.y(), c.z()) + middle);
      cells.push_back({.p_W = p_W,
                       .mm3 = lost * h_ * h_ * h_,
                       .region = region_.getValue(NearestVoxel(p_W, region_voxel_mm_)),
                       .in_mm = -Interpolate(was, middle)});
    }
  }

 private:
  double h_;
  double region_voxel_mm_;
  Accessor before_;
  Accessor after_;
  RegionAccessor region_;
};

}  // namespace

std::vector<std::array<int, 3>> FindChangedLeaves(const Bone& before, const Bone& after) {
  const openvdb::FloatGrid& phi_before = *GridsOf(before).phi;
  const openvdb::FloatGrid& phi_after = *GridsOf(after).phi;
  std::set<Coord> changed;
  Accessor of_before = phi_before.getConstAccessor();
  Accessor of_after = phi_after.getConstAccessor();
  const auto compare = [&](const Coord& origin) {
    const auto* a = of_before.probeConstLeaf(origin);
    const auto* b = of_after.probeConstLeaf(origin);
    const float a_all = of_before.getValue(origin);
    const float b_all = of_after.getValue(origin);
    for (openvdb::Index i = 0; i < 512; ++i) {
      if ((a != nullptr ? a->getValue(i) : a_all) == (b != nullptr ? b->getValue(i) : b_all)) continue;
      changed.insert(origin);
      return;
    }
  };
  for (auto leaf = phi_after.tree().cbeginLeaf(); leaf; ++leaf) compare(leaf->origin());
  for (auto leaf = phi_before.tree().cbeginLeaf(); leaf; ++leaf) {
    if (of_after.probeConstLeaf(leaf->origin()) == nullptr) compare(leaf->origin());
  }
  std::vector<std::array<int, 3>> leaves;
  for (const Coord& origin : changed) leaves.push_back({origin.x() >> 3, origin.y() >> 3, origin.z() >> 3});
  return leaves;
}

std::array<std::array<int, 3>, 8> FindCellLeaves(const std::array<int, 3>& leaf) {
  std::array<std::array<int, 3>, 8> leaves{};
  for (int i = 0; i < 8; ++i) {
    leaves[static_cast<std::size_t>(i)] = {leaf[0] - (i & 1), leaf[1] - ((i >> 1) & 1), leaf[2] - ((i >> 2) & 1)};
  }
  return leaves;
}

std::vector<RemovedCell> FindRemovedInLeaf(const Bone& before, const Bone& after, const std::array<int, 3>& leaf) {
  CheckSameVoxels(before, after);
  std::vector<RemovedCell> cells;
  CellFinder(before, after).Add(OriginOf(leaf), cells);
  return cells;
}

std::vector<RemovedCell> FindRemoved(const Bone& before, const Bone& after) {
  CheckSameVoxels(before, after);
  // A cell whose lowest corner is in one leaf may have other corners in the next leaves.
  std::set<Coord> leaves;
  for (const std::array<int, 3>& changed : FindChangedLeaves(before, after)) {
    for (const std::array<int, 3>& leaf : FindCellLeaves(changed)) leaves.insert(OriginOf(leaf));
  }
  const CellFinder finder(before, after);
  std::vector<RemovedCell> cells;
  for (const Coord& origin : leaves) finder.Add(origin, cells);
  return cells;
}

std::array<bool, 256> FindRegionsOf(const Bone& bone, Tissue tissue) {
  std::array<bool, 256> regions{};
  for (const auto& [id, region] : bone.materials().regions()) {
    if (region.tissue == tissue && id > 0 && id < 256) regions[static_cast<std::size_t>(id)] = true;
  }
  return regions;
}

struct PhiSampler::State {
  Accessor phi;
  double voxel_mm;
};

PhiSampler::PhiSampler(const Bone& bone)
    : state_(std::make_unique<State>(State{GridsOf(bone).phi->getConstAccessor(), bone.voxel_mm()})) {}
PhiSampler::~PhiSampler() = default;
PhiSampler::PhiSampler(PhiSampler&&) noexcept = default;
PhiSampler& PhiSampler::operator=(PhiSampler&&) noexcept = default;

double PhiSampler::Calc(const Vec3& p_W) const {
  return SampleTrilinear(state_->phi, p_W / state_->voxel_mm);
}

double PhiSampler::voxel_mm() const {
  return state_->voxel_mm;
}

}  // namespace kerf
