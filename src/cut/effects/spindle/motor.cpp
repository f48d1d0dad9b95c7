#include "cut/effects/spindle/motor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

constexpr double kNever_s = std::numeric_limits<double>::infinity();

/// Adds the terms for n = 0, 1, ... until they no longer change the sum, and returns it.
template <typename Next>
double SumSeries(double term, Next next) {
  double sum = 0;
  for (int n = 0; n < 40 && sum + term != sum; ++n) {
    sum += term;
    term = next(n, term);
  }
  return sum;
}

/// (1 - exp(-x)) / x.
double Phi1(double x) {
  return x > 0 ? -std::expm1(-x) / x : 1;
}
/// (x - 1 + exp(-x)) / x^2.
double Phi2(double x) {
  if (x > 1) return (x + std::expm1(-x)) / (x * x);
  return SumSeries(0.5, [x](int n, double term) { return -term * x / (n + 3); });
}
/// Integral of (1 - exp(-s))^2 from 0 to x, over x^3.
double Phi3(double x) {
  if (x > 1) return (x + 2 * std::expm1(-x) - 0.5 * std::expm1(-2 * x)) / (x * x * x);
  // (-1)^n (2^n - 2) x^(n-2) / (n! (n+1)), n from 2.
  double power = 0.5;  // x^(n-2) / n! with alternating sign
  double two = 4;
  double sum = 0;
  for (int n = 2; n < 40; ++n) {
    const double term = power * (two - 2) / (n + 1);
    if (sum + term == sum) break;
    sum += term;
    power *= -x / (n + 1);
    two *= 2;
  }
  return sum;
}

/// Range of speeds w > 0 in which the motor's torque is torque_Nmm - slope w.
struct SpeedRange {
  double torque_Nmm = 0;
  double slope_Nmms = 0;
  double lower = 0;
  double upper = kNever_s;
};

/// Returns the range next to the speed w >= 0: the one above it if `rising`, otherwise the one below. The direction of
/// rotation is taken as positive.
SpeedRange FindSpeedRange(const Motor& motor, double set, double w, bool rising) {
  const auto is_above = [&](double edge) { return rising ? w >= edge : w > edge; };
  const double slope = motor.stall_torque_Nmm / motor.no_load_rad_per_s;
  const double drives_to = std::max(0.0, set);
  const double line_to = std::max(0.0, set + motor.no_load_rad_per_s);
  if (set > 0 && !is_above(drives_to)) return {slope * set, slope, 0, drives_to};
  if (!motor.brakes) return {0, 0, drives_to, kNever_s};
  if (!is_above(line_to)) return {slope * set, slope, drives_to, line_to};
  return {-motor.stall_torque_Nmm, 0, line_to, kNever_s};
}

}  // namespace

double Motor::CalcTorque(double set, double w) const {
  const double torque_Nmm =
      std::clamp(stall_torque_Nmm * (set - w) / no_load_rad_per_s, -stall_torque_Nmm, stall_torque_Nmm);
  return !brakes && torque_Nmm * w < 0 ? 0 : torque_Nmm;
}

MotorRun RunMotor(const Motor& motor, double set, double load_Nmm, double hold_Nmm, double w, double time_s) {
  const double J = motor.CalcInertia();
  MotorRun run;
  double left_s = time_s;
  // Each corner is passed at most once on the way to the steady speed; the bound guards against rounding.
  for (int n = 0; n < 16 && left_s > 0; ++n) {
    double direction = w > 0 ? 1 : -1;
    if (w == 0) {
      const double torque_Nmm = motor.CalcTorque(set, 0);
      if (!(std::abs(torque_Nmm) > motor.friction_Nmm + std::max(load_Nmm, hold_Nmm))) break;
      direction = torque_Nmm > 0 ? 1 : -1;
    }
    const double against_Nmm = motor.friction_Nmm + load_Nmm;
    const double from = direction * w;
    const auto gain = [&](const SpeedRange& range) {
      return (range.torque_Nmm - against_Nmm - (range.slope_Nmms + motor.viscous_Nmms) * from) / J;
    };
    SpeedRange range = FindSpeedRange(motor, direction * set, from, true);
    double c = gain(range);  // w'
    if (c < 0) {
      range = FindSpeedRange(motor, direction * set, from, false);
      c = gain(range);
    }
    const double B = (range.slope_Nmms + motor.viscous_Nmms) / J;
    // w(t) = from + c t Phi1(B t): time at which it reaches the end of the range.
    const double end = c > 0 ? range.upper : range.lower;
    double t = kNever_s;
    if (c != 0 && end < kNever_s) {
      const double fraction = B * (end - from) / c;  // fraction of the change to the steady speed
      if (fraction < 1) t = B > 0 ? -std::log1p(-fraction) / B : (end - from) / c;
    }
    const bool reaches = t <= left_s;
    t = std::min(t, left_s);
    const double x = B * t;
    const double to = reaches ? end : from + c * t * Phi1(x);
    const double angle = from * t + c * t * t * Phi2(x);
    const double square = from * from * t + 2 * from * c * t * t * Phi2(x) + c * c * t * t * t * Phi3(x);
    run.angle_rad += direction * angle;
    run.motor_mJ += range.torque_Nmm * angle - range.slope_Nmms * square;
    run.load_mJ += load_Nmm * angle;
    run.friction_mJ += motor.friction_Nmm * angle;
    run.viscous_mJ += motor.viscous_Nmms * square;
    w = direction * to;
    left_s -= t;
  }
  run.w_rad_per_s = w;
  return run;
}

}  // namespace kerf
