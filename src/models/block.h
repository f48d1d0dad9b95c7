// Blocks and plates with layers of material, for experiments with a known answer.
#pragma once

#include <vector>

#include "core/describe.h"
#include "kerf/bone.h"

namespace kerf {

/// One layer of a block, from the top face (+z) down.
struct MaterialLayer {
  double thickness_mm = 0;
  int region = 24;
};

/// A box with edges along the axes of its own frame B, origin at the middle of its top face, z up (out of the bone).
struct BlockParams {
  Vec3 size_mm{40, 20, 20};
  Pose X_WB;                          // where it stands
  std::vector<MaterialLayer> layers;  // empty: region 24 throughout; the last one fills what is left
  double voxel_mm = 0.2;
};

/// Throws Error when a size is not positive, a layer names an unknown region, or the block would be too large.
Bone MakeBlock(const BlockParams& params, const MaterialTable& materials);

}  // namespace kerf
