#include "cut/hand_sim/setup.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {
void CheckParams(const CoupledParams& p) {
  Validate(p.tool);
  CheckParameters(p.coupling, "coupling");
  CheckEffects(p.effects);
  CheckParameters(p);
}

Pose MakeStart(const Pose& X_WT) {
  if (!IsValid(X_WT)) throw Error("the tool's start pose is not finite or its quaternion is not of unit length");
  if (!IsInWorld(X_WT.p_AB)) {
    throw Error(fmt::format("the tool's start position is more than {} mm from the world origin", kWorldReach_mm));
  }
  return X_WT;
}

int CountOldLeaves(const BoneField& field, const CoupledParams& params) {
  const int max_count = std::max(4096, params.spare_leaves);
  const LeafIndex low = field.lowest();
  const LeafIndex high = field.highest();
  int count = 0;
  for (int x = low.x; x <= high.x; ++x) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z && count < max_count; ++z) {
        count += field.kind({x, y, z}) == BoneField::LeafKind::kOwn ? 1 : 0;
      }
    }
  }
  return count;
}

}  // namespace kerf
