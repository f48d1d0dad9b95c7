// A haptic device: where its handle is, and the force that it is to make. Frame of the device: world (the scene's
// mapping has been applied).
#pragma once

#include <cstdint>
#include <string>

#include "kerf/geometry.h"

namespace kerf {

/// What a device can do. Figures of 0 are not known.
struct DeviceProfile {
  std::string name;
  int degrees_of_freedom = 3;  // that it drives: 3 forces only, 6 torques too
  double peak_force_N = 12;
  double continuous_force_N = 0;
  double peak_torque_Nmm = 0;  // 0: none
  double continuous_torque_Nmm = 0;
  double max_stiffness_N_per_mm = 5;
  double max_damping_Ns_per_mm = 0.03;
  double max_torsion_Nmm_per_rad = 0;
  double max_torsion_damping_Nmms = 0;
  double resolution_mm = 0.01;  // of the handle's position
  double workspace_radius_mm = 75;
  double friction_N = 0;                // that the hand feels when it is driven back
  double mass_kg = 0.1;                 // apparent, of the handle
  double own_damping_Ns_per_mm = 1e-4;  // of its bearings
  std::string source;                   // of the figures, and how sure they are
};

struct DeviceSample {
  Pose X_WH;  // of the tool frame, as the hand asks for it
  std::uint32_t buttons = 0;
};

/// Elapse, Read and Write are called from the loop, once a tick and in this order, and must be back within a fraction
/// of it; none allocates. False: the device has failed.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceProfile& profile() const = 0;
  /// How long ago the last tick was, s. Only a simulated device needs to be told.
  virtual void Elapse(double /*dt_s*/) noexcept {}
  virtual bool Read(DeviceSample& sample) noexcept = 0;
  /// Force and torque on the hand.
  virtual bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept = 0;
};

}  // namespace kerf
