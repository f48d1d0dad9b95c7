// The hand on the handle, as far as it moves by itself: below about 10 Hz it goes where it wants, above it is a mass on
// a spring and a damper.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// m a = f - b (v - v_wanted) - k (x - x_wanted), the same along each axis. The mass moves with the handle.
struct HandModel {
  std::string name;
  double mass_kg = 0;
  double damping_Ns_per_mm = 0;
  double stiffness_N_per_mm = 0;
  /// Turning, for devices that drive it: without inertia. 0: the handle's orientation follows the hand's at once.
  double torsion_Nmm_per_rad = 0;
  double torsion_damping_Nmms = 0;
  std::string source;  // of the figures, and how sure they are
};

/// H0 (released), H1 (light pinch), H2 (pen grip), H3 (arm holding a posture), H4 (firm power grip).
const std::vector<HandModel>& HandModels();

/// Throws Error that names those there are.
const HandModel& FindHandModel(const std::string& name);

}  // namespace kerf
