#include "device/drivers/device_servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <ctime>
#include <exception>
#include <utility>

#include "base/realtime/deadlines.h"
#include "base/realtime/loop_clock.h"
#include "base/realtime/realtime.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kClutchOut_s = 0.05;       // time in which the clutch removes the force
constexpr double kClutchIn_s = 0.3;         // time in which the clutch restores the force
constexpr std::uint64_t kCountsEvery = 64;  // rounds between updates of the counts
constexpr int kStopRounds = 5;
constexpr std::int64_t kRemindFirst_ns = 300'000'000;
constexpr std::int64_t kRemindAgain_ns = 30'000'000'000;
constexpr int kRefusals = 3;  // failed openings before one is reported, since permissions may not be set yet
constexpr std::uint64_t kRestartRounds = 20;  // unanswered rounds that show that the device, not this program, stalled
constexpr double kTurning_rad_per_s = 2;      // speed of a tool that is turned with keys

// State of ReleaseAll().
std::atomic<int> servos{0};
std::atomic<std::uint32_t> releases_requested{0};
std::atomic<std::uint32_t> releases_done{0};
std::atomic<bool> released_for_good{false};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
constinit thread_local bool is_servo_thread = false;

/// Blocks all signals in this thread, because a signal handler that waits for this thread must not run on it. A fault
/// in this thread cannot be handled: it ends the program immediately without a handler, and the device keeps its last
/// force until its own timeout. abort() in this thread does run the handler here, but ReleaseAll() does not wait for
/// its own thread.
void BlockSignals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

DeviceProfile LimitByTable(DeviceProfile profile) {
  for (const DeviceProfile& known : DeviceProfiles()) {
    if (known.name != profile.name) continue;
    profile.peak_force_N = std::min(profile.peak_force_N, known.peak_force_N);
    profile.peak_torque_Nmm = std::min(profile.peak_torque_Nmm, known.peak_torque_Nmm);
  }
  return profile;
}

double Now_s() {
  MonotonicClock clock;
  return 1e-9 * static_cast<double>(clock.Now());
}

int FindButton(const DriverTraits& traits, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    const auto found = std::find(traits.buttons.begin(), traits.buttons.end(), name);
    if (found != traits.buttons.end()) return static_cast<int>(found - traits.buttons.begin());
  }
  return -1;
}

WorkspaceParams MakeWorkspace(const DeviceServoOptions& options, const DriverTraits& traits, const Vec3& p_TC_mm) {
  const Quat R_WD = options.left_handed ? MirrorForLeftHand(options.R_WD) : options.R_WD;
  return {options.motion_scale, R_WD, p_TC_mm, traits.senses_orientation};
}

}  // namespace

constexpr const char* kNoForceYet = "there is no force until then";

std::string DescribeHoming(const DriverTraits& traits) {
  return traits.homing.empty() ? "switch its motors on, and home it if its own program asks you to" : traits.homing;
}

DeviceServo::DeviceServo(std::string name, Open open, const DeviceServoOptions& options,
                         const std::function<bool(const std::string& doing, double fraction)>& show)
    : name_(std::move(name)), open_(std::move(open)), options_(options), workspace_({}) {
  driver_ = open_();
  driver_->Start(show);
  traits_ = driver_->traits();
  profile_ = ScaleProfile(LimitedProfile(), options.motion_scale);
  workspace_ = Workspace(MakeWorkspace(options_, traits_, Vec3{0}));
  orientation_.Publish(workspace_.params().R_WD);
  clutch_bit_ = FindButton(traits_, {"clutch", "centre"});
  if (clutch_bit_ < 0 && !traits_.buttons.empty()) clutch_bit_ = 0;
  spindle_bit_ = FindButton(traits_, {"spindle", "forward"});
  if (spindle_bit_ < 0 && traits_.buttons.size() > 1) spindle_bit_ = clutch_bit_ == 1 ? 0 : 1;
  right_bit_ = FindButton(traits_, {"right", "plus"});
  left_bit_ = FindButton(traits_, {"left", "minus"});
  round_.emplace(LimitedProfile(), traits_, options.servo);
  ++servos;
  thread_ = std::thread([this] {
    Run();
    --servos;
  });
}

DeviceServo::~DeviceServo() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

/// Returns the device's profile with its peak values limited to those in the table for its name, whatever it reports.
/// The safety gate and all users of the profile use these limits.
DeviceProfile DeviceServo::LimitedProfile() const {
  return options_.own_figures ? driver_->profile() : LimitByTable(driver_->profile());
}

