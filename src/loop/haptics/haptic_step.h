// One tick, from the device's handle to the device's motors. It has no clock and no thread; the loop passes in the
// time.
#pragma once

#include <cstdint>
#include <limits>

#include "device/devices/velocity.h"
#include "kerf/coupled.h"
#include "kerf/device.h"
#include "loop/haptics/force_map.h"
#include "loop/record/step.h"

namespace kerf {

/// Bits of HapticTick::faults: reasons why this tick has no force.
enum HapticFault : std::uint32_t {
  kHapticOk = 0,
  kHapticForceOff = 1u << 0,     // requested by the caller
  kHapticReadFailed = 1u << 1,   // no sample was read; the simulation does not advance
  kHapticBadSample = 1u << 2,    // the device returned an invalid pose; the last valid one is used
  kHapticWriteFailed = 1u << 3,  // the force of this tick did not reach the device
  kHapticBadForce = 1u << 4,     // the simulation returned an invalid force
};

/// A tick with its inputs and results.
struct HapticTick {
  TickInputs in;  // X: on the lattice of device/devices/lattice.h, unless it is invalid
  Pose X_WH;      // the last valid pose of the handle
  Vec3 v_H_W_mm_per_s{0};
  Vec3 w_H_W_rad_per_s{0};
  CoupledOutput coupled;
  ForceMapOutput force;  // written to the device; zero if the device did not accept it
  std::uint32_t faults = kHapticOk;
};

/// Reads the device, rounds its pose to the lattice of device/devices/lattice.h (steps of 4e-9 mm), estimates the
/// handle's velocity, advances the simulation, maps the force and writes it. Any fault sets the force to zero in the
/// same tick; the force is ramped in afterwards.
class HapticStep {
 public:
  /// `simulation` must outlive this object. Throws a kerf::Error that names the first value that is out of range.
  HapticStep(CoupledSimulation& simulation, const DeviceProfile& profile, const ForceMapParams& force_map = {});

  /// Sets the time for the force's slew limit, if it is shorter than a tick's dt_s. Tick-safe.
  void set_slew_dt_s(double slew_dt_s) { slew_dt_s_ = slew_dt_s; }
  /// Runs a tick with the time step, the spindle speed and kRecordedForceOff of `in`, and fills in what the device
  /// reports. `stands`: the simulation does not advance in this tick; the force falls to zero at the slew rate and is
  /// ramped in afterwards. Tick-safe.
  HapticTick Step(Device& device, const TickInputs& in, TickObserver* observer = nullptr, bool stands = false);

  /// Call this after the device has had zero force: the force is ramped in from now on. Tick-safe.
  void RampIn() { force_map_.Reset(); }

  const ForceMap& force_map() const { return force_map_; }
  struct Counts {
    std::uint64_t read_failed = 0;
    std::uint64_t write_failed = 0;
    std::uint64_t bad_samples = 0;
    std::uint64_t bad_forces = 0;
  };
  const Counts& counts() const { return counts_; }
  /// True once a valid pose has been read.
  bool has_pose() const { return has_pose_; }

 private:
  /// Reads the device and estimates the handle's velocity. Returns false if there is no valid pose.
  bool ReadHandle(Device& device, HapticTick& out);
  void Simulate(TickObserver* observer, HapticTick& out);

  CoupledSimulation* simulation_;
  ForceMap force_map_;
  AdaptiveVelocity velocity_;
  AdaptiveVelocity turning_;
  Vec3 turned_W_rad_{0};  // sum of the small rotations of the handle, for turning_
  Pose X_WH_;
  bool has_pose_ = false;
  double slew_dt_s_ = std::numeric_limits<double>::infinity();
  bool write_failed_ = false;
  Counts counts_;
};

}  // namespace kerf
