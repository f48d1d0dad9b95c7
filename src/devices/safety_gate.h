// The last thing between the simulation and a device: what may not go out becomes a smooth way to no force.
//
// COORDINATOR'S NOTE TO WHOEVER WRITES THE .cpp (remove it then): devices/servo_round.{h,cpp} on main uses exactly these names;
// keep them, fill in docstrings, params and reasons as your part says. A command of zero force is never a fault: however suddenly
// it comes, the force goes to zero by the ramp and no latch is set (the watchdog and every fault of the loop ask for zero at once).
#pragma once

#include <array>
#include <cstdint>

#include "devices/device.h"
#include "kerf/geometry.h"

namespace kerf {

struct SafetyGateParams {
  double ramp_out_s = 0.02;
  double stale_s = 0.05;
  double calm_s = 0.1;      // of good commands after a fault, before the force comes back
  double ramp_in_s = 0.5;
  double silent_s = 0.05;   // without an answer from the device: no force
  double thermal_s = 10;
  double continuous_force_N = 0;  // 0: the profile's, or where that is unknown half its peak (assumed)
  double max_slew_N_per_s = 0;    // 0: from none to the peak in 2.5 ms (the force map takes 5 ms at its fastest)
};

struct SafetyGateCommand {
  std::uint64_t sequence = 0;  // 0: there is none yet
  double made_at_s = 0;
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
};

struct SafetyGateDevice {
  double now_s = 0;
  double dt_s = 0;          // since the last step
  bool homed = false;
  bool engaged = false;     // by the user's consent
  double heard_at_s = 0;    // when the device last answered
};

enum class SafetyReason : std::uint8_t { kNone, kNotHomed, kNotEngaged, kSilent, kNotFinite, kOverLimit, kTooSteep, kStale, kOutOfSequence, kCalming };
inline constexpr std::size_t kSafetyReasons = 10;
/// A phrase for people.
const char* Describe(SafetyReason reason);

struct SafetyGateOutput {
  Vec3 f_D_N{0};
  Vec3 tau_D_Nmm{0};
  SafetyReason reason = SafetyReason::kNone;  // why there is less force than asked for
  bool thermal = false;                       // less, as the motors have been at work
};

class SafetyGate {
 public:
  /// Throws Error naming the first parameter out of range.
  SafetyGate(const DeviceProfile& profile, const SafetyGateParams& params = {});
  /// Tick-safe.
  SafetyGateOutput Step(const SafetyGateCommand& command, const SafetyGateDevice& device) noexcept;
  struct Counts {
    std::array<std::uint64_t, kSafetyReasons> steps{};  // by SafetyReason
    std::uint64_t faults = 0;                           // times that a fault of the commands began
    std::uint64_t thermal = 0;
    double largest_N = 0;                               // that went out
  };
  const Counts& counts() const { return counts_; }

 private:
  Counts counts_;
};

}  // namespace kerf
