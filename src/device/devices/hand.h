// Models of the hand on a handle. Below about 10 Hz the hand follows its intended motion; above that, it acts as a mass
// with a spring and a damper.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// Along each axis, m a = f - b (v - v_wanted) - k (x - x_wanted). The mass moves with the handle.
struct HandModel {
  std::string name;
  double mass_kg = 0;
  double damping_Ns_per_mm = 0;
  double stiffness_N_per_mm = 0;
  /// Rotational spring and damper, without inertia, for devices that output torques. 0: the handle's orientation
  /// follows the hand immediately.
  double torsion_Nmm_per_rad = 0;
  double torsion_damping_Nmms = 0;
  std::string source;  // source of the values, and how reliable they are
};

/// Returns the built-in models: H0 (released), H1 (light pinch), H2 (pen grip), H3 (arm holding a posture), H4 (firm
/// power grip).
const std::vector<HandModel>& HandModels();

/// Returns the model of that name. Throws a kerf::Error that lists the valid names if there is none.
const HandModel& FindHandModel(const std::string& name);

}  // namespace kerf