std::vector<std::string> DeviceServo::TakeMessages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

void DeviceServo::Say(std::string message) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(fmt::format("{}: {}", name_, std::move(message)));
}

void DeviceServo::SayState(ServoState before, ServoState now) {
  const bool again = round_->sample().engagements > 0;
  switch (now) {
    case ServoState::kHoming:
      break;  // reported by RemindOfHoming()
    case ServoState::kWaiting:
      if (HasReportedZero(traits_)) Say(traits_.homing);
      if (again && traits_.makes_force) {
        Say(traits_.buttons.empty()
                ? "is connected again; agree here to enable the force again"
                : "is connected again; press a button on it, or agree here to enable the force again");
      }
      break;
    case ServoState::kEngaged:
      if (!traits_.makes_force) {
        Say(before == ServoState::kSilent ? "moves the tool again" : "now moves the tool");
      } else if (before == ServoState::kSilent) {
        Say("answers again; the force returns slowly");
      } else if (again) {
        Say("in the hand; the force rises slowly");
      }
      break;
    case ServoState::kSilent:
      if (std::exchange(jumps_, round_->counts().jumps) != round_->counts().jumps) {
        Say(traits_.makes_force ? "reported an implausible jump: no force for a moment, and the tool stays where it was"
                                : "reported an implausible jump: the tool stays where it was");
      } else if (!traits_.makes_force) {
        Say("does not answer: the tool is stopped");
      } else {
        Say("does not answer: no force. If this persists, check its power and its cable");
      }
      break;
    case ServoState::kClosed:
      Say("is gone: no force, and the tool is stopped. Plug it in or start it again to continue");
      break;
  }
}

/// Reminds the user to home the device. The first reminder is delayed: a device that is already homed says so in its
/// first answers.
void DeviceServo::RemindOfHoming(ServoState state, std::int64_t now_ns) {
  if (state != ServoState::kHoming) {
    homing_since_ns_ = -1;
    return;
  }
  if (homing_since_ns_ < 0) homing_since_ns_ = now_ns + kRemindFirst_ns;
  if (now_ns < homing_since_ns_) return;
  homing_since_ns_ = now_ns + kRemindAgain_ns;
  std::string how = DescribeHoming(traits_);
  if (traits_.makes_force) how.append("; ").append(kNoForceYet);
  Say(std::move(how));
}

/// Reports poses that are not valid, from a device without force: a program that sends them is at fault and can be
/// corrected. For other devices such an answer is noise on the line, which the counts show.
void DeviceServo::SayBadAnswers(std::int64_t now_ns) {
  const std::uint64_t bad_answers = round_->counts().bad_answers;
  if (std::exchange(bad_answers_, bad_answers) == bad_answers || now_ns < next_bad_answer_ns_) return;
  if (traits_.makes_force || traits_.motion != DriverMotion::kPosition) return;
  next_bad_answer_ns_ = now_ns + kRemindAgain_ns;
  Say("sent a pose that is not valid: it is not used");
}

bool DeviceServo::ReleaseAll(int timeout_ms, bool for_good) noexcept {
  const std::uint32_t before = releases_done.load();
  const int all = servos.load();
  if (all == 0) return true;
  if (for_good) released_for_good.store(true);
  ++releases_requested;
  const auto others = static_cast<std::uint32_t>(is_servo_thread ? all - 1 : all);
  const timespec millisecond{.tv_sec = 0, .tv_nsec = 1'000'000};
  for (int waited = 0; releases_done.load() - before < others; ++waited) {
    if (waited >= timeout_ms) return false;
    nanosleep(&millisecond, nullptr);
  }
  return !is_servo_thread;
}

void DeviceServo::ReleaseIfRequested(std::uint32_t& seen) {
  const std::uint32_t requested = releases_requested.load();
  if (requested == seen) return;
  seen = requested;
  round_->Release();
  agrees_.store(false);
  if (driver_) SendZeroForce();
  ++releases_done;
}

/// Copies the counts for other threads. Returns false if another thread is reading them and `waits` is false: that
/// thread has no real-time priority, and this one must not wait for it while it outputs force.
bool DeviceServo::PublishCounts(bool waits) {
  std::unique_lock lock(mutex_, std::defer_lock);
  if (waits) {
    lock.lock();
  } else if (!lock.try_lock()) {
    return false;
  }
  counts_.rounds = round_->counts();
  counts_.gate = round_->gate().counts();
  counts_.closed_by = round_->gate().closed_by();
  return true;
}

