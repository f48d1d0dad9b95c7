// The last thing between the simulation and a device's motors, whatever the device: what comes in may be anything, what
// goes out is bounded in size, in its change and in the heat that it makes, and is zero unless all is well. It runs in
// the device's own thread, round by round, knows no device and no simulation, and has no clock but what it is told.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "device/devices/device.h"
#include "kerf/geometry.h"

namespace kerf {

/// What the simulation asks for.
struct GateCommand {
  std::uint64_t number = 0;  // higher with each command; the same again is no news
  double made_s = 0;         // by the clock of GateState::now_s
  Vec3 f_N{0};
  Vec3 tau_Nmm{0};
};

/// How the device is.
struct GateState {
  double now_s = 0;
  double dt_s = 0.001;   // since the last step
  bool homed = false;    // tells its true position
  bool fresh = false;    // has answered in this round
  bool engaged = false;  // the user wants forces
};

/// Why what goes out is not what was asked for. The first three hold nobody up.
enum class GateReason : std::uint8_t {
  kNone,
  kRampIn,
  kHeat,     // shortened to what the motors bear for long
  kWaiting,  // for good commands, after one of those below
  kClock,    // the thread stood still, or the clock is wrong
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

/// A sentence to the user, without a full stop.
std::string_view Describe(GateReason reason);

struct SafetyGateOptions {
  double over_limit = 1.05;         // of the device's peak: more is no command that a force map makes
  double max_slew_per_s = 200;      // of the device's peak: all of it one way and back in 10 ms. Assumed
  double stale_s = 0.05;            // age of a command
  double lost_s = 0.05;             // without an answer from the device
  double ramp_out_s = 0.02;         //
  double good_s = 0.1;              // of good commands before the ramp in
  double ramp_in_s = 0.5;           //
  double heat_s = 10;               // over which the square of the force is averaged
  double unknown_continuous = 0.5;  // of the peak, where the profile does not know. Assumed
};

struct GateOutput {
  Vec3 f_N{0};
  Vec3 tau_Nmm{0};
  GateReason reason = GateReason::kWaiting;
  bool open = false;  // false: zero, or on the way there
};

/// Closed at first. Open: the command goes out, shortened to the peak and to what the motors' heat allows, and follows
/// no faster than the slew. Anything wrong: from what is going out then, a smooth ramp (C1) to zero, which nothing
/// turns back; then good commands for a while, and a smooth ramp in. All is tick-safe.
class SafetyGate {
 public:
  /// Peak and continuous force and torque of the profile; a peak of 0: that goes out never. Throws Error when an option
  /// is out of range.
  explicit SafetyGate(const DeviceProfile& profile, const SafetyGateOptions& options = {});

  GateOutput Step(const GateCommand& command, const GateState& state) noexcept;

  /// Closed and at zero at once: the device is another one or was away, and nothing goes out any more. Its motors' heat
  /// and the counts stay.
  void Restart() noexcept;

  /// How often each came: commands that were refused, and beginnings of all else.
  const std::array<std::uint64_t, kGateReasons>& counts() const { return counts_; }
  std::uint64_t count(GateReason reason) const { return counts_[static_cast<std::size_t>(reason)]; }
  /// What closed it last while it was open; kNone: nothing yet.
  GateReason closed_by() const { return closed_by_; }
  /// Of the change of the force that goes out, N/s, whatever comes in.
  double max_change_N_per_s() const;
  double max_change_Nmm_per_s() const;
  double continuous_force_N() const { return force_.continuous; }
  double continuous_torque_Nmm() const { return torque_.continuous; }
  /// Mean square of the force that went out, of the square of the continuous one: 1 is all that it may be; up to 1.02
  /// where the slew is too slow to keep to it, with a continuous force of an eighth of the peak or more.
  double heat() const { return force_.heat / (force_.continuous * force_.continuous); }

 private:
  /// Force or torque.
  struct Channel {
    double peak = 0;
    double continuous = 0;
    Vec3 asked{0};  // last, finite
    Vec3 out{0};
    Vec3 ramp_from{0};
    double heat = 0;  // mean square
  };
  enum class Phase : std::uint8_t { kClosed, kOpen };

  GateReason JudgeState(const GateState& state) noexcept;
  GateReason JudgeCommand(const GateCommand& command, double now_s) noexcept;
  void Note(GateReason reason) noexcept { ++counts_[static_cast<std::size_t>(reason)]; }
  void NoteBeginning(GateReason reason, bool holds) noexcept;
  bool MoveOpen(Channel& channel, double share, double dt_s) const noexcept;
  void MoveClosed(Channel& channel) const noexcept;
  void Warm(Channel& channel, double dt_s) const noexcept;

  SafetyGateOptions options_;
  Channel force_;
  Channel torque_;
  Phase phase_ = Phase::kClosed;
  double phase_s_ = 0;  // time in it
  double good_s_ = 0;   // without a fault
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
