// A real device that is served by a separate thread, which opens, homes and monitors it and reopens it after it was
// unplugged. The haptic loop's interface to the device never blocks.
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
#include "device/devices/driver.h"
#include "device/devices/servo_round.h"
#include "device/devices/workspace.h"
#include "kerf/device.h"
#include "kerf/error.h"

namespace kerf {

struct DeviceServoOptions {
  ServoParams servo;
  double motion_scale = 1;  // WorkspaceParams
  Quat R_WD = kFacingPatient;
  /// True: R_WD is set by SetOrientation(), and the handle holds no tool before that. False: R_WD as above.
  bool reported_orientation = false;
  bool left_handed = false;  // mirrors R_WD, and swaps the buttons named right and left
  int priority = 79;  // SCHED_FIFO priority of the thread, below the loop's, if the system permits it; 0: request none
  std::string profile;       // name of the profile in the table that replaces the device's own; empty: the device's own
  bool own_figures = false;  // true: peak force and torque come from the user's file; false: they are limited to the
                             // values in the table for the device's name
  double reopen_s = 0.5;     // interval between attempts to open the device while it is absent
  double max_sample_age_s = 0.1;  // maximum age of a sample at which the handle still holds the tool
  /// Time without an answer after which a device that homes is opened again, since it may have lost power.
  double restart_after_s = 2;
};

/// Thrown by DeviceServo::Open if there is no device to open. No message to the user is needed.
class DeviceNotThere : public Error {
 public:
  using Error::Error;
};

/// Returns the instruction that the user must follow so that the device reports its position.
std::string DescribeHoming(const DriverTraits& traits);
/// Returns true if the zero of the device is the pose in which the user held the handle. traits.homing describes that
/// pose, and the device cannot check it.
inline bool HasReportedZero(const DriverTraits& traits) {
  return !traits.homes && !traits.homing.empty();
}

/// Coupling of the tool to the handle (CouplingParams), in newtons on the device.
struct ToolCoupling {
  Vec3 p_TC_mm{0};
  double stiffness_N_per_mm = 0;
};

/// Thread safety: Elapse, Read, Write, TakeToolPose and ReadDeflection are for the loop's thread; everything else is
/// for one other thread, unless stated otherwise.
///
/// While the button named "clutch" (otherwise "centre", otherwise the first) is pressed, the handle is detached from
/// the tool: the force goes to zero, and meanwhile the pull on a tool that is behind the handle. On release, the handle
/// is coupled to the tool at its new position, and the force returns slowly.
///
/// Whenever the handle is coupled to the tool again, it requests the pose that the tool then has (TakeToolPose()), so
/// that nothing pulls the tool until the handle moves.
class DeviceServo final : public Device {
 public:
  /// Opens the device. Throws kerf::Error if that fails: DeviceNotThere, or the reason.
  using Open = std::function<std::unique_ptr<DeviceDriver>()>;

  /// Opens the device in the calling thread and throws whatever `open` and the driver's Start() throw; `show` is passed
  /// to Start(). Then starts the thread. `name` is used in messages.
  DeviceServo(std::string name, Open open, const DeviceServoOptions& options,
              const std::function<bool(const std::string& doing, double fraction)>& show);
  /// Sets zero force and closes the device.
  ~DeviceServo() override;

  /// Sets zero force on all devices of this program immediately; afterwards the user must agree again. For a program
  /// that is about to be stopped, or terminated (`for_good`: no rounds follow). May be called in a signal handler.
  /// Waits at most `timeout_ms`. Returns false if that was too short. Also returns false if called from a device's own
  /// thread, which cannot wait for itself and releases its device in its next round, if there is one.
  static bool ReleaseAll(int timeout_ms, bool for_good) noexcept;

  /// The profile as felt at the tool: ScaleProfile().
  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const { return traits_; }
  const std::string& name() const { return name_; }
  const DeviceServoOptions& options() const { return options_; }
  /// Returns true while the button named "spindle" (otherwise "forward", otherwise the second) is pressed. This
  /// button switches the spindle.
  bool IsSpindlePressed(std::uint32_t buttons) const {
    return spindle_bit_ >= 0 && (buttons >> spindle_bit_ & 1u) != 0;
  }
  /// Names of that button and of the clutch button; empty: none.
  std::string spindle_button() const { return spindle_bit_ < 0 ? "" : traits_.buttons[Index(spindle_bit_)]; }
  std::string clutch_button() const { return clutch_bit_ < 0 ? "" : traits_.buttons[Index(clutch_bit_)]; }
  ServoState state() const { return state_.load(); }
  /// Returns the messages about events since the last call, one sentence each.
  std::vector<std::string> TakeMessages();
  /// Sets the tool's pose. When the force starts, the handle is coupled to the tool, wherever the handle is. Call it
  /// before the loop runs.
  void SetTool(const Pose& X_WT, const ToolCoupling& tool);
  /// Records that the user agrees to forces.
  void Agree() { agrees_.store(true); }
  /// Sets the orientation of the tool, for a device that does not sense it: the tool turns to it about the handle
  /// point, no faster than a hand would. May be called at any time.
  void SetToolOrientation(const Quat& R_WT);
  /// Sets the device's frame in the world, which is used from the next time that the handle is coupled to the tool. May
  /// be called at any time; the first call of a session must follow SetTool().
  void SetOrientation(const Quat& R_WD);

