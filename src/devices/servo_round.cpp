#include "devices/servo_round.h"

#include <fmt/format.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {

ServoRound::ServoRound(const DeviceProfile& profile, const DriverTraits& traits, const ServoParams& params)
    : traits_(traits), params_(params), gate_(profile, params.gate) {
  if (!(params.silent_s >= 0.002 && params.silent_s <= 10)) {
    throw Error(fmt::format("silent_s = {} is not within 0.002 to 10", params.silent_s));
  }
  if (!(params.agree_s >= params.silent_s && params.agree_s <= 3600)) {
    throw Error(fmt::format("agree_s = {} is not within silent_s to 3600", params.agree_s));
  }
}

void ServoRound::Open(double now_s) {
  gate_.Restart();  // nothing is left of what it let through but the heat
  const std::uint32_t engagements = sample_.engagements;
  sample_ = {};
  sample_.engagements = engagements;
  sample_.state = ServoState::kHoming;
  heard_at_s_ = now_s;
  heard_ = false;
  buttons_before_ = ~0u;
  f_sent_D_N_ = Vec3{0};
}

ServoState ServoRound::Step(DeviceDriver& driver, double now_s, double dt_s, const ServoCommand& newest,
                            bool agrees) noexcept {
  ++counts_.rounds;
  GateState device;
  device.now_s = now_s;
  device.dt_s = dt_s;
  device.homed = sample_.sample.homed && sample_.state != ServoState::kHoming;
  device.fresh = heard_;
  device.engaged = sample_.state == ServoState::kEngaged || sample_.state == ServoState::kSilent;
  const GateOutput gated =
      gate_.Step({newest.sequence, newest.made_at_s, newest.command.f_D_N, newest.command.tau_D_Nmm}, device);
  f_sent_D_N_ = gated.f_N;
  counts_.largest_N = std::fmax(counts_.largest_N, glm::length(gated.f_N));

  DriverCommand command = newest.command;
  command.f_D_N = gated.f_N;
  command.tau_D_Nmm = gated.tau_Nmm;
  command.engaged = sample_.state == ServoState::kEngaged;
  // A field of force around it lets through as much as its middle does.
  const double asked_N = glm::length(newest.command.f_D_N);
  const double share = asked_N > 0 && std::isfinite(asked_N) ? std::fmin(glm::length(gated.f_N) / asked_N, 1) : 0;
  command.stiffness_N_per_mm *= share;
  command.damping_Ns_per_mm *= share;
  const RoundEnd end = driver.Exchange(command, told_);
  heard_ = end == RoundEnd::kSample;
  Take(end, told_, now_s, agrees);
  return sample_.state;
}

void ServoRound::Take(RoundEnd end, const DriverSample& told, double now_s, bool agrees) {
  if (end == RoundEnd::kGone) {
    sample_.state = ServoState::kClosed;
    return;
  }
  if (end != RoundEnd::kSample) {
    ++(end == RoundEnd::kBadAnswer ? counts_.bad_answers : counts_.no_answers);
    if (sample_.state == ServoState::kEngaged && now_s - heard_at_s_ > params_.silent_s) {
      sample_.state = ServoState::kSilent;
      ++counts_.silences;
    }
    return;
  }
  ++counts_.samples;
  const double silence_s = now_s - heard_at_s_;
  heard_at_s_ = now_s;
  sample_.sample = told;
  sample_.at_s = now_s;
  const bool pressed = (told.buttons & ~buttons_before_) != 0;
  buttons_before_ = told.buttons;
  if (!told.homed) {
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
      sample_.state = silence_s > params_.agree_s ? ServoState::kWaiting : ServoState::kEngaged;
      break;
    case ServoState::kEngaged:
      break;
  }
}

const char* Describe(ServoState state) {
  switch (state) {
    case ServoState::kClosed:
      return "not there";
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
