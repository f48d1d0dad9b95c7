#include "device/devices/servo_round.h"

#include <fmt/format.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

// Allowances for noise and for rounds in quick succession.
constexpr double kAllowedJump_mm = 3;
constexpr double kAllowedJump_rad = 0.1;

}  // namespace

ServoRound::ServoRound(const DeviceProfile& profile, const DriverTraits& traits, const ServoParams& params)
    : traits_(traits), params_(params), gate_(profile, params.gate) {
  CheckParameters(params);
}

void ServoRound::Open(double now_s) {
  gate_.Restart();  // keeps the motors' heat and the counts
  const std::uint32_t engagements = sample_.engagements;
  sample_ = {};
  sample_.engagements = engagements;
  sample_.state = ServoState::kHoming;
  heard_at_s_ = now_s;
  heard_ = false;
  buttons_before_ = ~0u;
  f_sent_D_N_ = Vec3{0};
}

void ServoRound::Release() noexcept {
  gate_.Restart();
  f_sent_D_N_ = Vec3{0};
  if (sample_.state == ServoState::kEngaged || sample_.state == ServoState::kSilent) {
    sample_.state = ServoState::kWaiting;
  }
}

ServoState ServoRound::Step(DeviceDriver& driver, double now_s, double dt_s, const ServoCommand& newest,
                            bool agrees) noexcept {
  ++counts_.rounds;
  just_now_ = false;
  // The thread that runs the rounds stalled, so the handle was not observed in the meantime.
  if (dt_s > params_.silent_s) BeginSilence();
  GateState device;
  device.now_s = now_s;
  device.dt_s = dt_s;
  device.homed = sample_.sample.homed && sample_.state != ServoState::kHoming;
  device.fresh = heard_;
  device.engaged = sample_.state == ServoState::kEngaged;
  const GateOutput gated =
      gate_.Step({newest.sequence, newest.made_at_s, newest.command.f_D_N, newest.command.tau_D_Nmm}, device);
  f_sent_D_N_ = gated.f_N;
  counts_.largest_N = std::fmax(counts_.largest_N, glm::length(gated.f_N));

  DriverCommand command = newest.command;
  command.f_D_N = gated.f_N;
  command.tau_D_Nmm = gated.tau_Nmm;
  command.engaged = sample_.state == ServoState::kEngaged;
  // Scale the field's stiffness and damping by the same fraction as the force.
  const double requested_N = glm::length(newest.command.f_D_N);
  const double fraction =
      requested_N > 0 && std::isfinite(requested_N) ? std::fmin(glm::length(gated.f_N) / requested_N, 1) : 0;
  command.stiffness_N_per_mm *= fraction;
  command.damping_Ns_per_mm *= fraction;
  const RoundEnd end = driver.Exchange(command, reported_);
  heard_ = end == RoundEnd::kSample;
  Take(end, reported_, now_s, agrees);
  return sample_.state;
}

void ServoRound::BeginSilence() {
  if (sample_.state != ServoState::kEngaged) return;
  sample_.state = ServoState::kSilent;
  just_now_ = true;
  ++counts_.silences;
}

bool ServoRound::IsJump(const DriverSample& reported, double since_s) const {
  if (traits_.motion != DriverMotion::kPosition) return false;
  const Pose& before = sample_.sample.X_DH;
  const double time_s = std::fmax(since_s, 0);
  const double distance_mm = glm::length(reported.X_DH.p_AB - before.p_AB);
  if (!(distance_mm <= kAllowedJump_mm + params_.max_speed_mm_per_s * time_s)) return true;
  if (!traits_.senses_orientation) return false;
  const Quat turn = reported.X_DH.R_AB * glm::conjugate(before.R_AB);
  const double turn_rad = 2 * std::atan2(std::hypot(turn.x, turn.y, turn.z), std::abs(turn.w));
  return !(turn_rad <= kAllowedJump_rad + params_.max_speed_rad_per_s * time_s);
}

void ServoRound::Take(RoundEnd end, const DriverSample& reported, double now_s, bool agrees) {
  if (end == RoundEnd::kGone) {
    sample_.state = ServoState::kClosed;
    return;
  }
  if (end != RoundEnd::kSample) {
    ++(end == RoundEnd::kBadAnswer ? counts_.bad_answers : counts_.no_answers);
    if (now_s - heard_at_s_ > params_.silent_s) BeginSilence();
    return;
  }
  ++counts_.samples;
  const double silence_s = now_s - heard_at_s_;
  if (sample_.state == ServoState::kEngaged && IsJump(reported, silence_s)) {
    ++counts_.jumps;
    BeginSilence();
  }
  if (sample_.state != ServoState::kSilent || !just_now_) heard_at_s_ = now_s;
  sample_.sample = reported;
  sample_.at_s = now_s;
  const bool pressed = (reported.buttons & ~buttons_before_) != 0;
  buttons_before_ = reported.buttons;
  if (!reported.homed) {
    sample_.state = ServoState::kHoming;
    return;
  }
  switch (sample_.state) {
    case ServoState::kClosed:
    case ServoState::kHoming:
      sample_.state = ServoState::kWaiting;
      break;
    case ServoState::kWaiting:
      if (!agrees && !(pressed && params_.button_agrees)) break;
      sample_.state = ServoState::kEngaged;
      ++sample_.engagements;
      break;
    case ServoState::kSilent:
      if (just_now_) break;  // keep the state for one round, so that other threads see it
      sample_.state = silence_s > params_.agree_s ? ServoState::kWaiting : ServoState::kEngaged;
      if (sample_.state == ServoState::kEngaged) ++sample_.engagements;
      break;
    case ServoState::kEngaged:
      break;
  }
}

const char* Describe(ServoState state) {
  switch (state) {
    case ServoState::kClosed:
      return "not connected";
    case ServoState::kHoming:
      return "not homed";
    case ServoState::kWaiting:
      return "ready, without force until you agree";
    case ServoState::kEngaged:
      return "in the hand";
    case ServoState::kSilent:
      return "silent";
  }
  return "";
}

}  // namespace kerf
