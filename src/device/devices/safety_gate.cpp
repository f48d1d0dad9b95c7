#include "device/devices/safety_gate.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/core/vectors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kLongestStep_s = 0.1;
// Fraction of the permitted heat above which the limit decreases from the peak.
constexpr double kWarm = 0.8;

/// Rises from 0 to 1 with zero slope at both ends and a maximum slope of 1.5.
double CalcSmooth(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}
constexpr double kMaxSlope = 1.5;

/// Returns `v`, shortened to a length of at most `max_length`, even after rounding.
Vec3 Shorten(const Vec3& v, double max_length) {
  constexpr double kBelow = 1 - 1e-15;
  const double length = glm::length(v);
  if (length <= kBelow * max_length) return v;
  if (!(max_length > 0)) return Vec3{0};
  return v * (kBelow * max_length / length);
}

bool IsStep(double dt_s) {
  return dt_s > 0 && dt_s <= kLongestStep_s;
}

/// Compares the components first, so that the squared length of a long vector cannot overflow.
bool IsLonger(const Vec3& v, double max_length) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) > max_length || glm::length(v) > max_length;
}

}  // namespace

std::string_view Describe(GateReason reason) {
  switch (reason) {
    case GateReason::kNone:
      return "forces are on";
    case GateReason::kRampIn:
      return "forces are ramping up";
    case GateReason::kHeat:
      return "forces are limited to what the motors can sustain";
    case GateReason::kWaiting:
      return "no force: waiting for steady commands";
    case GateReason::kClock:
      return "no force: the device thread stalled";
    case GateReason::kNotHomed:
      return "no force: the device is not homed yet";
    case GateReason::kNotEngaged:
      return "no force: not switched on";
    case GateReason::kLostSample:
      return "no force: the device does not answer";
    case GateReason::kNotFinite:
      return "no force: the simulation sent a force that is not a finite number";
    case GateReason::kOverLimit:
      return "no force: the simulation requested more than the device can output";
    case GateReason::kTooSteep:
      return "no force: the simulation requested too sudden a change";
    case GateReason::kOutOfSequence:
      return "no force: commands arrived in the wrong order";
    case GateReason::kStale:
      return "no force: the simulation has stopped sending commands";
  }
  return "";
}

SafetyGate::SafetyGate(const DeviceProfile& profile, const SafetyGateOptions& options) : options_(options) {
  const auto is_time = [](double s) { return std::isfinite(s) && s >= kTick_s; };
  if (!std::isfinite(options.over_limit) || options.over_limit < 1 || !std::isfinite(options.max_slew_per_s) ||
      options.max_slew_per_s <= 0 || !is_time(options.stale_s) || !is_time(options.lost_s) ||
      !is_time(options.ramp_out_s) || !is_time(options.good_s) || !is_time(options.ramp_in_s) ||
      !is_time(options.heat_s) || !(options.unknown_continuous > 0) || options.unknown_continuous > 1) {
    throw Error(
        "the safety gate's options must have a limit of 1 or more, a slew above 0, times of 1 ms or more and a "
        "continuous fraction above 0 and at most 1");
  }
  const auto set = [&](Channel& channel, double peak, double continuous) {
    if (!std::isfinite(peak) || peak < 0 || !std::isfinite(continuous) || continuous < 0) {
      throw Error("a device's peak and continuous force and torque must be 0 or more");
    }
    channel.peak = peak;
    channel.continuous = continuous > 0 ? std::min(continuous, peak) : options.unknown_continuous * peak;
  };
  set(force_, profile.peak_force_N, profile.continuous_force_N);
  set(torque_, profile.peak_torque_Nmm, profile.continuous_torque_Nmm);
}

double SafetyGate::max_change_N_per_s() const {
  return force_.peak * std::max(options_.max_slew_per_s, kMaxSlope / options_.ramp_out_s);
}

double SafetyGate::max_change_Nmm_per_s() const {
  return torque_.peak * std::max(options_.max_slew_per_s, kMaxSlope / options_.ramp_out_s);
}

