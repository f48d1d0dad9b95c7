// Rounds with a device: sends commands, receives samples, and decides whether the device may output force. Pure: the
// caller passes in the time.
#pragma once

#include <cstdint>
#include <optional>

#include "device/devices/driver.h"
#include "device/devices/safety_gate.h"

namespace kerf {

enum class ServoState : std::uint8_t {
  kClosed,   // not open: not yet found, or removed
  kHoming,   // open, but the handle has not been homed, so its position is unknown
  kWaiting,  // ready; force starts when the user agrees
  kEngaged,  // the handle holds the tool
  kSilent,   // was engaged, but has not answered for a while, or reported a jump: no force
};

/// Request of the simulation to the device, frame D.
struct ServoCommand {
  std::uint64_t sequence = 0;  // increases with each new command
  double made_at_s = 0;
  DriverCommand command;
};

/// State of the device for other threads.
struct ServoSample {
  DriverSample sample;
  double at_s = -1e300;  // time of arrival
  ServoState state = ServoState::kClosed;
  /// Number of times that the handle was coupled to the tool. Each time, it may be at a different place.
  std::uint32_t engagements = 0;
};

struct ServoParams {
  SafetyGateOptions gate;
  double silent_s = 0.05;
  double agree_s = 0.5;
  double max_speed_mm_per_s = 5000;
  double max_speed_rad_per_s = 30;
  /// If true, pressing any button counts as the user's agreement.
  bool button_agrees = true;
};

template <typename V>
void Describe(ServoParams& p, V&& visit) {
  visit("silent_s", p.silent_s, Range{0.002, 10}, "maximum time without an answer before the force stops");
  visit("agree_s", p.agree_s, Range{p.silent_s, 3600}, "after a longer silence, the user must agree again");
  visit("max_speed_mm_per_s", p.max_speed_mm_per_s, Range{100, 1e9},
        "faster motion is a fault, after which the handle is coupled to the tool again");
  visit("max_speed_rad_per_s", p.max_speed_rad_per_s, Range{1, 1e9}, "the same for rotation, if it is sensed");
}

struct ServoCounts {
  std::uint64_t rounds = 0;
  std::uint64_t samples = 0;
  std::uint64_t no_answers = 0;
  std::uint64_t bad_answers = 0;
  std::uint64_t silences = 0;  // number of times that kSilent began
  std::uint64_t jumps = 0;     // number of those that were caused by jumps
  double largest_N = 0;        // largest force that the safety gate passed
};

class ServoRound {
 public:
  /// Throws kerf::Error if a parameter is out of range.
  ServoRound(const DeviceProfile& profile, const DriverTraits& traits, const ServoParams& params);

  /// Starts from the beginning, including homing and agreement. Call it after the driver has been started.
  void Open(double now_s);
  /// Gives up the device until it is opened again.
  void Close() noexcept { sample_.state = ServoState::kClosed; }
  /// Stops the force from the next round on; the user must agree again.
  void Release() noexcept;
  /// Runs one round, dt_s after the last. `agrees`: the user has agreed since the last round. Returns kClosed if the
  /// device is gone. Tick-safe except that the driver waits for its transport.
  ServoState Step(DeviceDriver& driver, double now_s, double dt_s, const ServoCommand& newest, bool agrees) noexcept;

  const ServoSample& sample() const { return sample_; }
  ServoState state() const { return sample_.state; }
  const SafetyGate& gate() const { return gate_; }
  /// Force sent in the last round, frame D.
  const Vec3& sent_force_N() const { return f_sent_D_N_; }
  const ServoCounts& counts() const { return counts_; }

 private:
  void BeginSilence();
  void Take(RoundEnd end, const DriverSample& reported, double now_s, bool agrees);
  bool IsJump(const DriverSample& reported, double since_s) const;

  DriverTraits traits_;
  ServoParams params_;
  SafetyGate gate_;
  ServoSample sample_;
  DriverSample reported_;
  double heard_at_s_ = 0;
  bool heard_ = false;     // an answer was received in the last round
  bool just_now_ = false;  // kSilent began in this round
  std::uint32_t buttons_before_ = ~0u;
  Vec3 f_sent_D_N_{0};
  ServoCounts counts_;
};

/// Returns a phrase for the user.
const char* Describe(ServoState state);

}  // namespace kerf
