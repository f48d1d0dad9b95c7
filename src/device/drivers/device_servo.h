// A device that is really there, served by a thread of its own: opened, homed, watched, opened again when it was
// unplugged; and the haptic loop's side of it, which never waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/core/log_histogram.h"
#include "base/core/triple_buffer.h"
#include "device/devices/device.h"
#include "device/devices/driver.h"
#include "device/devices/servo_round.h"
#include "device/devices/workspace.h"
#include "kerf/error.h"

namespace kerf {

struct DeviceServoOptions {
  ServoParams servo;
  double motion_scale = 1;  // WorkspaceParams
  Quat R_WD = kFacingPatient;
  bool told_orientation = false;  // R_WD comes by SetOrientation(), and the handle has no tool before; else as above
  bool left_handed = false;       // mirrors that, and exchanges the buttons named right and left
  int priority = 79;              // of the thread, SCHED_FIFO where it is allowed; 0: not asked for. Below the loop's.
  std::string profile;            // its name in the table of profiles, in place of the device's own; empty: that
  bool own_figures = false;       // its peaks are its user's, of a file; else none is above the table's for its name
  double reopen_s = 0.5;          // so often it is looked for while it is not there
  double old_s = 0.1;             // nobody holds a tool by what the handle did so long ago
  double given_up_s = 2;          // without an answer: one that homes is opened anew, as its power may have been away
};

/// Of DeviceServo::Open: there is nothing to be opened, and nothing more to be said.
class DeviceNotThere : public Error {
 public:
  using Error::Error;
};

/// What the user is to do before the device tells where its handle is.
std::string DescribeHoming(const DriverTraits& traits);
/// Its zero is where the user held it: traits.homing says how, and nobody else knows whether it was so.
inline bool HasToldZero(const DriverTraits& traits) {
  return !traits.homes && !traits.homing.empty();
}

/// What the device holds of the tool (CouplingParams), in the device's newtons.
struct ServedTool {
  Vec3 p_TC_mm{0};
  double stiffness_N_per_mm = 0;
};

/// Of the loop's thread: Elapse, Read and Write. Of one other thread: all else.
///
/// The button named "clutch" (else "centre", else the first) lifts the handle off the tool while it is held: the tool
/// stands, the force goes, and comes back slowly where the handle is then.
class DeviceServo final : public Device {
 public:
  /// Opens the device, or throws Error: DeviceNotThere, or why not.
  using Open = std::function<std::unique_ptr<DeviceDriver>()>;

  /// Opens it in the calling thread, and throws what `open` and the driver's Start() throw; `show` as there. Then the
  /// thread runs. `name`: for messages.
  DeviceServo(std::string name, Open open, const DeviceServoOptions& options,
              const std::function<bool(const std::string& doing, double share)>& show);
  /// No force, closed.
  ~DeviceServo() override;

  /// No force on any device of this program, at once; then the user must agree again. For a program that is about to be
  /// stopped, or ended (`for_good`: there are no rounds after it). May be called in a signal's handler, and waits for
  /// it, at most so long. False: it was too long; or this is the thread of one of them, which can't wait for itself and
  /// lets go in its next round, if there is one.
  static bool LetGoOfAll(int timeout_ms, bool for_good) noexcept;

  /// As it is at the tool: ScaleProfile().
  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const { return traits_; }
  const std::string& name() const { return name_; }
  const DeviceServoOptions& options() const { return options_; }
  /// The button named "spindle" (else "forward", else the second) as it is now; for whoever switches it by that.
  bool IsSpindlePressed(std::uint32_t buttons) const {
    return spindle_bit_ >= 0 && (buttons >> spindle_bit_ & 1u) != 0;
  }
  /// The names of that button and of the one that is the clutch; empty: there is none.
  std::string spindle_button() const { return spindle_bit_ < 0 ? "" : traits_.buttons[Index(spindle_bit_)]; }
  std::string clutch_button() const { return clutch_bit_ < 0 ? "" : traits_.buttons[Index(clutch_bit_)]; }
  ServoState state() const { return state_.load(); }
  /// What happened since the last call, a sentence each.
  std::vector<std::string> TakeMessages();
  /// The tool stands there; the handle will hold it from where it is when the force comes on. Before the loop runs.
  void SetTool(const Pose& X_WT, const ServedTool& tool);
  /// The user agrees to have force, or would.
  void Agree() { agrees_.store(true); }
  /// The tool is to lie so, where the device does not sense it: it turns there, about the handle's point, no faster
  /// than a hand. Any time.
  void SetToolOrientation(const Quat& R_WT);
  /// The device's frame in the world, taken over when the handle next begins to hold the tool anew. Any time; the first
  /// of a session after SetTool().
  void SetOrientation(const Quat& R_WD);

