// Bone that was removed between two states.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

struct LostVoxel {
  Vec3 p_W;       // centre of the voxel
  double weight;  // increase of phi, in voxels, at most 1
};
struct LostCell {
  Vec3 p_W;    // centre of the cell between eight voxel centres
  double mm3;  // volume of bone removed from it
};

struct Loss {
  std::vector<LostVoxel> voxels;
  std::vector<LostCell> cells;
};

/// Returns voxels whose phi increased by more than a quarter of a voxel, and cells that lost bone. `within`: box that
/// must contain their centres. `keep`: returns true for the centres to include; null: all. Throws kerf::Error if the
/// bones have different voxel sizes.
Loss FindLoss(const Bone& before, const Bone& after, const std::optional<Box3>& within,
              const std::function<bool(const Vec3& p_W)>& keep);

}  // namespace kerf
