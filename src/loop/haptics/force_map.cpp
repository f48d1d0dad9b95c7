#include "loop/haptics/force_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/core/vectors.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMaxTick_s = 0.1;
constexpr double kPeakIn_s = 0.005;   // time from zero to the peak, if no slew rate is set
constexpr double kThermalKnee = 0.7;  // thermal load above which the peak is lowered

/// Returns the length of a finite vector, without overflow or underflow of its square. Infinite only if the length
/// exceeds the largest double.
double CalcLength(const Vec3& v) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0)) return 0;
  // The reciprocal of a denormal would overflow, so each component is divided.
  const Vec3 u(v.x / largest, v.y / largest, v.z / largest);
  return largest * std::sqrt(glm::dot(u, u));
}

/// Returns 3t^2 - 2t^3, with t clamped to 0 to 1.
double SmoothStep(double t) {
  const double held = std::clamp(t, 0.0, 1.0);
  return held * held * (3 - 2 * held);
}

}  // namespace

ForceMap::ForceMap(const DeviceProfile& profile, const ForceMapParams& params) : params_(params) {
  CheckParameters(params);
  if (!(profile.peak_force_N > 0)) throw Error(fmt::format("device {} has no peak force", profile.name));
  force_.peak = profile.peak_force_N;
  force_.continuous = profile.continuous_force_N;
  force_.scale = std::min(1.0, profile.peak_force_N / params.expected_peak_N);
  force_.slew_per_s = params.slew_N_per_s > 0 ? params.slew_N_per_s : profile.peak_force_N / kPeakIn_s;
  const bool turns = profile.degrees_of_freedom == 6 && profile.peak_torque_Nmm > 0;
  torque_.peak = turns ? profile.peak_torque_Nmm : 0;
  torque_.continuous = turns ? profile.continuous_torque_Nmm : 0;
  torque_.scale = turns ? std::min(1.0, profile.peak_torque_Nmm / params.expected_peak_torque_Nmm) : 0;
  torque_.slew_per_s = params.slew_Nmm_per_s > 0 ? params.slew_Nmm_per_s : torque_.peak / kPeakIn_s;
  force_scale_ = force_.scale;
  torque_scale_ = torque_.scale;
}

double ForceMap::Channel::CalcThermalPeak(double warming, double& load) const {
  load = 0;
  if (!(continuous > 0) || !(continuous < peak)) return peak;
  load = heat / (continuous * continuous);
  // At a load of 1, at most the continuous force is output, which keeps the load constant.
  const double allowed = peak - SmoothStep((load - kThermalKnee) / (1 - kThermalKnee)) * (peak - continuous);
  // A long tick must not exceed a load of 1 either.
  const double room = std::max(0.0, continuous * continuous - heat);
  return std::min(allowed, std::sqrt(heat + room / warming));
}

bool ForceMap::Channel::Calc(const Vec3& wanted, double gain, double knee, double dt_s, double slew_dt_s,
                             double thermal_s, ForceMapOutput& out, std::uint32_t limited_bit) {
  if (!(peak > 0)) return false;
  double load = 0;
  const double warming = -std::expm1(-dt_s / thermal_s);
  const double allowed = CalcThermalPeak(warming, load);
  out.thermal_load = std::max(out.thermal_load, load);
  if (allowed < peak) out.status |= kForceMapThermalLimited;

  Vec3 target = gain * scale * wanted;
  const double length = CalcLength(target);
  const double bend = knee * allowed;
  if (length > bend) {
    out.status |= limited_bit;
    // The slope is 1 at the knee, and the asymptote is the allowed force.
    const double beyond = (length - bend) / std::max(allowed - bend, std::numeric_limits<double>::min());
    const double bent = std::isfinite(beyond) ? bend + (allowed - bend) * (beyond / (1 + beyond)) : allowed;
    target = LimitLength(target, bent);
  }
  const Vec3 step = target - last;
  const double most = slew_per_s * std::min(dt_s, slew_dt_s);
  if (CalcLength(step) > most) {
    out.status |= kForceMapSlewLimited;
    target = last + LimitLength(step, most);
  }
  // The peak may have fallen faster than the slew rate since the last tick; the peak takes precedence.
  last = LimitLength(target, allowed);
  heat += warming * (glm::dot(last, last) - heat);
  return true;
}

void ForceMap::Channel::Zero(double dt_s, double thermal_s) {
  last = Vec3{0};
  heat *= std::exp(-dt_s / thermal_s);
}

void ForceMap::Reset() {
  ramp_s_done_ = 0;
  force_.last = torque_.last = Vec3{0};
}

ForceMapOutput ForceMap::Calc(const Vec3& f_sim_W_N, const Vec3& tau_sim_W_Nmm, double dt_s, bool fault,
                              double slew_dt_s) {
  ForceMapOutput out;
  ++counts_.ticks;
  const bool time_ok = dt_s >= 0 && std::isfinite(dt_s);
  const double dt = time_ok ? std::min(dt_s, kMaxTick_s) : 0;
  if (fault) out.status |= kForceMapFault;
  if (!time_ok || !IsFinite(f_sim_W_N) || !IsFinite(tau_sim_W_Nmm)) out.status |= kForceMapNotFinite;
  if (out.status != kForceMapOk) {
    ++counts_.faults;
    ramp_s_done_ = 0;
    force_.Zero(dt, params_.thermal_s);
    torque_.Zero(dt, params_.thermal_s);
    return out;
  }
  ramp_s_done_ = std::min(ramp_s_done_ + dt, params_.ramp_in_s);
  out.ramp = params_.ramp_in_s > 0 ? SmoothStep(ramp_s_done_ / params_.ramp_in_s) : 1;
  if (out.ramp < 1) out.status |= kForceMapRampIn;
  if (dt == 0) {
    out.f_H_W_N = force_.last;
    out.tau_H_W_Nmm = torque_.last;
    return out;
  }
  if (force_.Calc(f_sim_W_N, out.ramp, params_.knee, dt, slew_dt_s, params_.thermal_s, out, kForceMapForceLimited)) {
    out.f_H_W_N = force_.last;
  }
  if (torque_.Calc(tau_sim_W_Nmm, out.ramp, params_.knee, dt, slew_dt_s, params_.thermal_s, out,
                   kForceMapTorqueLimited)) {
    out.tau_H_W_Nmm = torque_.last;
  }
  if ((out.status & (kForceMapForceLimited | kForceMapTorqueLimited)) != 0) ++counts_.limited;
  if ((out.status & kForceMapSlewLimited) != 0) ++counts_.slew_limited;
  if ((out.status & kForceMapThermalLimited) != 0) ++counts_.thermal_limited;
  return out;
}

}  // namespace kerf
