#include "bone/grid/set_leaf.h"

#include <algorithm>

#include <cmath>

#include "bone/grid/grids.h"

namespace kerf {

void SetLeaf(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> values) {
  openvdb::FloatGrid& grid = *GridsOf(bone).phi;
  using Leaf = openvdb::FloatGrid::TreeType::LeafNodeType;
  static_assert(Leaf::SIZE == 512);
  const openvdb::Coord origin(index[0] * static_cast<int>(Leaf::DIM), index[1] * static_cast<int>(Leaf::DIM),
                              index[2] * static_cast<int>(Leaf::DIM));
  Leaf* leaf = grid.tree().touchLeaf(origin);
  const float band = grid.background();
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    const float phi = values[i];
    leaf->setValueOnly(i, phi);
    leaf->setActiveState(i, std::abs(phi) < band);
  }
}

void GetLeaf(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> values) {
  const openvdb::FloatTree& tree = GridsOf(bone).phi->tree();
  const openvdb::Coord corner(8 * index[0], 8 * index[1], 8 * index[2]);
  if (const auto* leaf = tree.probeConstLeaf(corner)) {
    std::copy_n(leaf->buffer().data(), 512, values.begin());
  } else {
    std::fill(values.begin(), values.end(), tree.getValue(corner));
  }
}

}  // namespace kerf
