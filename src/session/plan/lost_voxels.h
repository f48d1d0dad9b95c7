// What a bone lost between two states.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

struct LostVoxel {
  Vec3 p_W;       // centre of the voxel
  double weight;  // by how much phi rose, in voxels, at most 1
};
struct LostCell {
  Vec3 p_W;    // centre of the cell between eight voxel centres
  double mm3;  // of bone that it lost
};

struct Loss {
  std::vector<LostVoxel> voxels;
  std::vector<LostCell> cells;
};

/// Voxels whose phi rose by more than a quarter of a voxel, and cells that lost bone. `within`: of their centres;
/// `keep`: those that it says true of; null: all. Throws Error when the two have different voxels.
Loss FindLoss(const Bone& before, const Bone& after, const std::optional<Box3>& within,
              const std::function<bool(const Vec3& p_W)>& keep);

}  // namespace kerf
