// Simulated haptic device with a hand on it, for tests and for trying a scene without hardware.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "device/devices/hand.h"
#include "device/devices/intention.h"
#include "kerf/device.h"

namespace kerf {

struct SimulatedDeviceOptions {
  Vec3 p_TC_mm{0};  // point of the tool frame at the handle: CouplingParams::p_TC_mm
  int substeps = 20;
  int delay_ticks = 0;   // from Write() to the force
  bool quantise = true;  // rounds positions to the profile's resolution
};

template <typename V>
void Describe(SimulatedDeviceOptions& p, V&& visit) {
  visit("substeps", p.substeps, Range{20, 10000}, "integration steps per tick");
  DescribeDelay(p.delay_ticks, visit);
}

/// Faults of a device. Each persists until it is reset.
struct DeviceFaults {
  bool frozen = false;        // Read returns the same sample again
  bool not_a_number = false;  // Read returns NaN
  bool read_fails = false;
  bool write_fails = false;  // Write fails, and the motors are off
  Vec3 jump_mm{0};           // added to the position that Read returns
};

/// Models the handle and the hand as one point mass with the device's own damping and Coulomb friction and the hand's
/// spring and damper. The motion is integrated by the implicit midpoint rule, which changes the energy only through
/// damping and friction. The commanded force is constant during a tick. Time advances only in Elapse().
class SimulatedDevice : public Device {
 public:
  /// Throws kerf::Error if an option is out of range, the start pose is invalid, or the profile has no mass.
  SimulatedDevice(const DeviceProfile& profile, const HandModel& hand, const Pose& X_WH_start,
                  const SimulatedDeviceOptions& options = {});

  /// Sets the hand's motion from now on. The script starts at its time 0.
  void SetScript(IntentionScript script);
  /// Sets the intention for one tick or more; replaces the script. Tick-safe.
  void SetIntention(const Intention& intention);
  /// Moves the hand and the handle to a pose, where they rest. Tick-safe.
  void Place(const Pose& X_WH);
  void SetFaults(const DeviceFaults& faults) { faults_ = faults; }
  /// Changes the hand immediately. Tick-safe, except that copying the name may allocate.
  void SetHand(const HandModel& hand) { hand_ = hand; }

  const DeviceProfile& profile() const override { return profile_; }
  /// Advances the handle and the hand by dt_s (at most 0.1 s). Does nothing if dt_s is 0, negative or NaN. Tick-safe,
  /// as are the functions below.
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  /// Shortens vectors that exceed the profile's peak, as a device would. Returns false for values that are not finite.
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;

  // ---- quantities that a real device cannot report
  const HandModel& hand() const { return hand_; }
  Vec3 p_WC_mm() const { return p_WC_mm_; }  // true position of the handle
  Vec3 v_WC_mm_per_s() const { return v_WC_mm_per_s_; }
  Vec3 force_N() const { return f_W_N_; }  // current force of the motors
  double time_s() const { return time_s_; }
  double port_mJ() const { return port_mJ_; }  // work done so far by the handle on the motors
  double lost_mJ() const { return lost_mJ_; }  // energy lost so far to the device's own damping and friction
  std::uint64_t saturated_writes() const { return saturated_writes_; }

 private:
  void Integrate(double h_s) noexcept;
  Quat CalcOrientation() const noexcept;

  DeviceProfile profile_;
  HandModel hand_;
  SimulatedDeviceOptions options_;
  std::optional<IntentionScript> script_;
  double script_start_s_ = 0;
  Intention intention_;
  DeviceFaults faults_;

  double time_s_ = 0;
  Vec3 p_WC_mm_{0};
  Vec3 v_WC_mm_per_s_{0};
  Vec3 yielded_mm_{0};    // displacement of the intended position by yielding
  Vec3 turned_W_rad_{0};  // rotation of the handle relative to the hand
  Vec3 f_W_N_{0};
  Vec3 tau_W_Nmm_{0};
  struct Wrench {
    Vec3 f_W_N{0};
    Vec3 tau_W_Nmm{0};
  };
  std::array<Wrench, kMaxDelay_ticks + 1> queue_{};
  int queue_at_ = 0;
  double port_mJ_ = 0;
  double lost_mJ_ = 0;
  std::uint64_t saturated_writes_ = 0;
  DeviceSample last_sample_;
};

}  // namespace kerf
