// Device, hand and coupling of a scene for `kerf loop`, computed before anything runs.
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
  double asked_stiffness_N_per_mm = 0;  // from the scene
  double asked_damping_Ns_per_mm = 0;   // from the scene
  double bending_N_per_mm = 0;          // of a blade that bends sideways; 0: the tool is rigid
};

/// Throws kerf::Error, with the place in the scene, for an unknown device or hand or an unreadable table of devices.
LoopSetup MakeLoopSetup(const Scene& scene);

/// Returns the number of leaves to reserve for cutting into solid bone: as many as the bone can use, up to a limit.
int CountSpareLeaves(const Bone& bone);

/// Returns a short description of the coupling, such as "1 N/mm (0.43 N/mm on the device)", with the values that were
/// lowered and the reasons.
std::string DescribeCoupling(const LoopSetup& setup);
/// Describes the limits set by the device, the loop and the encoder, in simulated units and as rendered on the device.
std::string DescribeLimits(const LoopSetup& setup);
/// Returns warnings about running the scene with a hand, in addition to those about bone and tool.
std::vector<std::string> FindHandWarnings(const Scene& scene, const LoopSetup& setup);

}  // namespace kerf
