#include "cut/tool/drive.h"

#include <algorithm>
#include <cmath>

#include "cut/tool/kinds.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kPi = std::numbers::pi;

double CalcRate(double rpm) {
  return std::abs(rpm) / 60;
}

bool IsMean(double rate_hz, double tick_s) {
  return rate_hz * 2 * tick_s > 1;
}

/// Integrates by Gauss's rule with five points in each of several equal parts.
template <typename Function>
double Integrate(double from, double to, Function&& f) {
  constexpr int kParts = 6;
  constexpr double kNodes[] = {0, 0.5384693101056831, 0.9061798459386640};
  constexpr double kWeights[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double half = 0.5 * (to - from) / kParts;
  double sum = 0;
  for (int part = 0; part < kParts; ++part) {
    const double middle = from + (2 * part + 1) * half;
    sum += kWeights[0] * f(middle);
    for (int i = 1; i < 3; ++i) sum += kWeights[i] * (f(middle - half * kNodes[i]) + f(middle + half * kNodes[i]));
  }
  return sum * half;
}

/// Returns the integral over a part of the motion of a function of the phase since the last turn. `integrate(from, to)`
/// is the integral between two such phases, 0 to pi; `half_period` that over all of them.
template <typename Integrate>
double SumParts(double phase_rad, double advance_rad, double half_period, Integrate&& integrate) {
  const double from = phase_rad + 0.5 * kPi;
  const double to = from + advance_rad;
  const double first = std::floor(from / kPi);
  const double last = std::floor(to / kPi);
  if (first == last) return integrate(from - first * kPi, to - first * kPi);
  return integrate(from - first * kPi, kPi) + (last - first - 1) * half_period + integrate(0, to - last * kPi);
}

}  // namespace

double CalcLeastPassRate(const Tool& tool, double rpm) {
  const Drive drive(tool);
  if (!drive.strokes()) return CountPassesPerTurn(tool) * std::abs(rpm) / 60;
  return 2 * kPi * CalcRate(rpm) / drive.longest_since_passed_rad();
}

Drive::Drive(const Tool& tool) : amplitude_mm_(0.5 * CalcStroke(tool)), pitch_mm_(CalcTooth(tool).pitch_mm) {
  if (!strokes()) return;
  first_pitch_rad_ = std::acos(std::max(-1.0, 1 - pitch_mm_ / amplitude_mm_));
  per_half_period_ = IntegrateSincePassed(0, kPi);
  way_per_half_period_ = IntegrateAlongWay(0, kPi);
}

double Drive::CalcDisplacement(double phase_rad) const {
  return amplitude_mm_ * std::sin(phase_rad);
}

SlideRange Drive::CalcRange(double phase_rad, double advance_rad) const {
  const double end_rad = phase_rad + advance_rad;
  const double a = CalcDisplacement(phase_rad);
  const double b = CalcDisplacement(end_rad);
  const auto passes = [&](double turn_rad) {
    return turn_rad + 2 * kPi * std::ceil((phase_rad - turn_rad) / (2 * kPi)) <= end_rad;
  };
  return {passes(-0.5 * kPi) ? -amplitude_mm_ : std::min(a, b), passes(0.5 * kPi) ? amplitude_mm_ : std::max(a, b)};
}

double Drive::CalcWay(double phase_rad, double advance_rad) const {
  const auto way = [&](double rad) {
    const double half_periods = std::floor((rad + 0.5 * kPi) / kPi);
    return amplitude_mm_ * (2 * half_periods + 1 - std::cos(rad + 0.5 * kPi - half_periods * kPi));
  };
  return way(phase_rad + advance_rad) - way(phase_rad);
}

/// Integrates the phase since a place was last passed. The limits are phases since a turn, 0 to pi.
double Drive::IntegrateSincePassed(double from_rad, double to_rad) const {
  double sum = 0;
  const double p = first_pitch_rad_;
  if (from_rad < p) {
    const double to = std::min(to_rad, p);
    sum += (to - from_rad) * (to + from_rad);
  }
  if (to_rad > p) {
    // Behind the first pitch the phase of the tooth in front grows as a square root, and is smooth in w.
    const double pitch = pitch_mm_ / amplitude_mm_;
    sum += Integrate(std::sqrt(std::max(0.0, from_rad - p)), std::sqrt(to_rad - p), [&](double w) {
      const double rad = p + w * w;
      return 2 * w * (rad - std::acos(std::clamp(std::cos(rad) + pitch, -1.0, 1.0)));
    });
  }
  return sum;
}

