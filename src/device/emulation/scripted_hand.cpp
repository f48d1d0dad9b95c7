#include "device/emulation/scripted_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kHomeLeg_s = 0.75;  // duration of each phase: out, hold, in, back
constexpr double kGrowth_s = 1;
constexpr double kLongestStep_s = 0.01;

/// Rises from 0 to 1 with minimum jerk.
double Ease(double fraction) {
  const double s = std::clamp(fraction, 0.0, 1.0);
  return s * s * s * (10 - 15 * s + 6 * s * s);
}

ScriptedHandOptions Check(const ScriptedHandOptions& options) {
  CheckParameters(options, "hand");
  return options;
}

SimulatedDeviceOptions MakeExact() {
  SimulatedDeviceOptions options;
  options.quantise = false;  // the encoders of the device model quantise
  return options;
}

}  // namespace

ScriptedHand::ScriptedHand(const DeviceProfile& profile, const HandModel& hand, const ScriptedHandOptions& options)
    : options_(Check(options)), device_(profile, hand, Pose{}, MakeExact()) {}

void ScriptedHand::Home() {
  begun_ = true;
  if (!homing()) home_s_ = 0;
}

Vec3 ScriptedHand::CalcWanted() const {
  Vec3 p_D_mm{0};
  const double turned = 2 * std::numbers::pi * path_s_ / options_.period_s;
  const double radius_mm = options_.radius_mm * Ease(path_s_ / kGrowth_s);
  if (options_.path == ScriptedPath::kCircle) p_D_mm = radius_mm * Vec3(std::cos(turned), std::sin(turned), 0);
  if (options_.path == ScriptedPath::kLine) p_D_mm = radius_mm * Vec3(std::sin(turned), 0, 0);
  if (!homing()) return p_D_mm;
  const double leg = home_s_ / kHomeLeg_s;
  const double z_mm = options_.home_out_mm * Ease(leg) + (options_.home_in_mm - options_.home_out_mm) * Ease(leg - 2) -
                      options_.home_in_mm * Ease(leg - 3);
  // Moves onto the axis while moving out and leaves it while moving back, since there is little room at the far ends.
  const double off = 1 - Ease(2 * leg) + Ease(2 * leg - 7);
  return off * p_D_mm + Vec3(0, 0, z_mm);
}

void ScriptedHand::Move(double dt_s, const Vec3& f_D_N, const Vec3& tau_D_Nmm) {
  if (!(dt_s > 0)) return;
  device_.Write(f_D_N, tau_D_Nmm);
  while (dt_s > 0) {
    const double step_s = std::min(dt_s, kLongestStep_s);
    dt_s -= step_s;
    const Vec3 before = CalcWanted();
    if (homing()) {
      home_s_ += step_s;
      if (home_s_ >= 4 * kHomeLeg_s) home_s_ = -1;
    } else if (begun_) {
      path_s_ += step_s;
    }
    Intention intention;
    intention.X_WH.p_AB = CalcWanted();
    intention.v_W_mm_per_s = (intention.X_WH.p_AB - before) / step_s;
    device_.SetIntention(intention);
    device_.Elapse(step_s);
  }
  DeviceSample sample;
  if (device_.Read(sample)) X_DH_ = sample.X_WH;
}

std::uint32_t ScriptedHand::buttons() const {
  std::uint32_t pressed = 0;
  for (const HandPress& press : options_.presses) {
    if (begun_ && !homing() && path_s_ >= press.from_s && path_s_ < press.to_s) pressed |= press.buttons;
  }
  return pressed;
}

}  // namespace kerf
