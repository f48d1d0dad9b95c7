#include "cut/removal/metal_voxels.h"

namespace kerf {
namespace {

/// Returns the metal voxels of a leaf.
MetalVoxels::Leaf FindMetal(const BoneField& field, const LeafIndex& leaf) {
  MetalVoxels::Leaf metal;
  const Vec3 lowest_F = field.voxel_mm() * (8.0 * Vec3(leaf.x, leaf.y, leaf.z));
  for (int i = 0; i < BoneField::kLeafVoxels; ++i) {
    const Vec3 p_F = lowest_F + field.voxel_mm() * Vec3(i / 64, i / 8 % 8, i % 8);
    if (field.is_metal(field.RegionAt(p_F))) metal.set(static_cast<std::size_t>(i));
  }
  return metal;
}

}  // namespace

MetalVoxels::MetalVoxels(const BoneField& field) : field_(&field) {
  if (!field.has_metal()) return;
  places_.assign(field.place_count(), -1);
  const LeafIndex low = field.lowest(), high = field.highest();
  for (int x = low.x; x <= high.x; ++x) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z; ++z) {
        const LeafIndex leaf{x, y, z};
        if (field.kind(leaf) == BoneField::LeafKind::kOutside) continue;
        const Leaf metal = FindMetal(field, leaf);
        if (metal.none()) continue;
        places_[field.PlaceOf(leaf)] = static_cast<std::int32_t>(leaves_.size());
        leaves_.push_back(metal);
      }
    }
  }
}

}  // namespace kerf
