#include "device/devices/intention.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Minimum-jerk curve from 0 to 1, with zero velocity and acceleration at both ends.
double CalcMinimumJerk(double u) {
  return u * u * u * (10 + u * (-15 + 6 * u));
}
double CalcMinimumJerkSlope(double u) {
  return 30 * u * u * (1 - u) * (1 - u);
}

}  // namespace

IntentionScript::IntentionScript(const Pose& X_WH_start, std::vector<IntentionStep> steps)
    : X_WH_start_(X_WH_start), steps_(std::move(steps)) {
  if (!IsValid(X_WH_start_) || !IsInWorld(X_WH_start_.p_AB)) {
    throw Error("the start pose of the hand is not valid or outside the world");
  }
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const IntentionStep& s = steps_[i];
    if (!IsValid(s.X_WH) || !IsInWorld(s.X_WH.p_AB)) {
      throw Error(fmt::format("the end pose of step {} of the hand is not valid or outside the world", i + 1));
    }
    CheckParameters(s, fmt::format("step {} of the hand", i + 1));
    duration_s_ += s.seconds;
  }
}

Intention IntentionScript::Calc(double t_s) const {
  Intention wanted;
  wanted.X_WH = X_WH_start_;
  double t = std::isfinite(t_s) ? std::clamp(t_s, 0.0, duration_s_) : 0;
  const Pose* from = &X_WH_start_;
  Vec3 push_before{0};
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const IntentionStep& s = steps_[i];
    if (t > s.seconds && i + 1 < steps_.size()) {
      t -= s.seconds;
      from = &s.X_WH;
      push_before = s.push_W_N;
      continue;
    }
    t = std::min(t, s.seconds);
    const double u = t / s.seconds;
    const double progress = CalcMinimumJerk(u);
    const Vec3 stroke = s.X_WH.p_AB - from->p_AB;
    wanted.X_WH.p_AB = from->p_AB + progress * stroke;
    wanted.v_W_mm_per_s = CalcMinimumJerkSlope(u) / s.seconds * stroke;
    wanted.X_WH.R_AB = glm::normalize(glm::slerp(from->R_AB, s.X_WH.R_AB, progress));

    const double edge = 4 * std::min(u, 1 - u);  // rises and falls over a quarter of the step
    const double envelope = CalcMinimumJerk(std::min(edge, 1.0));
    const double envelope_slope = edge < 1 ? (u < 0.5 ? 4 : -4) / s.seconds * CalcMinimumJerkSlope(edge) : 0;
    const double omega = 2 * std::numbers::pi * s.saw_Hz;
    wanted.X_WH.p_AB += envelope * std::sin(omega * t) * s.saw_W_mm;
    wanted.v_W_mm_per_s += (envelope * omega * std::cos(omega * t) + envelope_slope * std::sin(omega * t)) * s.saw_W_mm;

    const double on = s.push_on_s > 0 ? CalcMinimumJerk(std::min(t / s.push_on_s, 1.0)) : 1;
    wanted.push_W_N = push_before + on * (s.push_W_N - push_before);
    wanted.yield_s = s.yield_s;
    break;
  }
  return wanted;
}

}  // namespace kerf
