#include "cut/hand_sim/setup.h"

#include <fmt/format.h>

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

}  // namespace kerf
