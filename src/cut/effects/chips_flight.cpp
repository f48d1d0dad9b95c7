#include "cut/effects/chips_flight.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kDensity_kg_per_m3 = 1908;    // cortical bone, IT'IS database, as in "heat"
constexpr double kAirDensity_kg_per_m3 = 1.2;  // at 20 C, like the viscosity
constexpr double kAirViscosity_Pas = 1.81e-5;
constexpr double kFullDrag = 0.44;  // coefficient at high Reynolds numbers
constexpr int kSteps = 32;

}  // namespace

ChipFlight::ChipFlight(double diameter_mm, double drag, const Vec3& gravity_mm_per_s2)
    : drag_per_s_(drag * 18 * kAirViscosity_Pas / (kDensity_kg_per_m3 * 1e-6 * diameter_mm * diameter_mm)),
      reynolds_per_mm_per_s_(1e-6 * kAirDensity_kg_per_m3 * diameter_mm / kAirViscosity_Pas),
      g_mm_per_s2_(gravity_mm_per_s2) {}

double ChipFlight::CalcDragRate(double speed_mm_per_s) const {
  const double reynolds = reynolds_per_mm_per_s_ * speed_mm_per_s;
  return drag_per_s_ * std::max(1 + 0.15 * std::pow(reynolds, 0.687), kFullDrag / 24 * reynolds);
}

/// Makes a step that is exact for a constant drag rate.
ChipMotion ChipFlight::Step(const ChipMotion& from, double rate_per_s, double dt_s) const {
  const double x = rate_per_s * dt_s;
  // First and second integral of e^(-k t) over the step: (1 - e^-x) / k and (x - 1 + e^-x) / k^2.
  double once_s = dt_s, twice_s2 = 0;
  if (x < 1e-3) {
    once_s = dt_s * (1 - x / 2 + x * x / 6);
    twice_s2 = dt_s * dt_s * (0.5 - x / 6 + x * x / 24);
  } else {
    once_s = -std::expm1(-x) / rate_per_s;
    twice_s2 = (dt_s - once_s) / rate_per_s;
  }
  return {from.p_mm + once_s * from.v_mm_per_s + twice_s2 * g_mm_per_s2_,
          std::exp(-x) * from.v_mm_per_s + once_s * g_mm_per_s2_};
}

ChipMotion ChipFlight::CalcMotion(const ChipMotion& start, double age_s) const {
  if (!(age_s > 0)) return start;
  if (drag_per_s_ == 0) return Step(start, 0, age_s);
  ChipMotion motion = start;
  double from_s = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double fraction = static_cast<double>(i) / kSteps;
    const double to_s = fraction * fraction * fraction * age_s;
    const double dt_s = to_s - from_s;
    const ChipMotion middle = Step(motion, CalcDragRate(glm::length(motion.v_mm_per_s)), 0.5 * dt_s);
    motion = Step(motion, CalcDragRate(glm::length(middle.v_mm_per_s)), dt_s);
    from_s = to_s;
  }
  return motion;
}

}  // namespace kerf
