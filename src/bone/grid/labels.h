// The connected parts of a bone's inside: voxels with phi < 0 that share a face.
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

/// One leaf-sized block: which of its own connected parts each voxel belongs to.
struct LabelledBlock {
  openvdb::Coord origin;
  const openvdb::FloatTree::LeafNodeType* leaf = nullptr;  // null: a block of an inside tile, all one part
  std::array<std::uint16_t, 512> part{};
  std::uint16_t part_count = 0;
  std::size_t first_node = 0;  // of its parts among all blocks' parts
};

/// All blocks that hold inside voxels or may. A node is one part of one block.
struct Labels {
  std::vector<LabelledBlock> blocks;
  std::size_t node_count = 0;
  std::unordered_map<openvdb::Coord, std::size_t> index;  // from origin to block
};

/// A part holds voxels of one class only; without `classify` there is one class. A block of an inside tile must lie in
/// one class. `classify` must be thread-safe. The labels point into the tree.
Labels LabelInside(const openvdb::FloatTree& tree, const std::function<int(const openvdb::Coord&)>& classify = {});

/// Calls visit(node, node) for the face-sharing voxels of different parts; a pair may come many times.
void ForEachTouch(const Labels& labels, const std::function<void(std::size_t, std::size_t)>& visit);

template <typename Index = std::size_t>
class UnionFind {
 public:
  explicit UnionFind(Index n = 0) { Reset(n); }
  /// Each of n by itself again; keeps its memory.
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
