#include "bone/grid/set_leaf.h"

#include <algorithm>

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "bone/grid/lent_leaves.h"
#include "bone/grid/parts_reader.h"

namespace kerf {

void SetLeaf(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> values) {
  openvdb::FloatGrid& grid = *GridsOf(bone).phi;
  using Leaf = openvdb::FloatGrid::TreeType::LeafNodeType;
  static_assert(Leaf::SIZE == 512);
  Leaf& leaf = OwnLeaf(grid, OriginOf(index));
  const float band = grid.background();
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    const float phi = values[i];
    leaf.setValueOnly(i, phi);
    leaf.setActiveState(i, std::abs(phi) < band);
  }
}

void SetCut(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> cut) {
  BoneGrids& grids = GridsOf(bone);
  const openvdb::Coord origin = OriginOf(index);
  const auto is_air = [band = grids.phi->background()](float phi) { return phi >= band; };
  if (grids.phi->tree().probeConstLeaf(origin) == nullptr && is_air(grids.phi->tree().getValue(origin)) &&
      std::all_of(cut.begin(), cut.end(), is_air)) {
    return;
  }
  if (!grids.cut) AddPartGrids(grids);
  openvdb::FloatTree& cuts = grids.cut->tree();
  if (cuts.probeLeaf(origin) == nullptr && !(cuts.getValue(origin) > 0)) {
    if (const auto* whole = grids.phi->tree().probeConstLeaf(origin)) {
      auto* const copy = new openvdb::FloatTree::LeafNodeType(*whole);
      copy->setValuesOn();
      grids.whole->tree().addLeaf(copy);
      cuts.touchLeaf(origin)->setValuesOn();
    } else {
      cuts.addTile(1, origin, grids.phi->background(), true);
    }
  }
  auto* const own = cuts.probeLeaf(origin);
  if (own == nullptr) {
    SetLeaf(bone, index, cut);
    return;
  }
  const float* const whole = grids.whole->tree().probeConstLeaf(origin)->buffer().data();
  std::array<float, 512> phi;
  for (openvdb::Index i = 0; i < 512; ++i) {
    own->setValueOnly(i, cut[i]);
    phi[i] = std::max(whole[i], cut[i]);
  }
  SetLeaf(bone, index, phi);
}

void GetCut(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> cut) {
  const PartsReader reader(GridsOf(bone));
  std::copy_n(reader.At(OriginOf(index)).cut, 512, cut.begin());
}

void CutAway(Bone& bone, const Box3& bounds_W, const std::function<double(const Vec3&)>& depth_mm) {
  const double h = bone.voxel_mm();
  const double band = bone.band_mm();
  const auto leaf_of = [&](const Vec3& p_W) { return glm::ivec3(glm::floor(p_W / (8 * h))); };
  const glm::ivec3 first = leaf_of(bounds_W.lower - band);
  const glm::ivec3 last = leaf_of(bounds_W.upper + band);
  std::array<float, 512> was, cut;
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int z = first.z; z <= last.z; ++z) {
        const std::array<int, 3> index{x, y, z};
        GetLeaf(bone, index, was);
        if (std::all_of(was.begin(), was.end(), [&](float phi) { return static_cast<double>(phi) >= band; })) continue;
        GetCut(bone, index, was);
        for (int i = 0; i < 512; ++i) {
          const auto n = static_cast<std::size_t>(i);
          const Vec3 p_W = h * Vec3(8 * x + i / 64, 8 * y + i / 8 % 8, 8 * z + i % 8);
          cut[n] = std::max(was[n], static_cast<float>(std::clamp(depth_mm(p_W), -band, band)));
        }
        if (cut != was) SetCut(bone, index, cut);
      }
    }
  }
}

void GetLeaf(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> values) {
  const openvdb::FloatTree& tree = GridsOf(bone).phi->tree();
  const openvdb::Coord corner = OriginOf(index);
  if (const auto* leaf = tree.probeConstLeaf(corner)) {
    std::copy_n(leaf->buffer().data(), 512, values.begin());
  } else {
    std::fill(values.begin(), values.end(), tree.getValue(corner));
  }
}

}  // namespace kerf
