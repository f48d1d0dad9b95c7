// Last stage between the simulation and a device's motors. The input may be arbitrary; the output is limited in
// magnitude, rate of change and motor heat, and is zero unless all conditions hold. The gate runs in the device's
// thread, once per round. It does not depend on the device or the simulation, and takes the time as an input.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "kerf/device.h"
#include "kerf/geometry.h"

namespace kerf {

/// Force that the simulation requests.
struct GateCommand {
  std::uint64_t number = 0;  // increases with each command; a repeated number is the same command
  double made_s = 0;         // time of the command, on the same clock as GateState::now_s
  Vec3 f_N{0};
  Vec3 tau_Nmm{0};
};

/// State of the device.
struct GateState {
  double now_s = 0;
  double dt_s = 0.001;   // time since the last step
  bool homed = false;    // the device reports its true position
  bool fresh = false;    // the device has answered in this round
  bool engaged = false;  // the user has enabled forces
};

/// Reason why the output differs from the request. kNone, kRampIn and kHeat do not close the gate.
enum class GateReason : std::uint8_t {
  kNone,
  kRampIn,
  kHeat,     // limited to the continuous rating of the motors
  kWaiting,  // waiting for valid commands, after one of the reasons below
  kClock,    // the thread stalled, or the clock is wrong
  kNotHomed,
  kNotEngaged,
  kLostSample,
  kNotFinite,
  kOverLimit,
  kTooSteep,
  kOutOfSequence,
  kStale,
};
inline constexpr std::size_t kGateReasons = 13;

/// Returns a sentence for the user, without a full stop.
std::string_view Describe(GateReason reason);

struct SafetyGateOptions {
  /// Maximum request, as a multiple of the device's peak; at least 1. The force mapping never requests more than the
  /// peak.
  double over_limit = 1.05;
  double max_slew_per_s = 200;      // slew rate as a multiple of the peak: a full reversal takes 10 ms. Assumed
  double stale_s = 0.05;            // maximum age of a command, at least 0.001
  double lost_s = 0.05;             // maximum time without an answer from the device, at least 0.001
  double ramp_out_s = 0.02;         // at least 0.001
  double good_s = 0.1;              // duration of valid commands before the output ramps in, at least 0.001
  double ramp_in_s = 0.5;           // at least 0.001
  double heat_s = 10;               // averaging time of the squared force, at least 0.001
  double unknown_continuous = 0.5;  // fraction of the peak used for an unknown rating, above 0 to 1. Assumed
};

struct GateOutput {
  Vec3 f_N{0};
  Vec3 tau_Nmm{0};
  GateReason reason = GateReason::kWaiting;
  bool open = false;  // false: the output is zero or is being ramped down
};

/// Initially closed. While the gate is open, the output follows the command, limited to the peak, to the motors' heat
/// and to the slew rate. On any fault, the output falls smoothly (C1) from its current value to zero, whatever happens
/// meanwhile; after a period of valid commands, it ramps in smoothly. All functions are tick-safe.
class SafetyGate {
 public:
  /// Uses the peak and continuous force and torque of the profile; a peak of 0 blocks that output. Throws kerf::Error
  /// if an option is out of range.
  explicit SafetyGate(const DeviceProfile& profile, const SafetyGateOptions& options = {});

  GateOutput Step(const GateCommand& command, const GateState& state) noexcept;

  /// Closes the gate immediately with zero output. For a device that was replaced or absent, and thus outputs nothing.
  /// Keeps the motors' heat and the counts.
  void Restart() noexcept;

  /// Number of occurrences of each reason: for a reason to refuse a command, the number of refused commands; for any
  /// other, the number of times that it began.
  const std::array<std::uint64_t, kGateReasons>& counts() const { return counts_; }
  std::uint64_t count(GateReason reason) const { return counts_[static_cast<std::size_t>(reason)]; }
  /// Reason for the last closing since Restart(); kNone if it has not closed.
  GateReason closed_by() const { return closed_by_; }
  /// Upper bound of the rate of change of the output force, N/s, for any input.
  double max_change_N_per_s() const;
  double max_change_Nmm_per_s() const;
  double continuous_force_N() const { return force_.continuous; }
  double continuous_torque_Nmm() const { return torque_.continuous; }
  /// Mean square of the output force, relative to the square of the continuous force. 1 is the limit. With a continuous
  /// force of at least an eighth of the peak, the value can reach 1.02 if the slew rate is too low to stay within the
  /// limit.
  double heat() const { return force_.heat / (force_.continuous * force_.continuous); }

 private:
  /// State of one output: the force or the torque.
  struct Channel {
    double peak = 0;
    double continuous = 0;
    Vec3 requested{0};  // last finite request
    Vec3 out{0};
    Vec3 ramp_from{0};
    double heat = 0;  // mean square
  };
  enum class Phase : std::uint8_t { kClosed, kOpen };

  GateReason JudgeState(const GateState& state) noexcept;
  GateReason JudgeCommand(const GateCommand& command, double now_s) noexcept;
  void Count(GateReason reason) noexcept { ++counts_[static_cast<std::size_t>(reason)]; }
  void CountBeginning(GateReason reason, bool holds) noexcept;
  bool MoveOpen(Channel& channel, double fraction, double dt_s) const noexcept;
  void MoveClosed(Channel& channel) const noexcept;
  void Warm(Channel& channel, double dt_s) const noexcept;

  SafetyGateOptions options_;
  Channel force_;
  Channel torque_;
  Phase phase_ = Phase::kClosed;
  double phase_s_ = 0;  // time since the phase began
  double good_s_ = 0;   // time without a fault
  GateReason closed_by_ = GateReason::kNone;
  std::array<std::uint64_t, kGateReasons> counts_{};
  std::array<bool, kGateReasons> holding_{};

  bool has_command_ = false;
  bool command_is_good_ = false;
  std::uint64_t number_ = 0;
  double made_s_ = 0;
  bool has_time_ = false;
  double last_now_s_ = 0;
  double since_sample_s_ = 0;
  bool had_sample_ = false;
};

}  // namespace kerf
