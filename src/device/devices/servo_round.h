// Round after round with a device: what it is told, what it tells, and whether it may make force now. Pure: time is
// what the caller says.
#pragma once

#include <cstdint>
#include <optional>

#include "device/devices/driver.h"
#include "device/devices/safety_gate.h"

namespace kerf {

enum class ServoState : std::uint8_t {
  kClosed,   // not open: not there yet, or gone
  kHoming,   // open, but the handle has not been moved as it must be for its place to be known
  kWaiting,  // ready; force comes when the user agrees
  kEngaged,  // the hand has the tool
  kSilent,   // engaged, but there has been no answer for a while, or it told a leap: no force
};

/// What the simulation wants of the device, frame D.
struct ServoCommand {
  std::uint64_t sequence = 0;  // above the last one's when it is new
  double made_at_s = 0;
  DriverCommand command;
};

/// What others see of the device.
struct ServoSample {
  DriverSample sample;
  double at_s = -1e300;  // when it came
  ServoState state = ServoState::kClosed;
  std::uint32_t engagements = 0;  // times that the handle has taken the tool: another one, and it may be elsewhere
};

struct ServoParams {
  SafetyGateOptions gate;
  double silent_s = 0.05;       // without an answer: no force
  double agree_s = 0.5;         // silent for longer: the user must agree again
  double leap_mm_per_s = 5000;  // faster, and it was no hand: the handle takes the tool anew; 100 to 1e9
  double leap_rad_per_s = 30;   // likewise, of turning, where that is sensed; 1 to 1e9
  /// A button that was not pressed before, pressed: the user agrees.
  bool button_agrees = true;
};

struct ServoCounts {
  std::uint64_t rounds = 0;
  std::uint64_t samples = 0;
  std::uint64_t no_answers = 0;
  std::uint64_t bad_answers = 0;
  std::uint64_t silences = 0;  // times that kSilent began
  std::uint64_t leaps = 0;     // of those
  double largest_N = 0;        // that the safety gate let through
};

class ServoRound {
 public:
  /// Throws Error for a parameter out of range.
  ServoRound(const DeviceProfile& profile, const DriverTraits& traits, const ServoParams& params);

  /// The driver has been started: from the beginning, homing and agreeing included.
  void Open(double now_s);
  /// The device is given up until it is opened anew.
  void Close() noexcept { sample_.state = ServoState::kClosed; }
  /// The hand has let go: no force in the next round, and the user must agree again.
  void LetGo() noexcept;
  /// One round, dt_s after the last. `agrees`: the user said so since the last round. kClosed: the device is gone. Not
  /// tick-safe only as far as the driver waits for its transport.
  ServoState Step(DeviceDriver& driver, double now_s, double dt_s, const ServoCommand& newest, bool agrees) noexcept;

  const ServoSample& sample() const { return sample_; }
  ServoState state() const { return sample_.state; }
  const SafetyGate& gate() const { return gate_; }
  /// Of the last round, frame D.
  const Vec3& sent_force_N() const { return f_sent_D_N_; }
  const ServoCounts& counts() const { return counts_; }

 private:
  void BeginSilence();
  void Take(RoundEnd end, const DriverSample& told, double now_s, bool agrees);
  bool IsLeap(const DriverSample& told, double since_s) const;

  DriverTraits traits_;
  ServoParams params_;
  SafetyGate gate_;
  ServoSample sample_;
  DriverSample told_;
  double heard_at_s_ = 0;
  bool heard_ = false;     // in the last round
  bool just_now_ = false;  // kSilent has begun in this round
  std::uint32_t buttons_before_ = ~0u;
  Vec3 f_sent_D_N_{0};
  ServoCounts counts_;
};

/// For people.
const char* Describe(ServoState state);

}  // namespace kerf
