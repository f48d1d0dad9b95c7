// A haptic device with a hand on it, made of nothing but numbers: for tests, and for trying a scene without hardware.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "device/devices/device.h"
#include "device/devices/hand.h"
#include "device/devices/intention.h"

namespace kerf {

struct SimulatedDeviceOptions {
  Vec3 p_TC_mm{0};       // the point of the tool frame that the handle is at: CouplingParams::p_TC_mm
  int substeps = 20;     // of the integration in a tick, 20 to 10000
  int delay_ticks = 0;   // from Write to the force being there, 0 to 16
  bool quantise = true;  // to the profile's resolution
};

/// What can go wrong with a device. Each holds until it is taken back.
struct DeviceFaults {
  bool frozen = false;        // Read gives the same sample again
  bool not_a_number = false;  // Read gives NaN
  bool read_fails = false;
  bool write_fails = false;  // and the motors are off
  Vec3 jump_mm{0};           // added to the position that Read gives
};

/// A point mass (the handle's and the hand's) with the device's own damping and Coulomb friction and the hand's spring
/// and damper, integrated by the implicit midpoint rule, which neither adds nor loses energy but through damping and
/// friction; the commanded force is held over a tick. It has no clock: time is what Elapse() says.
class SimulatedDevice : public Device {
 public:
  /// Throws Error when an option is out of range, or the profile has no mass.
  SimulatedDevice(const DeviceProfile& profile, const HandModel& hand, const Pose& X_WH_start,
                  const SimulatedDeviceOptions& options = {});

  /// What the hand does, from now on. The script starts at its own time 0.
  void SetScript(IntentionScript script);
  /// The same from tick to tick. Tick-safe.
  void SetIntention(const Intention& intention);
  void SetFaults(const DeviceFaults& faults) { faults_ = faults; }
  /// The grip changes from one moment to the next. Tick-safe but for the name's memory.
  void SetHand(const HandModel& hand) { hand_ = hand; }

  const DeviceProfile& profile() const override { return profile_; }
  /// Moves handle and hand on by dt_s (at most 0.1 s; nothing for 0, negative or NaN). Tick-safe, like the rest.
  void Elapse(double dt_s) noexcept override;
  bool Read(DeviceSample& sample) noexcept override;
  /// Longer vectors than the profile's peak are shortened, as a device would. False for NaN.
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;

  // ---- what no device can tell
  const HandModel& hand() const { return hand_; }
  Vec3 p_WC_mm() const { return p_WC_mm_; }  // of the handle, true
  Vec3 v_WC_mm_per_s() const { return v_WC_mm_per_s_; }
  Vec3 force_N() const { return f_W_N_; }  // that the motors make now
  double time_s() const { return time_s_; }
  double port_mJ() const { return port_mJ_; }  // done so far by the handle on the motors
  double lost_mJ() const { return lost_mJ_; }  // so far, to the device's own damping and friction
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
  Vec3 given_way_mm_{0};  // how far the wanted place has yielded
  Vec3 turned_W_rad_{0};  // of the handle against the hand
  Vec3 f_W_N_{0};
  Vec3 tau_W_Nmm_{0};
  struct Wrench {
    Vec3 f_W_N{0};
    Vec3 tau_W_Nmm{0};
  };
  static constexpr int kMaxDelay = 16;
  std::array<Wrench, kMaxDelay + 1> queue_{};
  int queue_at_ = 0;
  double port_mJ_ = 0;
  double lost_mJ_ = 0;
  std::uint64_t saturated_writes_ = 0;
  DeviceSample last_sample_;
};

}  // namespace kerf