/// Integrates the phase since a place was last passed over the way. The limits are as above. The phase psi after a turn
/// is A (1 - cos psi) away from it, and the integral of psi over that way is A (sin psi - psi cos psi).
double Drive::IntegrateAlongWay(double from_rad, double to_rad) const {
  const auto integral = [](double psi) { return std::sin(psi) - psi * std::cos(psi); };
  const auto in_front = [this](double psi) {  // phase of the tooth in front
    return std::acos(std::clamp(std::cos(psi) + pitch_mm_ / amplitude_mm_, -1.0, 1.0));
  };
  const double p = first_pitch_rad_;
  double sum = 0;
  if (from_rad < p) sum += 2 * (integral(std::min(to_rad, p)) - integral(from_rad));
  if (to_rad > p) {
    const double from = std::max(from_rad, p);
    sum += integral(to_rad) - integral(from) - (integral(in_front(to_rad)) - integral(in_front(from)));
  }
  return amplitude_mm_ * sum;
}

double Drive::CalcMeanSincePassed(double phase_rad, double advance_rad) const {
  return SumParts(phase_rad, advance_rad, per_half_period_,
                  [this](double from, double to) { return IntegrateSincePassed(from, to); }) /
         advance_rad;
}

double Drive::CalcWayBite(double phase_rad, double advance_rad) const {
  // Over so short a way about a turn the ratio is lost to rounding.
  constexpr double kLeastWay = 1e-6;  // of the amplitude: its rounding is 1e-9 of the ratio
  const double way_mm = CalcWay(phase_rad, advance_rad);
  if (!(way_mm > kLeastWay * amplitude_mm_)) return 1;
  const double along = SumParts(phase_rad, advance_rad, way_per_half_period_,
                                [this](double from, double to) { return IntegrateAlongWay(from, to); });
  return along / way_mm / CalcMeanSincePassed(phase_rad, advance_rad);
}

double Drive::CalcPassRate(double rpm) const {
  return std::max(2.0, passes_per_period()) * CalcRate(rpm);
}

DriveStep Drive::CalcStep(double phase_rad, double rpm, double time_s, double tick_s) const {
  const double rate_hz = CalcRate(rpm);
  if (IsMean(rate_hz, tick_s)) return {{-amplitude_mm_, amplitude_mm_}, 0, 4 * amplitude_mm_ * rate_hz, 0, true};
  const double advance_rad = 2 * kPi * rate_hz * time_s;
  return {CalcRange(phase_rad, advance_rad), CalcDisplacement(phase_rad + 0.5 * advance_rad),
          CalcWay(phase_rad, advance_rad) / time_s,
          (CalcDisplacement(phase_rad + advance_rad) - CalcDisplacement(phase_rad)) / time_s, false};
}

StrokeBites Drive::CalcBites(double phase_rad, double rpm, double time_s, double tick_s) const {
  const double rad_per_s = 2 * kPi * CalcRate(rpm);
  double advance_rad = rad_per_s * time_s;
  if (IsMean(CalcRate(rpm), tick_s)) {
    phase_rad = -0.5 * kPi;
    advance_rad = kPi;
  }
  StrokeBites bites;
  const double way_mm = CalcWay(phase_rad, advance_rad);
  double since_rad = 0;
  for (double at_rad = 0; at_rad < advance_rad;) {
    BitePart& part = bites.parts[static_cast<std::size_t>(bites.count++)];
    const double from_rad = phase_rad + at_rad;
    const double turned_rad = from_rad + 0.5 * kPi - kPi * std::floor((from_rad + 0.5 * kPi) / kPi);
    // To the next place where the bite jumps: where the tooth in front turned, and where the tooth itself turns.
    constexpr double kRounding_rad = 1e-9;
    const double jump_rad = turned_rad < first_pitch_rad_ - kRounding_rad ? first_pitch_rad_ : kPi;
    const double left_rad = advance_rad - at_rad;
    double part_rad = std::min(2 * kPi / StrokeBites::kPartsPerPeriod, std::max(jump_rad - turned_rad, kRounding_rad));
    if (part_rad > left_rad - kRounding_rad || bites.count == static_cast<int>(bites.parts.size())) part_rad = left_rad;
    part.share = part_rad / advance_rad;
    part.bite = CalcMeanSincePassed(from_rad, part_rad);
    part.way_share = way_mm > 0 ? CalcWay(from_rad, part_rad) / way_mm : part.share;
    part.way_bite = CalcWayBite(from_rad, part_rad) * part.bite;
    since_rad += part.share * part.bite;
    at_rad = part_rad == left_rad ? advance_rad : at_rad + part_rad;
  }
  for (BitePart& part : bites.parts) {
    part.bite /= since_rad;
    part.way_bite /= since_rad;
  }
  bites.passes_per_s = rad_per_s / since_rad;
  return bites;
}

double Drive::Advance(double phase_rad, double rpm, double time_s) {
  return std::fmod(phase_rad + 2 * kPi * std::fmod(CalcRate(rpm) * time_s, 1), 2 * kPi);
}

}  // namespace kerf
