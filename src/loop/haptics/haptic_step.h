// One tick from the device's handle to the device's motors. It has no clock and no thread: the loop gives the time.
#pragma once

#include <cstdint>
#include <limits>

#include "device/devices/device.h"
#include "device/devices/velocity.h"
#include "kerf/coupled.h"
#include "loop/haptics/force_map.h"

namespace kerf {

struct HapticStepInput {
  double dt_s = 0.001;  // since the last step: what the simulation moves on by
  double rpm = 7500;    // of the spindle
  bool force_off =
      false;  // the watchdog has bitten, or the operator wants no force: zero at once, ramped in afterwards
  // The simulation does not move on in this tick. The force goes to zero by its slew, and comes by the ramp afterwards.
  bool stand = false;
  double slew_dt_s = std::numeric_limits<double>::infinity();  // if shorter, what the force's slew moves on by
};

/// Bits of HapticStepOutput::faults: why there is no force in this tick.
enum HapticFault : std::uint32_t {
  kHapticOk = 0,
  kHapticForceOff = 1u << 0,     // told so
  kHapticReadFailed = 1u << 1,   // the simulation stands still meanwhile
  kHapticBadSample = 1u << 2,    // the device gave a pose that is none: the last good one is held
  kHapticWriteFailed = 1u << 3,  // the force of this tick did not reach the device
  kHapticBadForce = 1u << 4,     // the simulation gave a force that is none
};

/// What the device said in a step: with the rest of HapticStepInput all that a step depends on.
struct HapticGiven {
  DeviceSample sample;  // on the lattice of devices/lattice.h, unless it is none
  bool read = true;     // false: the device told no pose
  bool wrote = true;    // false: it did not take the force
};

struct HapticStepOutput {
  HapticGiven given;
  DeviceSample sample;  // the last good one
  Vec3 v_H_W_mm_per_s{0};
  Vec3 w_H_W_rad_per_s{0};
  CoupledOutput coupled;
  ForceMapOutput force;  // that the device was given; zero when it did not take it
  std::uint32_t faults = kHapticOk;
};

/// Reads the device, takes its pose to the lattice of devices/lattice.h (a nanometre), estimates the handle's velocity,
/// steps the simulation, maps the force and writes it. Any fault gives zero force in the same tick and lets it come
/// back by the ramp.
class HapticStep {
 public:
  /// The simulation must outlive it. Throws Error naming the first value out of range.
  HapticStep(CoupledSimulation& simulation, const DeviceProfile& profile, const ForceMapParams& force_map = {});

  /// Tick-safe.
  HapticStepOutput Step(Device& device, const HapticStepInput& in, TickObserver* observer = nullptr);

  /// The device has been without force: it comes back by the ramp. Tick-safe.
  void RampIn() { force_map_.Reset(); }

  const ForceMap& force_map() const { return force_map_; }
  struct Counts {
    std::uint64_t read_failed = 0;
    std::uint64_t write_failed = 0;
    std::uint64_t bad_samples = 0;
    std::uint64_t bad_forces = 0;
  };
  const Counts& counts() const { return counts_; }
  /// Whether a good sample has been read.
  bool has_sample() const { return has_sample_; }

 private:
  CoupledSimulation* simulation_;
  ForceMap force_map_;
  AdaptiveVelocity velocity_;
  AdaptiveVelocity turning_;
  Vec3 turned_W_rad_{0};  // sum of the small rotations of the handle, for turning_
  DeviceSample sample_;
  bool has_sample_ = false;
  bool write_failed_ = false;
  Counts counts_;
};

}  // namespace kerf
