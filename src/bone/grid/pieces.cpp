#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <memory>
#include <unordered_map>
#include <unordered_set>

#include "bone/grid/labels.h"
#include "bone/grid/parts_reader.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

// A few voxels can enclose far less than their own volume. A piece whose voxels have a larger total volume than this is
// never a crumb.
constexpr double kMaybeCrumb_mm3 = 100 * kSmallestPiece_mm3;

}  // namespace

Pieces SplitPieces(const Bone& bone, double min_mm3) {
  const BoneGrids& grids = GridsOf(bone);
  const double voxel_mm3 = std::pow(grids.voxel_mm(), 3);
  const Labels labels = LabelInside(grids.phi->tree());
  const std::vector<LabelledBlock>& blocks = labels.blocks;
  const auto& index = labels.index;
  UnionFind<> sets(labels.node_count);
  ForEachTouch(labels, [&sets](std::size_t a, std::size_t b) { sets.Join(a, b); });

  // Number of voxels of each piece; `order` sorts them, largest first.
  std::unordered_map<std::size_t, std::size_t> voxel_count;
  for (const LabelledBlock& block : blocks) {
    if (!block.leaf) {
      voxel_count[sets.Find(block.first_node)] += 512;
      continue;
    }
    for (const std::uint16_t part : block.part) {
      if (part != kNoPart) ++voxel_count[sets.Find(block.first_node + part)];
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> order;  // voxels, root
  for (const auto& [root, count] : voxel_count) order.emplace_back(count, root);
  std::sort(order.begin(), order.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });

  // Copies the pieces with these roots: the leaves and tiles that contain them, and the adjacent leaves for the outer
  // side of the band. Voxels of other pieces become outside.
  const auto copy = [&](const std::unordered_set<std::size_t>& roots) {
    const auto is_ours = [&](const LabelledBlock& block, std::uint16_t part) {
      return roots.contains(sets.Find(block.first_node + part));
    };
    std::vector<char> keep(blocks.size(), 0);
    for (std::size_t n = 0; n < blocks.size(); ++n) {
      bool ours = false;
      for (std::uint16_t part = 0; part < blocks[n].part_count; ++part) ours = ours || is_ours(blocks[n], part);
      if (!ours) continue;
      for (int beside = 0; beside < 27; ++beside) {
        const Coord at =
            blocks[n].origin.offsetBy(8 * (beside / 9 - 1), 8 * (beside / 3 % 3 - 1), 8 * (beside % 3 - 1));
        const auto found = index.find(at);
        if (found != index.end()) keep[found->second] = 1;
      }
    }
    Bone piece;
    GridsOf(piece) = grids;
    GridsOf(piece).phi = openvdb::gridPtrCast<openvdb::FloatGrid>(grids.phi->copyGridWithNewTree());
    FloatTree& tree = GridsOf(piece).phi->tree();
    const float band = tree.background();
    for (std::size_t n = 0; n < blocks.size(); ++n) {
      const LabelledBlock& block = blocks[n];
      if (!keep[n]) continue;
      if (!block.leaf) {
        if (is_ours(block, 0)) tree.addTile(1, block.origin, -band, false);
        continue;
      }
      auto leaf = std::make_unique<FloatLeaf>(*block.leaf);
      std::vector<char> is_other(block.part_count);
      for (std::uint16_t part = 0; part < block.part_count; ++part) is_other[part] = is_ours(block, part) ? 0 : 1;
      for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
        const std::uint16_t part = block.part[i];
        if (part != kNoPart && is_other[part] != 0) leaf->setValueOff(i, band);
      }
      tree.addLeaf(leaf.release());
    }
    CopyParts(grids, GridsOf(piece));
    openvdb::tools::pruneLevelSet(tree, band, -band);
    return piece;
  };

  Pieces result;
  std::unordered_set<std::size_t> dust;
  for (const auto& [count, root] : order) {
    const double mm3 = static_cast<double>(count) * voxel_mm3;
    if (mm3 < min_mm3) {
      dust.insert(root);
      result.dust_mm3 += mm3;
      continue;
    }
    Bone piece = copy({root});
    if (mm3 < kMaybeCrumb_mm3) {
      if (const double exact_mm3 = piece.CalcVolume(); exact_mm3 < kSmallestPiece_mm3) {
        dust.insert(root);
        result.dust_mm3 += exact_mm3;
        continue;
      }
    }
    result.pieces.push_back(std::move(piece));
  }
  result.dust_count = dust.size();
  if (!dust.empty()) result.dust = copy(dust);
  return result;
}

}  // namespace kerf
