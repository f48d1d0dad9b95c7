#include "bone/grid/fill_voids.h"

#include <cmath>
#include <cstdint>

#include "bone/grid/leaf_mask.h"

namespace kerf {
namespace {

using openvdb::BoolTree;
using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr float kSolid = -1;

/// The blocks of the size of a leaf in a box around all leaves of a field, flooded from outside through faces.
class BlockFlood {
 public:
  explicit BlockFlood(const FloatTree& field) {
    field.getNodes(leaves_);
    for (const FloatLeaf* leaf : leaves_) box_.expand(IndexOf(leaf->origin()));
    box_.expand(1);
    states_.assign(box_.volume(), kOpen);
    const openvdb::tree::ValueAccessor<const FloatTree> values(field);
    std::size_t place = 0;
    for (auto index = box_.begin(); index; ++index) {
      states_[place++] = values.getValue(OriginAt(*index)) < 0 ? kSolidBlock : kOpen;
    }
    outside_.assign(leaves_.size(), {});
    for (std::size_t n = 0; n < leaves_.size(); ++n) {
      states_[PlaceOf(IndexOf(leaves_[n]->origin()))] = static_cast<std::int32_t>(n);
      outside_[n] = MaskOf(leaves_[n]->buffer().data());
      for (std::uint64_t& word : outside_[n]) word = ~word;
    }
    reached_.assign(leaves_.size(), {});
    Reach(box_.min());  // the outermost layer of blocks has no leaves
    Run();
  }

  /// Returns the voxels that are not solid and were not reached.
  BoolTree FindVoids() const {
    BoolTree voids(false);
    std::size_t place = 0;
    for (auto index = box_.begin(); index; ++index) {
      const std::int32_t state = states_[place++];
      if (state == kOpen) voids.addTile(1, OriginAt(*index), true, true);
      if (state < 0) continue;
      const auto n = static_cast<std::size_t>(state);
      if (outside_[n] == reached_[n]) continue;
      BoolTree::LeafNodeType* const to = voids.touchLeaf(OriginAt(*index));
      for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
        if (((outside_[n][i / 64] & ~reached_[n][i / 64]) >> i % 64 & 1) != 0) to->setValueOn(i, true);
      }
    }
    return voids;
  }

  /// Reaches all that was not reached. Returns the number of its parts that are not connected.
  std::size_t FloodRest() {
    std::size_t count = 0;
    std::size_t place = 0;
    for (auto index = box_.begin(); index; ++index) {
      const std::int32_t state = states_[place++];
      if (state == kOpen) {
        Reach(*index);
        Run();
        ++count;
      }
      for (std::size_t x = 0; state >= 0 && x < 8; ++x) {
        const auto n = static_cast<std::size_t>(state);
        while (const std::uint64_t rest = outside_[n][x] & ~reached_[n][x]) {
          reached_[n][x] |= rest & (~rest + 1);
          open_.push_back(*index);
          Run();
          ++count;
        }
      }
    }
    return count;
  }

 private:
  // States of blocks without a leaf; the others have the number of their leaf.
  static constexpr std::int32_t kSolidBlock = -1, kOpen = -2, kReachedBlock = -3;

  static Coord IndexOf(const Coord& origin) { return origin >> 3; }
  static Coord OriginAt(const Coord& index) { return index << 3; }
  std::size_t PlaceOf(const Coord& index) const {
    const Coord from = index - box_.min(), size = box_.dim();
    return (static_cast<std::size_t>(from.x()) * size.y() + from.y()) * size.z() + from.z();
  }
  void Reach(const Coord& index) {
    states_[PlaceOf(index)] = kReachedBlock;
    open_.push_back(index);
  }

  void Run() {
    while (!open_.empty()) {
      const Coord index = open_.back();
      open_.pop_back();
      Spread(index);
    }
  }

  void Spread(const Coord& index) {
    const std::int32_t state = states_[PlaceOf(index)];
    LeafMask mask;
    mask.fill(~std::uint64_t{0});
    if (state >= 0) {
      const auto n = static_cast<std::size_t>(state);
      Flood(outside_[n], reached_[n]);
      mask = reached_[n];
    }
    for (std::size_t side = 0; side < 6; ++side) {
      Coord beside = index;
      beside[static_cast<int>(side / 2)] += side % 2 == 0 ? -1 : 1;
      if (!box_.isInside(beside)) continue;
      const LeafMask across = Across(mask, side);
      const std::int32_t other = states_[PlaceOf(beside)];
      if (other == kOpen && !IsEmpty(across)) Reach(beside);
      if (other < 0) continue;
      const auto n = static_cast<std::size_t>(other);
      LeafMask added{};
      for (std::size_t x = 0; x < 8; ++x) added[x] = across[x] & outside_[n][x] & ~reached_[n][x];
      if (IsEmpty(added)) continue;
      for (std::size_t x = 0; x < 8; ++x) reached_[n][x] |= added[x];
      open_.push_back(beside);
    }
  }

  std::vector<const FloatLeaf*> leaves_;
  openvdb::CoordBBox box_;  // of the blocks, by index
  std::vector<std::int32_t> states_;
  std::vector<LeafMask> outside_;  // of each leaf: the voxels that are not solid
  std::vector<LeafMask> reached_;
  std::vector<Coord> open_;  // blocks from which the flood goes on
};

}  // namespace

FilledVoids FillVoids(FloatTree& field, double voxel_mm, std::vector<Coord>& filled_blocks) {
  if (field.leafCount() == 0) return {};  // no surface, so nothing is enclosed
  BlockFlood flood(field);
  const BoolTree voids = flood.FindVoids();
  const std::size_t count = flood.FloodRest();
  for (auto it = voids.cbeginValueOn(); it; ++it) {
    if (it.isVoxelValue()) {
      field.setValueOn(it.getCoord(), kSolid);
    } else {
      field.addTile(1, it.getCoord(), kSolid, false);
      filled_blocks.push_back(it.getCoord());
    }
  }
  return {count, static_cast<double>(voids.activeVoxelCount()) * std::pow(voxel_mm, 3)};
}

}  // namespace kerf