/// Throws kerf::Error if the device has been replaced by a different one, to which the user has not agreed.
void DeviceServo::CheckSame() {
  const DeviceProfile profile = ScaleProfile(LimitedProfile(), options_.motion_scale);
  const DriverTraits& traits = driver_->traits();
  if (profile.name == profile_.name && profile.peak_force_N == profile_.peak_force_N &&
      profile.peak_torque_Nmm == profile_.peak_torque_Nmm && traits.makes_force == traits_.makes_force &&
      traits.senses_orientation == traits_.senses_orientation && traits.buttons == traits_.buttons) {
    return;
  }
  driver_->Stop();
  throw Error(fmt::format("has been replaced by another device ({}); restart kerf to use it", profile.name));
}

bool DeviceServo::StartAgain() {
  try {
    driver_->Start([this](const std::string&, double) { return !stop_.load(); });
    CheckSame();
    return true;
  } catch (const std::exception& e) {
    // The device is present but does not start. Report each reason once.
    if (!stop_.load() && reported_failure_ != e.what()) Say(reported_failure_ = e.what());
  }
  driver_.reset();
  return false;
}

bool DeviceServo::Reopen() {
  try {
    driver_ = open_();
    refusals_ = 0;
  } catch (const DeviceNotThere&) {
    refusals_ = 0;
    return false;  // its removal has already been reported
  } catch (const std::exception& e) {
    if (++refusals_ >= kRefusals && reported_failure_ != e.what()) Say(reported_failure_ = e.what());
    return false;
  }
  if (!driver_ || !StartAgain()) return false;
  reported_failure_.clear();
  round_->Open(Now_s());
  return true;
}

/// Returns true if the device must be opened again because it does not answer. This applies only to a device that
/// homes, which reports a lost position after a restart. Other devices must not be restarted without the user.
bool DeviceServo::MustRestart(std::int64_t now_ns) {
  const std::uint64_t samples = round_->counts().samples;
  if (std::exchange(samples_, samples) != samples) {
    heard_ns_ = now_ns;
    unanswered_ = 0;
    return false;
  }
  ++unanswered_;
  return traits_.homes && unanswered_ >= kRestartRounds &&
         1e-9 * static_cast<double>(now_ns - heard_ns_) > options_.restart_after_s;
}

void DeviceServo::SendZeroForce() noexcept {
  DriverSample sample;
  for (int i = 0; i < kStopRounds; ++i) driver_->Exchange({}, sample);
}

/// Handles an unexpected exception, such as lack of memory: sets zero force and treats the device as unplugged.
void DeviceServo::HandleFault(const char* why) noexcept {
  if (driver_) {
    if (round_->state() != ServoState::kClosed) SendZeroForce();  // otherwise, it was only being started
    driver_->Stop();
    driver_.reset();
  }
  round_->Close();
  agrees_.store(false);
  for_loop_.Publish(round_->sample());
  for_others_.Publish(round_->sample());
  try {
    PublishCounts(true);
    if (reported_failure_ != why) {
      Say(fmt::format("has failed ({}): no force, and the tool is stopped. It is being reopened", why));
      reported_failure_ = why;
    }
  } catch (const std::exception&) {
    // There is no memory for the message either.
    reported_failure_.clear();
  }
  state_.store(ServoState::kClosed);
}

void DeviceServo::Run() {
  BlockSignals();
  is_servo_thread = true;
  RealtimeGrants grants;
  if (options_.priority > 0) RequestPriority(options_.priority, grants);
  round_->Open(Now_s());
  std::uint32_t releases_seen = releases_requested.load();
  while (!stop_.load()) {
    try {
      RunRounds(releases_seen);
    } catch (const std::exception& e) {
      HandleFault(e.what());
    } catch (...) {
      HandleFault("for an unknown reason");
    }
  }
  PublishCounts(true);
  if (!driver_) return;
  SendZeroForce();
  driver_->Stop();
}

