#include "bone/grid/removed.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "bone/grid/parts_reader.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;
using Accessor = openvdb::FloatGrid::ConstAccessor;
using RegionAccessor = openvdb::Int32Grid::ConstAccessor;

double InterpolatePhi(const PhiCorners& corners, const Vec3& f) {
  return std::max(Interpolate(corners.whole, f), Interpolate(corners.cut, f));
}

/// Returns the centre of the bone lost by a cell with these values, 0 to 1 along each axis.
Vec3 CalcLostMiddle(const PhiCorners& before, const PhiCorners& after) {
  constexpr int kSteps = 4;
  Vec3 sum{0};
  int count = 0;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Vec3 f = (Vec3(i / (kSteps * kSteps), i / kSteps % kSteps, i % kSteps) + 0.5) / static_cast<double>(kSteps);
    if (InterpolatePhi(before, f) >= 0 || InterpolatePhi(after, f) < 0) continue;
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

/// Finds the changed cells of leaf after leaf.
class CellFinder {
 public:
  CellFinder(const Bone& before, const Bone& after)
      : h_(before.voxel_mm()),
        band_(before.band_mm()),
        region_voxel_mm_(before.region_voxel_mm()),
        before_(GridsOf(before)),
        after_(GridsOf(after)),
        region_(GridsOf(before).region->getConstAccessor()) {}

  void Add(const Coord& origin, std::vector<RemovedCell>& cells) const {
    CellFields was(h_, band_);
    CellFields is(h_, band_);
    before_.Load(origin, was);
    after_.Load(origin, is);
    for (int i = 0; i < 512; ++i) {
      const int x = i >> 6, y = i >> 3 & 7, z = i & 7;
      const Coord c = origin + Coord(x, y, z);
      const double lost = was.CalcFraction(x, y, z) - is.CalcFraction(x, y, z);
      if (lost == 0) continue;
      const PhiCorners old = was.Corners(x, y, z);
      const Vec3 middle = lost < 0.999 ? CalcLostMiddle(old, is.Corners(x, y, z)) : Vec3(0.5);
      const Vec3 p_W = h_ * (Vec3(c.x(), c.y(), c.z()) + middle);
      cells.push_back({.p_W = p_W,
                       .mm3 = lost * h_ * h_ * h_,
                       .region = region_.getValue(NearestVoxel(p_W, region_voxel_mm_)),
                       .in_mm = -InterpolatePhi(old, middle)});
    }
  }

 private:
  double h_;
  double band_;
  double region_voxel_mm_;
  PartsReader before_;
  PartsReader after_;
  RegionAccessor region_;
};

}  // namespace

std::vector<std::array<int, 3>> FindChangedLeaves(const Bone& before, const Bone& after) {
  const openvdb::FloatGrid& phi_before = *GridsOf(before).phi;
  const openvdb::FloatGrid& phi_after = *GridsOf(after).phi;
  std::set<Coord> changed;
  Accessor of_before = phi_before.getConstAccessor();
  Accessor of_after = phi_after.getConstAccessor();
  const PartsReader parts_before(GridsOf(before)), parts_after(GridsOf(after));
  const auto compare = [&](const Coord& origin) {
    const auto* a = of_before.probeConstLeaf(origin);
    const auto* b = of_after.probeConstLeaf(origin);
    const float a_all = of_before.getValue(origin);
    const float b_all = of_after.getValue(origin);
    if (a == nullptr && b == nullptr) {
      if (a_all != b_all) changed.insert(origin);
      return;
    }
    for (openvdb::Index i = 0; i < 512; ++i) {
      if ((a != nullptr ? a->getValue(i) : a_all) == (b != nullptr ? b->getValue(i) : b_all)) continue;
      changed.insert(origin);
      return;
    }
    // Of two fields the smaller may have changed.
    const PhiParts was = parts_before.At(origin), is = parts_after.At(origin);
    if (!std::equal(was.cut, was.cut + 512, is.cut)) changed.insert(origin);
  };
  ForEachBlock(phi_after.tree(), compare);
  ForEachBlock(phi_before.tree(), [&](const Coord& origin) {
    if (of_after.probeConstLeaf(origin) == nullptr) compare(origin);
  });
  std::vector<std::array<int, 3>> leaves;
  for (const Coord& origin : changed) leaves.push_back({origin.x() >> 3, origin.y() >> 3, origin.z() >> 3});
  return leaves;
}

std::array<std::array<int, 3>, 27> FindCellLeaves(const std::array<int, 3>& leaf) {
  std::array<std::array<int, 3>, 27> leaves{};
  for (int i = 0; i < 27; ++i) {
    leaves[static_cast<std::size_t>(i)] = {leaf[0] + i / 9 - 1, leaf[1] + i / 3 % 3 - 1, leaf[2] + i % 3 - 1};
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
  PartsReader phi;
  double voxel_mm;
};

PhiSampler::PhiSampler(const Bone& bone)
    : state_(std::make_unique<State>(State{PartsReader(GridsOf(bone)), bone.voxel_mm()})) {}
PhiSampler::~PhiSampler() = default;
PhiSampler::PhiSampler(PhiSampler&&) noexcept = default;
PhiSampler& PhiSampler::operator=(PhiSampler&&) noexcept = default;

double PhiSampler::Calc(const Vec3& p_W) const {
  return state_->phi.Sample(p_W / state_->voxel_mm);
}

double PhiSampler::voxel_mm() const {
  return state_->voxel_mm;
}

}  // namespace kerf
