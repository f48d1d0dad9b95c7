#include "bone/grid/labels.h"

#include <tbb/parallel_for.h>

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using Classes = std::array<int, 512>;

constexpr int kStride[3] = {64, 8, 1};

/// Numbers the face-connected parts of the inside voxels of one leaf.
void LabelLeaf(LabelledBlock& block, const Classes& classes) {
  block.part.fill(kNoPart);
  std::array<int, 512> stack;
  for (int seed = 0; seed < 512; ++seed) {
    if (block.part[seed] != kNoPart || block.leaf->getValue(seed) >= 0) continue;
    const std::uint16_t label = block.part_count++;
    int depth = 0;
    stack[depth++] = seed;
    block.part[seed] = label;
    while (depth > 0) {
      const int at = stack[--depth];
      const int coordinate[3] = {at >> 6, (at >> 3) & 7, at & 7};
      for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
          const int moved = coordinate[axis] + side;
          if (moved < 0 || moved > 7) continue;
          const int next = at + side * kStride[axis];
          if (block.part[next] != kNoPart || block.leaf->getValue(next) >= 0 || classes[next] != classes[at]) continue;
          block.part[next] = label;
          stack[depth++] = next;
        }
      }
    }
  }
}

/// Visits parts that touch within a block (their classes differ).
void VisitWithin(const LabelledBlock& block, const std::function<void(std::size_t, std::size_t)>& visit) {
  if (block.part_count < 2) return;
  for (int at = 0; at < 512; ++at) {
    if (block.part[at] == kNoPart) continue;
    const int coordinate[3] = {at >> 6, (at >> 3) & 7, at & 7};
    for (int axis = 0; axis < 3; ++axis) {
      if (coordinate[axis] == 7) continue;
      const std::uint16_t other = block.part[at + kStride[axis]];
      if (other == kNoPart || other == block.part[at]) continue;
      visit(block.first_node + block.part[at], block.first_node + other);
    }
  }
}

/// Visits parts that touch across the face between a block and its upper neighbour along `axis`.
void VisitAcrossFace(const LabelledBlock& a, const LabelledBlock& b, int axis,
                     const std::function<void(std::size_t, std::size_t)>& visit) {
  const int u_stride = kStride[(axis + 1) % 3];
  const int v_stride = kStride[(axis + 2) % 3];
  for (int u = 0; u < 8; ++u) {
    for (int v = 0; v < 8; ++v) {
      const int beside = u * u_stride + v * v_stride;
      const std::uint16_t pa = a.part[7 * kStride[axis] + beside];
      const std::uint16_t pb = b.part[beside];
      if (pa != kNoPart && pb != kNoPart) visit(a.first_node + pa, b.first_node + pb);
    }
  }
}

}  // namespace

Labels LabelInside(const FloatTree& tree, const std::function<int(const Coord&)>& classify) {
  Labels labels;
  std::vector<LabelledBlock>& blocks = labels.blocks;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    LabelledBlock block;
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
          LabelledBlock block;
          block.origin = Coord(x, y, z);
          block.part_count = 1;
          blocks.push_back(block);
        }
      }
    }
  }
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t n) {
    LabelledBlock& block = blocks[n];
    if (!block.leaf) return;
    Classes classes{};
    if (classify) {
      for (openvdb::Index i = 0; i < classes.size(); ++i) classes[i] = classify(block.leaf->offsetToGlobalCoord(i));
    }
    LabelLeaf(block, classes);
  });
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    blocks[n].first_node = labels.node_count;
    labels.node_count += blocks[n].part_count;
    labels.index.emplace(blocks[n].origin, n);
  }
  return labels;
}

void ForEachTouch(const Labels& labels, const std::function<void(std::size_t, std::size_t)>& visit) {
  for (const LabelledBlock& block : labels.blocks) {
    VisitWithin(block, visit);
    for (int axis = 0; axis < 3; ++axis) {
      Coord next = block.origin;
      next[axis] += 8;
      const auto found = labels.index.find(next);
      if (found != labels.index.end()) VisitAcrossFace(block, labels.blocks[found->second], axis, visit);
    }
  }
}

}  // namespace kerf
