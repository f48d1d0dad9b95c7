// Connected parts of a bone's inside: voxels with phi < 0 that share a face.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "bone/grid/grids.h"

namespace kerf {

inline constexpr std::uint16_t kNoPart = 0xffff;  // an outside voxel

/// One leaf-sized block, and for each voxel the number of the connected part of the block that it belongs to.
struct LabelledBlock {
  openvdb::Coord origin;
  const openvdb::FloatTree::LeafNodeType* leaf = nullptr;  // null: the block lies in an inside tile and is one part
  std::array<std::uint16_t, 512> part{};
  std::uint16_t part_count = 0;
  std::size_t first_node = 0;  // number of its first part among the parts of all blocks
};

/// All blocks that contain or may contain inside voxels. A node is one part of one block.
struct Labels {
  std::vector<LabelledBlock> blocks;
  std::size_t node_count = 0;
  std::unordered_map<openvdb::Coord, std::size_t> index;  // from origin to block
};

/// Labels the inside voxels of a tree. All voxels of a part have the same class; without `classify` there is only one
/// class. A block of an inside tile must lie in one class. `classify` must be thread-safe. The labels point into the
/// tree.
Labels LabelInside(const openvdb::FloatTree& tree, const std::function<int(const openvdb::Coord&)>& classify = {});

/// Calls visit(node, node) for face-sharing voxels of different parts; a pair may be visited many times.
void ForEachTouch(const Labels& labels, const std::function<void(std::size_t, std::size_t)>& visit);

template <typename Index = std::size_t>
class UnionFind {
 public:
  explicit UnionFind(Index n = 0) { Reset(n); }
  /// Makes each of `n` elements a separate set; keeps the allocated memory.
  void Reset(Index n) {
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }
  Index Find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(Index a, Index b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::size_t size() const { return parent_.size(); }
  std::size_t CalcMemoryBytes() const { return parent_.capacity() * sizeof(Index); }

 private:
  std::vector<Index> parent_;
};

}  // namespace kerf
