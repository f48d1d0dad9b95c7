#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "bone/grid/labels.h"
#include "bone/grid/parts_reader.h"
#include "kerf/surface.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

// The voxels of a thin piece have a far larger total volume than the piece. Above this multiple of the threshold it is
// never a crumb.
constexpr double kMaybeCrumb = 100;

/// Connected inside voxels.
struct ConnectedPart {
  std::size_t root = 0, voxels = 0;
  Coord voxel;                      // one of them
  float deepest_mm = 0;             // smallest phi
  std::vector<std::size_t> blocks;  // that have some of them
};

/// `dust_only`: leaves out the pieces, whose copies take memory.
Pieces Split(const Bone& bone, double min_mm3, const Bone* before, bool dust_only) {
  const BoneGrids& grids = GridsOf(bone);
  const double voxel_mm3 = std::pow(grids.voxel_mm(), 3);
  const Labels labels = LabelInside(grids.phi->tree());
  const std::vector<LabelledBlock>& blocks = labels.blocks;
  const auto& index = labels.index;
  UnionFind<> sets(labels.node_count);
  ForEachTouch(labels, [&sets](std::size_t a, std::size_t b) { sets.Join(a, b); });

  std::unordered_map<std::size_t, ConnectedPart> parts;  // by root
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const LabelledBlock& block = blocks[n];
    const auto add = [&](std::size_t part, openvdb::Index i, std::size_t voxels, float phi) {
      ConnectedPart& p = parts[sets.Find(block.first_node + part)];
      if (p.voxels == 0) p.voxel = block.origin + FloatLeaf::offsetToLocalCoord(i);
      p.voxels += voxels;
      p.deepest_mm = std::min(p.deepest_mm, phi);
      if (p.blocks.empty() || p.blocks.back() != n) p.blocks.push_back(n);
    };
    if (!block.leaf) add(0, 0, FloatLeaf::SIZE, -grids.phi->background());
    for (openvdb::Index i = 0; block.leaf && i < FloatLeaf::SIZE; ++i) {
      if (block.part[i] != kNoPart) add(block.part[i], i, 1, block.leaf->getValue(i));
    }
  }
  std::vector<const ConnectedPart*> order;  // largest first
  for (auto& [root, part] : parts) {
    part.root = root;
    order.push_back(&part);
  }
  std::sort(order.begin(), order.end(), [](const ConnectedPart* a, const ConnectedPart* b) {
    return a->voxels != b->voxels ? a->voxels > b->voxels : a->root < b->root;
  });

  // Copies these pieces: the leaves and tiles that contain them, and the adjacent leaves for the outer side of the
  // band. Voxels of other pieces become outside.
  std::vector<char> is_kept(blocks.size(), 0);
  const auto copy = [&](const std::vector<const ConnectedPart*>& wanted) {
    std::unordered_set<std::size_t> roots;
    std::vector<std::size_t> kept;
    for (const ConnectedPart* part : wanted) {
      roots.insert(part->root);
      for (const std::size_t n : part->blocks) {
        for (int beside = 0; beside < 27; ++beside) {
          const auto found = index.find(
              blocks[n].origin.offsetBy(8 * (beside / 9 - 1), 8 * (beside / 3 % 3 - 1), 8 * (beside % 3 - 1)));
          if (found != index.end() && !std::exchange(is_kept[found->second], 1)) kept.push_back(found->second);
        }
      }
    }
    std::sort(kept.begin(), kept.end());
    for (const std::size_t n : kept) is_kept[n] = 0;
    const auto is_ours = [&](const LabelledBlock& block, std::uint16_t part) {
      return roots.contains(sets.Find(block.first_node + part));
    };
    Bone piece;
    GridsOf(piece) = grids;
    GridsOf(piece).phi = openvdb::gridPtrCast<openvdb::FloatGrid>(grids.phi->copyGridWithNewTree());
    FloatTree& tree = GridsOf(piece).phi->tree();
    const float band = tree.background();
    for (const std::size_t n : kept) {
      const LabelledBlock& block = blocks[n];
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

  const auto calc_volume = [&](const std::vector<const ConnectedPart*>& wanted) {
    return wanted.empty() ? 0 : copy(wanted).CalcVolume();
  };

  Pieces result;
  const double least_mm3 = std::max(min_mm3, kSmallestPiece_mm3);
  const auto is_thin = [&](const ConnectedPart& part) {
    return -static_cast<double>(part.deepest_mm) < 0.5 * grids.voxel_mm();
  };
  std::vector<const ConnectedPart*> dust, old, thin;
  for (const ConnectedPart* part : order) {
    const double voxels_mm3 = static_cast<double>(part->voxels) * voxel_mm3;
    bool is_dust = 8 * voxels_mm3 < least_mm3;  // it lies in the eight cells around each of its voxels
    Bone piece;
    if (!is_dust) {
      const bool maybe_dust = voxels_mm3 < kMaybeCrumb * least_mm3;
      if (dust_only && !maybe_dust) continue;
      piece = copy({part});
      is_dust = maybe_dust && piece.CalcVolume() < least_mm3;
    }
    if (is_dust) {
      dust.push_back(part);
    } else {
      if (is_thin(*part)) thin.push_back(part);
      if (!dust_only) result.pieces.push_back(std::move(piece));
    }
  }
  if (!dust.empty()) result.dust = copy(dust);
  if (dust_only) return result;
  // Cutting only removes bone, so that each crumb lies in one piece or crumb of the bone before.
  const Bone before_dust = before != nullptr && !dust.empty() ? Split(*before, min_mm3, nullptr, true).dust : Bone();
  const FloatTree& tree = GridsOf(before_dust).phi->tree();
  for (const ConnectedPart* part : dust) {
    if (tree.getValue(part->voxel) < 0) {
      old.push_back(part);
    } else if (is_thin(*part)) {
      thin.push_back(part);
    }
  }
  result.dust_count = dust.size();
  result.dust_mm3 = dust.empty() ? 0 : result.dust.CalcVolume();
  if (before != nullptr) result.old_dust_count = old.size();
  result.old_dust_mm3 = calc_volume(old);
  result.thin_count = thin.size();
  result.thin_mm3 = calc_volume(thin);
  return result;
}

}  // namespace

Pieces SplitPieces(const Bone& bone, double min_mm3, const Bone* before) {
  return Split(bone, min_mm3, before, false);
}

}  // namespace kerf
