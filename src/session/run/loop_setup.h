// What a scene's device, hand and coupling come to in `kerf loop`, before anything runs.
#pragma once

#include <string>
#include <vector>

#include "kerf/bone.h"
#include "loop/haptics/coupling_limits.h"
#include "loop/haptics/force_map.h"
#include "session/scene/scene.h"

namespace kerf {

struct LoopSetup {
  DeviceProfile profile;
  HandModel hand;
  ForceMapParams force_map;
  double force_scale = 1;  // device N per simulation N
  FittedCoupling fitted;
  double asked_stiffness_N_per_mm = 0;  // by the scene
  double asked_damping_Ns_per_mm = 0;   // likewise
};

/// Throws Error for a device or hand that there is none of, or a table of devices that can't be read, with the place in
/// the scene that names it.
LoopSetup MakeLoopSetup(const Scene& scene);

/// Leaves set aside for cutting into pure bone: as many as the bone has room for, within reason.
int CountSpareLeaves(const Bone& bone);

/// What a newcomer would want to know: what is below its limits and why, "1 N/mm (0.43 N/mm on the device)".
std::string DescribeCoupling(const LoopSetup& setup);
/// What device, loop and encoder allow, both as the simulation and as the device has it.
std::string DescribeLimits(const LoopSetup& setup);
/// What one would do well to know before running the scene in a hand, besides the bone's and the tool's own.
std::vector<std::string> FindHandDoubts(const Scene& scene, const LoopSetup& setup);

}  // namespace kerf