/// Runs rounds until stop_ is set. An exception leaves the device in its last state.
void DeviceServo::RunRounds(std::uint32_t& releases_seen) {
  MonotonicClock clock;
  const auto period_ns = static_cast<std::int64_t>(1e9 / traits_.rate_hz);
  const auto reopen_ns = static_cast<std::int64_t>(1e9 * options_.reopen_s);
  Deadlines deadlines(period_ns);
  const auto begin = [&] {
    deadlines.Start(clock.Now());
    unanswered_ = 0;
    return heard_ns_ = clock.Now();
  };
  std::int64_t last_ns = begin();
  ServoState before = ServoState::kHoming;
  bool counts_due = false;
  while (!stop_.load()) {
    ReleaseIfRequested(releases_seen);
    if (released_for_good.load()) {
      clock.SleepUntil(clock.Now() + period_ns);
      last_ns = clock.Now();
      continue;
    }
    if (!driver_) {
      clock.SleepUntil(clock.Now() + reopen_ns);
      if (stop_.load() || !Reopen()) continue;
      agrees_.store(false);  // discard an agreement given before the device was present
      last_ns = begin();
    }
    clock.SleepUntil(deadlines.due_ns());
    const std::int64_t now_ns = clock.Now();
    deadlines.Begin(now_ns);
    commands_.Update();
    // If the user agrees in a round without an answer, the agreement also applies to the next round.
    const bool agrees = round_->state() == ServoState::kWaiting && (agrees_.load() || !traits_.makes_force);
    const double dt_s = 1e-9 * static_cast<double>(now_ns - last_ns);
    ServoState state = round_->Step(*driver_, 1e-9 * static_cast<double>(now_ns), dt_s, commands_.front(), agrees);
    const bool must_restart = state != ServoState::kClosed && MustRestart(now_ns);
    if (must_restart) {
      round_->Close();
      state = ServoState::kClosed;
    }
    // An agreement while the device is engaged or not yet homed is not kept.
    if (state != ServoState::kWaiting) agrees_.store(false);
    // An agreement while the device does not answer is not kept either.
    if (1e-9 * static_cast<double>(now_ns) - round_->sample().at_s > options_.servo.agree_s) agrees_.store(false);
    last_ns = now_ns;
    const std::int64_t end_ns = clock.Now();
    round_times_.Add(end_ns - now_ns);
    for_loop_.Publish(round_->sample());
    for_others_.Publish(round_->sample());
    // This and the messages come before state_ is set, so that a thread that sees the new state also sees them.
    counts_due = counts_due || state != before || round_->counts().rounds % kCountsEvery == 0;
    if (counts_due) counts_due = !PublishCounts(state == ServoState::kClosed);
    if (must_restart) {
      Say("has not answered for a long time and is being restarted: no force, and the tool is stopped. Check its "
          "power");
    } else if (state != before) {
      SayState(before, state);
    }
    state_.store(state);
    RemindOfHoming(state, now_ns);
    SayBadAnswers(now_ns);
    before = state;
    if (state == ServoState::kClosed) {
      if (must_restart) driver_->Stop();
      driver_.reset();
      continue;
    }
    deadlines.End(clock.Now());
  }
}

void DeviceServo::SetTool(const Pose& X_WT, const ToolCoupling& tool) {
  X_WT_ = X_WT;
  X_WT_actual_.reset();
  tool_ = tool;
  workspace_ = Workspace(MakeWorkspace(options_, traits_, tool.p_TC_mm));
  engagements_ = 0;  // couples the handle to the tool again
  held_ = false;
  clutched_ = false;
  fraction_ = 0;
  R_WT_wanted_.reset();
  tool_orientation_.Update();
  orientation_.Update();
  has_orientation_ = !options_.reported_orientation;
}

void DeviceServo::SetToolOrientation(const Quat& R_WT) {
  tool_orientation_.Publish(R_WT);
}

void DeviceServo::SetOrientation(const Quat& R_WD) {
  orientation_.Publish(R_WD);
}

void DeviceServo::TurnTool() {
  if (tool_orientation_.Update()) R_WT_wanted_ = tool_orientation_.front();
  if (traits_.senses_orientation || !R_WT_wanted_) return;
  const Quat turn = *R_WT_wanted_ * glm::conjugate(X_WT_.R_AB);
  const double angle = 2 * std::atan2(std::hypot(turn.x, turn.y, turn.z), std::abs(turn.w));
  if (!(angle > 1e-6)) return;
  const double fraction = std::min(1.0, kTurning_rad_per_s * dt_s_ / angle);
  Pose X_WT = X_WT_;
  X_WT.R_AB = glm::normalize(glm::slerp(X_WT_.R_AB, *R_WT_wanted_, fraction));
  X_WT.p_AB = X_WT_.Point(tool_.p_TC_mm) - X_WT.R_AB * tool_.p_TC_mm;
  workspace_.Anchor(X_DH_, X_WT);
  X_WT_ = X_WT;
}