  // ---- the loop's
  void Elapse(double dt_s) noexcept override;
  /// False while the device is not in the hand: the tool stands meanwhile. After that the tool goes on from where it
  /// stood, wherever the handle is.
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;
  /// Of a device without force (DriverMotion::kDeflection), instead of the three; zero while it is not there.
  std::array<double, 6> ReadDeflection() noexcept;

  // ---- the newest, by any thread but the loop's
  /// Frame D.
  ServoSample TakeSample();
  /// Commands without a loop, for a test of the device: frame D.
  void Command(const DriverCommand& command);
  const LogHistogram& round_times() const { return round_times_; }
  struct Counts {
    ServoCounts rounds;
    std::array<std::uint64_t, kGateReasons> gate{};  // SafetyGate::counts()
    GateReason closed_by = GateReason::kNone;
  };
  /// Up to 64 rounds old, and one more for each in which somebody was just reading; at each change of state() as it was
  /// then, and so all there is while the device is gone.
  Counts counts() const;

 private:
  void Run();
  void Serve(std::uint32_t& let_go_seen);
  void MakeNoForce() noexcept;
  void TakeFault(const char* why) noexcept;
  DeviceProfile LimitedProfile() const;
  bool Reopen();
  bool IsGivenUp(std::int64_t now_ns);
  bool StartAgain();
  void CheckSame();
  void RemindOfHoming(ServoState state, std::int64_t now_ns);
  void LetGoIfAsked(std::uint32_t& seen);
  bool TellCounts(bool waits);
  void Say(std::string message);
  void SayState(ServoState before, ServoState now);
  void TurnTool();
  static std::size_t Index(int bit) { return static_cast<std::size_t>(bit); }
  bool IsClutched(std::uint32_t buttons) const { return clutch_bit_ >= 0 && (buttons >> clutch_bit_ & 1u) != 0; }

  std::string name_;
  Open open_;
  DeviceServoOptions options_;
  std::unique_ptr<DeviceDriver> driver_;  // the thread's
  DriverTraits traits_;
  DeviceProfile profile_;  // LimitedProfile(), as it is at the tool
  int clutch_bit_ = -1;
  int spindle_bit_ = -1;
  int right_bit_ = -1;
  int left_bit_ = -1;

  TripleBuffer<ServoCommand> commands_;
  TripleBuffer<ServoSample> for_loop_;
  TripleBuffer<ServoSample> for_others_;
  TripleBuffer<Quat> orientation_;
  TripleBuffer<Quat> tool_orientation_;
  std::atomic<ServoState> state_{ServoState::kHoming};
  std::atomic<bool> agrees_{false};
  std::atomic<bool> stop_{false};
  std::optional<ServoRound> round_;  // the thread's, and the next
  std::uint64_t leaps_ = 0;          // told of
  std::int64_t homing_since_ns_ = -1;
  std::string told_failure_;      // of opening it again
  int refusals_ = 0;              // in a row, likewise
  std::uint64_t samples_ = 0;     // that had come
  std::uint64_t unanswered_ = 0;  // rounds, since the last did
  std::int64_t heard_ns_ = 0;     // when it did
  LogHistogram round_times_;
  std::mutex reading_;        // for_others_
  mutable std::mutex mutex_;  // of the two below; in mid-force the thread does not wait for it
  std::vector<std::string> messages_;
  Counts counts_;

  // The loop's.
  Workspace workspace_;
  ServedTool tool_;
  Pose X_WT_;
  bool has_orientation_ = true;
  std::uint32_t engagements_ = 0;  // the one that the workspace is anchored for
  bool clutched_ = false;
  bool held_ = false;  // the last Read() gave a pose
  double share_ = 0;   // of the force that the clutch lets through
  double dt_s_ = 0;    // of the tick
  std::optional<Quat> R_WT_wanted_;
  Pose X_DH_;
  std::uint64_t sequence_ = 0;

  std::thread thread_;
};

}  // namespace kerf