void SafetyGate::CountBeginning(GateReason reason, bool holds) noexcept {
  bool& before = holding_[static_cast<std::size_t>(reason)];
  if (holds && !before) Count(reason);
  before = holds;
}

/// Returns the first fault of the device's state, or kNone.
GateReason SafetyGate::JudgeState(const GateState& state) noexcept {
  const bool is_step = IsStep(state.dt_s) && std::isfinite(state.now_s) && (!has_time_ || state.now_s >= last_now_s_);
  if (std::isfinite(state.now_s)) {
    has_time_ = true;
    last_now_s_ = state.now_s;
  }
  since_sample_s_ = state.fresh ? 0 : since_sample_s_ + (is_step ? state.dt_s : kLongestStep_s);
  had_sample_ = had_sample_ || state.fresh;
  const bool is_lost = !had_sample_ || since_sample_s_ > options_.lost_s;
  CountBeginning(GateReason::kClock, !is_step);
  CountBeginning(GateReason::kNotHomed, !state.homed);
  CountBeginning(GateReason::kNotEngaged, !state.engaged);
  CountBeginning(GateReason::kLostSample, is_lost);
  if (!is_step) return GateReason::kClock;
  if (is_lost) return GateReason::kLostSample;
  if (!state.homed) return GateReason::kNotHomed;
  if (!state.engaged) return GateReason::kNotEngaged;
  return GateReason::kNone;
}

/// Returns the first fault of the command, or kNone.
GateReason SafetyGate::JudgeCommand(const GateCommand& command, double now_s) noexcept {
  GateReason reason = GateReason::kNone;
  if (!has_command_ || command.number != number_) {
    const bool is_later = !has_command_ || command.number > number_;
    if (!IsFinite(command.f_N) || !IsFinite(command.tau_Nmm) || !std::isfinite(command.made_s)) {
      reason = GateReason::kNotFinite;
    } else if (IsLonger(command.f_N, options_.over_limit * force_.peak) ||
               (torque_.peak > 0 && IsLonger(command.tau_Nmm, options_.over_limit * torque_.peak))) {
      reason = GateReason::kOverLimit;
    } else {
      // Whatever the time between the commands, permit at least the change of one tick, and at most the change over the
      // maximum age of a command.
      const double since_s = std::clamp(command.made_s - made_s_, kTick_s, std::max(options_.stale_s, kTick_s));
      const auto is_steep = [&](const Channel& channel, const Vec3& request) {
        const double max_change = channel.peak * options_.max_slew_per_s * since_s;
        return has_command_ && channel.peak > 0 && IsLonger(request - channel.requested, max_change * (1 + 1e-9));
      };
      const bool steep = is_steep(force_, command.f_N) || is_steep(torque_, command.tau_Nmm);
      // The next command is compared with this one, whether or not this one is valid.
      force_.requested = command.f_N;
      torque_.requested = torque_.peak > 0 ? command.tau_Nmm : Vec3{0};
      if (!is_later || (has_command_ && command.made_s < made_s_) || command.made_s > now_s + options_.stale_s) {
        reason = GateReason::kOutOfSequence;
      } else if (steep) {
        reason = GateReason::kTooSteep;
      }
      made_s_ = command.made_s;
    }
    has_command_ = true;
    number_ = command.number;
    command_is_good_ = reason == GateReason::kNone;
    if (reason != GateReason::kNone) Count(reason);
  }
  const bool is_stale = !has_command_ || !(now_s - made_s_ <= options_.stale_s);
  CountBeginning(GateReason::kStale, is_stale);
  if (reason == GateReason::kNone && is_stale) reason = GateReason::kStale;
  // Repeating an invalid command does not make it valid.
  if (reason == GateReason::kNone && !command_is_good_) reason = GateReason::kWaiting;
  return reason;
}