  // ---- loop thread
  void Elapse(double dt_s) noexcept override;
  /// Returns false while the handle does not hold the tool, and in at least one tick before it is coupled again;
  /// meanwhile, the tool is stopped. Afterwards it continues from where it stopped, regardless of the handle's
  /// position.
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;
  /// Without it, the tool is assumed to be where the handle requested it last.
  void TakeToolPose(const Pose& X_WT) noexcept override { X_WT_actual_ = X_WT; }
  /// Replaces the functions above for a device without force (DriverMotion::kDeflection). Returns zero while the
  /// device is absent.
  std::array<double, 6> ReadDeflection() noexcept;

  // ---- latest values, for any thread except the loop's
  /// Latest sample, frame D.
  ServoSample TakeSample();
  /// Sends a command in frame D. For a test of the device, without a loop.
  void Command(const DriverCommand& command);
  const LogHistogram& round_times() const { return round_times_; }
  struct Counts {
    ServoCounts rounds;
    std::array<std::uint64_t, kGateReasons> gate{};  // SafetyGate::counts()
    GateReason closed_by = GateReason::kNone;
  };
  /// The counts are at most 64 rounds old, plus one round for each in which another thread was reading them. They are
  /// updated before each change of state(), and are therefore complete while the device is absent.
  Counts counts() const;

 private:
  void Run();
  void RunRounds(std::uint32_t& releases_seen);
  void SendZeroForce() noexcept;
  void HandleFault(const char* why) noexcept;
  DeviceProfile LimitedProfile() const;
  bool Reopen();
  bool MustRestart(std::int64_t now_ns);
  bool StartAgain();
  void CheckSame();
  void RemindOfHoming(ServoState state, std::int64_t now_ns);
  void ReleaseIfRequested(std::uint32_t& seen);
  bool PublishCounts(bool waits);
  void Say(std::string message);
  void SayState(ServoState before, ServoState now);
  void TurnTool();
  void EndPull();
  void SayBadAnswers(std::int64_t now_ns);
  static std::size_t Index(int bit) { return static_cast<std::size_t>(bit); }
  bool IsClutched(std::uint32_t buttons) const { return clutch_bit_ >= 0 && (buttons >> clutch_bit_ & 1u) != 0; }

  std::string name_;
  Open open_;
  DeviceServoOptions options_;
  std::unique_ptr<DeviceDriver> driver_;  // used by the thread
  DriverTraits traits_;
  DeviceProfile profile_;  // LimitedProfile() as felt at the tool
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
  std::optional<ServoRound> round_;  // used by the thread, as is jumps_
  std::uint64_t jumps_ = 0;          // jumps already reported
  std::int64_t homing_since_ns_ = -1;
  std::uint64_t bad_answers_ = 0;        // bad answers so far
  std::int64_t next_bad_answer_ns_ = 0;  // earliest time of the next report
  std::string reported_failure_;         // last reported failure to open the device again
  int refusals_ = 0;                     // number of consecutive failures to open the device
  std::uint64_t samples_ = 0;            // number of samples at the last check
  std::uint64_t unanswered_ = 0;         // rounds since the last sample
  std::int64_t heard_ns_ = 0;            // time of the last sample
  LogHistogram round_times_;
  std::mutex reading_;        // protects reading for_others_
  mutable std::mutex mutex_;  // protects messages_ and counts_; the thread does not wait for it while it outputs force
  std::vector<std::string> messages_;
  Counts counts_;

  // Used by the loop's thread.
  Workspace workspace_;
  ToolCoupling tool_;
  Pose X_WT_;                        // requested by the handle
  std::optional<Pose> X_WT_actual_;  // of the tool; none: not known yet
  bool has_orientation_ = true;
  std::uint32_t engagements_ = 0;  // engagement for which the workspace is anchored
  bool clutched_ = false;
  bool held_ = false;    // the last Read() returned a pose
  double fraction_ = 0;  // fraction of the force that the clutch passes
  double dt_s_ = 0;      // duration of the tick
  std::optional<Quat> R_WT_wanted_;
  Pose X_DH_;
  std::uint64_t sequence_ = 0;

  std::thread thread_;
};

}  // namespace kerf
