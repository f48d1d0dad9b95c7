#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <unordered_map>

#include "bone/grids.h"
#include "bone/surface.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr std::uint16_t kOutside = 0xffff;

/// One leaf-sized block: which of its own connected parts each voxel belongs to.
struct Block {
  Coord origin;
  const FloatLeaf* leaf = nullptr;  // null: a block of an inside tile, all one part
  std::array<std::uint16_t, 512> part{};
  std::uint16_t part_count = 0;
  std::size_t first_node = 0;  // of its parts among all blocks' parts
};

int VoxelOffset(int x, int y, int z) {
  return 64 * x + 8 * y + z;
}

/// Numbers the face-connected parts of the inside voxels of one leaf.
void LabelLeaf(Block& block) {
  block.part.fill(kOutside);
  std::array<int, 512> stack;
  for (int seed = 0; seed < 512; ++seed) {
    if (block.part[seed] != kOutside || block.leaf->getValue(seed) >= 0) continue;
    const std::uint16_t label = block.part_count++;
    int depth = 0;
    stack[depth++] = seed;
    block.part[seed] = label;
    while (depth > 0) {
      const int at = stack[--depth];
      const int coordinate[3] = {at >> 6, (at >> 3) & 7, at & 7};
      constexpr int kStride[3] = {64, 8, 1};
      for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
          const int moved = coordinate[axis] + side;
          if (moved < 0 || moved > 7) continue;
          const int next = at + side * kStride[axis];
          if (block.part[next] != kOutside || block.leaf->getValue(next) >= 0) continue;
          block.part[next] = label;
          stack[depth++] = next;
        }
      }
    }
  }
}

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t Find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::size_t a, std::size_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

std::vector<Block> LabelBlocks(const FloatTree& tree) {
  std::vector<Block> blocks;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    Block block;
    block.origin = leaf->origin();
    block.leaf = leaf.getLeaf();
    blocks.push_back(block);
  }
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (*tile >= 0 || !tile.getBoundingBox(box)) continue;
    for (int x = box.min().x(); x <= box.max().x(); x += 8) {
      for (int y = box.min().y(); y <= box.max().y(); y += 8) {
        for (int z = box.min().z(); z <= box.max().z(); z += 8) {
          Block block;
          block.origin = Coord(x, y, z);
          block.part_count = 1;
          blocks.push_back(block);
        }
      }
    }
  }
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
    if (blocks[n].leaf) LabelLeaf(blocks[n]);
  });
  return blocks;
}

/// Joins parts that touch across the face between a block and its upper neighbour along `axis`.
void JoinAcrossFace(const Block& a, const Block& b, int axis, UnionFind& sets) {
  for (int u = 0; u < 8; ++u) {
    for (int v = 0; v < 8; ++v) {
      int low[3];
      low[axis] = 7;
      low[(axis + 1) % 3] = u;
      low[(axis + 2) % 3] = v;
      int high[3] = {low[0], low[1], low[2]};
      high[axis] = 0;
      const std::uint16_t pa = a.part[VoxelOffset(low[0], low[1], low[2])];
      const std::uint16_t pb = b.part[VoxelOffset(high[0], high[1], high[2])];
      if (pa != kOutside && pb != kOutside) sets.Join(a.first_node + pa, b.first_node + pb);
    }
  }
}

}  // namespace

Pieces SplitPieces(const Bone& bone, double min_mm3) {
  const Bone::Grids& grids = bone.grids();
  const double voxel_mm3 = std::pow(grids.voxel_mm(), 3);
  std::vector<Block> blocks = LabelBlocks(grids.phi->tree());
  std::size_t node_count = 0;
  std::unordered_map<Coord, std::size_t> index;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    blocks[n].first_node = node_count;
    node_count += blocks[n].part_count;
    index.emplace(blocks[n].origin, n);
  }
  UnionFind sets(node_count);
  for (const Block& block : blocks) {
    for (int axis = 0; axis < 3; ++axis) {
      Coord next = block.origin;
      next[axis] += 8;
      const auto found = index.find(next);
      if (found != index.end()) JoinAcrossFace(block, blocks[found->second], axis, sets);
    }
  }

  // Voxels of each piece, largest first.
  std::unordered_map<std::size_t, std::size_t> voxel_count;
  for (const Block& block : blocks) {
    if (!block.leaf) {
      voxel_count[sets.Find(block.first_node)] += 512;
      continue;
    }
    for (const std::uint16_t part : block.part) {
      if (part != kOutside) ++voxel_count[sets.Find(block.first_node + part)];
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> order;  // voxels, root
  for (const auto& [root, count] : voxel_count) order.emplace_back(count, root);
  std::sort(order.begin(), order.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });

  Pieces result;
  for (const auto& [count, root] : order) {
    const double mm3 = static_cast<double>(count) * voxel_mm3;
    if (mm3 < min_mm3) {
      ++result.dust_count;
      result.dust_mm3 += mm3;
      continue;
    }
    // The leaves and tiles that hold this piece, and the leaves beside them for the outer side of the band. Other
    // pieces' voxels are outside.
    const auto is_ours = [&, r = root](const Block& block, std::uint16_t part) {
      return sets.Find(block.first_node + part) == r;
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
    piece.grids() = grids;
    piece.grids().phi = MakePhiGrid(grids.voxel_mm());
    FloatTree& tree = piece.grids().phi->tree();
    const float band = tree.background();
    for (std::size_t n = 0; n < blocks.size(); ++n) {
      const Block& block = blocks[n];
      if (!keep[n]) continue;
      if (!block.leaf) {
        if (is_ours(block, 0)) tree.addTile(1, block.origin, -band, false);
        continue;
      }
      auto leaf = std::make_unique<FloatLeaf>(*block.leaf);
      for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
        const std::uint16_t part = block.part[i];
        if (part != kOutside && !is_ours(block, part)) leaf->setValueOff(i, band);
      }
      tree.addLeaf(leaf.release());
    }
    openvdb::tools::pruneLevelSet(tree, band, -band);
    result.pieces.push_back(std::move(piece));
  }
  return result;
}

}  // namespace kerf