/// Returns true if the heat limited the output.
bool SafetyGate::MoveOpen(Channel& channel, double fraction, double dt_s) const noexcept {
  const double allowed = channel.continuous * channel.continuous;
  double max_length = channel.peak;
  if (allowed > 0) {
    const double warm = std::clamp((channel.heat / allowed - kWarm) / (1 - kWarm), 0.0, 1.0);
    max_length = channel.peak + warm * (channel.continuous - channel.peak);
    // Also limit the output so that a single step, which may be long, does not exceed the permitted heat.
    const double fraction_of_step = -std::expm1(-dt_s / options_.heat_s);
    const double square = (allowed - (1 - fraction_of_step) * channel.heat) / fraction_of_step;
    max_length = std::min(max_length, std::max(channel.continuous, std::sqrt(std::max(square, 0.0))));
  }
  const bool exceeds = glm::length(channel.requested) > max_length;
  const Vec3 wanted = Shorten(fraction * Shorten(channel.requested, max_length), channel.peak);
  const Vec3 change = wanted - channel.out;
  channel.out = Shorten(channel.out + Shorten(change, channel.peak * options_.max_slew_per_s * dt_s), channel.peak);
  return exceeds && max_length < channel.peak;
}

void SafetyGate::MoveClosed(Channel& channel) const noexcept {
  const double left = 1 - CalcSmooth(phase_s_ / options_.ramp_out_s);
  channel.out = left > 0 ? channel.ramp_from * left : Vec3{0};
}

void SafetyGate::Warm(Channel& channel, double dt_s) const noexcept {
  const double fraction = -std::expm1(-dt_s / options_.heat_s);
  channel.heat += fraction * (glm::dot(channel.out, channel.out) - channel.heat);
}

void SafetyGate::Restart() noexcept {
  for (Channel* channel : {&force_, &torque_}) {
    channel->requested = channel->out = channel->ramp_from = Vec3{0};
  }
  phase_ = Phase::kClosed;
  phase_s_ = 0;
  good_s_ = 0;
  closed_by_ = GateReason::kNone;
  holding_ = {};
  has_command_ = command_is_good_ = false;
  has_time_ = had_sample_ = false;
  since_sample_s_ = 0;
}

GateOutput SafetyGate::Step(const GateCommand& command, const GateState& state) noexcept {
  const GateReason of_state = JudgeState(state);
  const GateReason of_command = JudgeCommand(command, state.now_s);
  const GateReason wrong = of_state != GateReason::kNone ? of_state : of_command;
  const double dt_s = IsStep(state.dt_s) ? state.dt_s : kTick_s;
  const bool good = wrong == GateReason::kNone;

  if (phase_ == Phase::kOpen && !good) {
    phase_ = Phase::kClosed;
    phase_s_ = 0;
    closed_by_ = wrong;
    force_.ramp_from = force_.out;
    torque_.ramp_from = torque_.out;
    good_s_ = 0;
    CountBeginning(GateReason::kRampIn, false);
    CountBeginning(GateReason::kHeat, false);
  }
  good_s_ = good ? good_s_ + dt_s : 0;
  phase_s_ += dt_s;
  if (phase_ == Phase::kClosed && good_s_ >= options_.good_s && phase_s_ >= options_.ramp_out_s) {
    phase_ = Phase::kOpen;
    phase_s_ = dt_s;
  }

  GateOutput output;
  if (phase_ == Phase::kOpen) {
    const double fraction = CalcSmooth(phase_s_ / options_.ramp_in_s);
    const bool hot_force = MoveOpen(force_, fraction, dt_s);
    const bool hot_torque = MoveOpen(torque_, fraction, dt_s);
    CountBeginning(GateReason::kRampIn, fraction < 1);
    CountBeginning(GateReason::kHeat, hot_force || hot_torque);
    output.open = true;
    output.reason = GateReason::kNone;
    if (hot_force || hot_torque) output.reason = GateReason::kHeat;
    if (fraction < 1) output.reason = GateReason::kRampIn;
  } else {
    MoveClosed(force_);
    MoveClosed(torque_);
    output.reason = good ? GateReason::kWaiting : wrong;
  }
  CountBeginning(GateReason::kWaiting, output.reason == GateReason::kWaiting);
  Warm(force_, dt_s);
  Warm(torque_, dt_s);
  output.f_N = force_.out;
  output.tau_Nmm = torque_.out;
  return output;
}

}  // namespace kerf