/// Moves the requested pose to that of the tool, in the time in which the clutch removes the force. Afterwards it
/// stands: a tool that is driven by its own teeth must not run away.
void DeviceServo::EndPull() {
  if (!X_WT_actual_ || fraction_ <= 0) return;
  const double part = std::min(1.0, dt_s_ / (fraction_ * kClutchOut_s));
  X_WT_.p_AB = glm::mix(X_WT_.p_AB, X_WT_actual_->p_AB, part);
  X_WT_.R_AB = glm::normalize(glm::slerp(X_WT_.R_AB, X_WT_actual_->R_AB, part));
}

void DeviceServo::Elapse(double dt_s) noexcept {
  dt_s_ = std::clamp(dt_s, 0.0, 0.1);
  const bool on = held_ && !clutched_;
  fraction_ = std::clamp(fraction_ + (on ? dt_s_ / kClutchIn_s : -dt_s_ / kClutchOut_s), 0.0, 1.0);
}

bool DeviceServo::Read(DeviceSample& sample) noexcept {
  for_loop_.Update();
  const ServoSample& newest = for_loop_.front();
  X_DH_ = newest.sample.X_DH;
  sample.X_WH = X_WT_;
  sample.buttons = newest.sample.buttons;
  if (options_.left_handed && right_bit_ >= 0 && left_bit_ >= 0) {
    sample.buttons = SwapButtons(sample.buttons, right_bit_, left_bit_);
  }
  if (!has_orientation_) has_orientation_ = orientation_.Update();
  const bool is_current = newest.state == ServoState::kEngaged && Now_s() - newest.at_s <= options_.max_sample_age_s;
  // Coupled again before this thread saw that it was not held: that motion is not one of the hand either.
  const bool is_another = held_ && newest.engagements != engagements_;
  if (!has_orientation_ || !is_current || is_another) {
    held_ = false;
    fraction_ = 0;
    return false;
  }
  // A clutch that was pressed for a moment only is released when the pull has ended.
  const bool clutched = IsClutched(newest.sample.buttons) || (held_ && clutched_ && fraction_ > 0);
  if (!held_ || (clutched_ && !clutched)) {
    orientation_.Update();
    if (!held_ && X_WT_actual_) X_WT_ = *X_WT_actual_;
    workspace_.Anchor(X_DH_, X_WT_, orientation_.front());
    engagements_ = newest.engagements;
  }
  held_ = true;
  clutched_ = clutched;
  if (!clutched) {
    X_WT_ = workspace_.CalcToolPose(X_DH_);
    TurnTool();
  } else {
    EndPull();
  }
  sample.X_WH = X_WT_;
  return true;
}

bool DeviceServo::Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept {
  ServoCommand command;
  command.sequence = ++sequence_;
  command.made_at_s = Now_s();
  if (held_) {
    DriverCommand& request = command.command;
    request.f_D_N = fraction_ * workspace_.ToDevice(f_H_W_N);
    request.tau_D_Nmm = fraction_ * workspace_.ToDevice(tau_H_W_Nmm);
    request.p_D_mm = X_DH_.p_AB;
    // The force already includes the coupling's damping; sent as field damping, it would be applied twice.
    request.stiffness_N_per_mm = fraction_ * options_.motion_scale * tool_.stiffness_N_per_mm;
  }
  commands_.Publish(command);
  return true;
}

std::array<double, 6> DeviceServo::ReadDeflection() noexcept {
  for_loop_.Update();
  const ServoSample& newest = for_loop_.front();
  const bool holds = newest.state == ServoState::kEngaged && Now_s() - newest.at_s <= options_.max_sample_age_s;
  return holds ? newest.sample.deflection : std::array<double, 6>{};
}

ServoSample DeviceServo::TakeSample() {
  const std::lock_guard lock(reading_);
  for_others_.Update();
  return for_others_.front();
}

void DeviceServo::Command(const DriverCommand& command) {
  commands_.Publish({++sequence_, Now_s(), command});
}

DeviceServo::Counts DeviceServo::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace kerf
