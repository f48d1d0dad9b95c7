// Interface to a haptic device, which reports the pose of its handle and outputs a force. Poses and forces are in the
// world frame: the scene's mapping has already been applied.
#pragma once

#include <cstdint>
#include <string>

#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// Maximum delay of a device's force, in addition to the loop's own, for which couplings are computed.
inline constexpr int kMaxDelay_ticks = 16;
template <typename V>
void DescribeDelay(int& delay_ticks, V&& visit) {
  visit(
      "delay_ticks", delay_ticks, Range{0, kMaxDelay_ticks},
      "delay of the device's force in ticks, in addition to the loop's own: 2 for a device that has a separate thread");
}

/// Capabilities of a device. A value of 0 means unknown.
struct DeviceProfile {
  std::string name;
  int degrees_of_freedom = 3;  // number of degrees of freedom with motors; 3: forces only, 6: also torques
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
  double friction_N = 0;                // felt by the hand when it moves the handle
  double mass_kg = 0.1;                 // apparent mass of the handle
  double own_damping_Ns_per_mm = 1e-4;  // damping of the handle's bearings
  std::string source;                   // source of the values, and how reliable they are
};

/// What the loop reads. A DriverSample has what the device itself reports instead: in its own frame, with homing and
/// deflections, before the scene's mapping.
struct DeviceSample {
  Pose X_WH;  // pose of the tool frame that the handle requests
  std::uint32_t buttons = 0;
};

/// The loop calls Elapse, Read and Write once per tick, in this order. They must return within a fraction of a tick and
/// must not allocate. Read and Write return false if the device has failed.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceProfile& profile() const = 0;
  /// Passes the time since the last tick, s. Only simulated devices need it.
  virtual void Elapse(double /*dt_s*/) noexcept {}
  /// Returns the current pose of the handle and its buttons in `sample`.
  virtual bool Read(DeviceSample& sample) noexcept = 0;
  /// Sets the force and the torque on the hand.
  virtual bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept = 0;
  /// Passes the pose of the tool after a tick. Only a device that is coupled to the tool again needs it: the tool may
  /// be behind the handle that pulls it.
  virtual void TakeToolPose(const Pose& /*X_WT*/) noexcept {}
};

}  // namespace kerf
