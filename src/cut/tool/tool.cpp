#include "kerf/tool.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

void CheckRange(const char* name, double value, double lower, double upper) {
  if (!(value >= lower && value <= upper)) {
    throw Error(fmt::format("{} = {} is out of range; valid range {} to {}", name, value, lower, upper));
  }
}

}  // namespace

void DiscSaw::Validate() const {
  CheckRange("diameter_mm", diameter_mm, 1, 200);
  CheckRange("thickness_mm", thickness_mm, 0.02, 10);
  CheckRange("teeth", teeth, 1, 1000);
  CheckRange("E_MPa", E_MPa, 1, 1e9);
  CheckRange("nu", nu, 0, 0.5);
  for (int axis = 0; axis < 3; ++axis) CheckRange("grip_mm", p_TG_mm[axis], -1000, 1000);
}

void BallBurr::Validate() const {
  CheckRange("diameter_mm", diameter_mm, 0.5, 50);
  CheckRange("flutes", flutes, 1, 100);
  CheckRange("tooth_width_mm", tooth_width_mm, 0.01, 50);
  CheckRange("E_MPa", E_MPa, 1, 1e9);
  CheckRange("nu", nu, 0, 0.5);
  for (int axis = 0; axis < 3; ++axis) CheckRange("grip_mm", p_TG_mm[axis], -1000, 1000);
}

void Validate(const Tool& tool) {
  std::visit([](const auto& t) { t.Validate(); }, tool);
}
double CalcReach(const Tool& tool) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) return std::hypot(disc->radius_mm(), 0.5 * disc->thickness_mm);
  return std::get<BallBurr>(tool).radius_mm();
}
double CalcThickness(const Tool& tool) {
  const auto* disc = std::get_if<DiscSaw>(&tool);
  return disc ? disc->thickness_mm : 0;
}

double CalcModulus(const Tool& tool) {
  return std::visit([](const auto& t) { return t.E_MPa; }, tool);
}
double CalcPoissonRatio(const Tool& tool) {
  return std::visit([](const auto& t) { return t.nu; }, tool);
}
Tooth CalcTooth(const Tool& tool) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) return {disc->radius_mm(), disc->pitch_mm(), disc->thickness_mm};
  const auto& ball = std::get<BallBurr>(tool);
  return {ball.radius_mm(), 2 * std::numbers::pi * ball.radius_mm() / ball.flutes, ball.tooth_width_mm};
}
Vec3 CalcGrip(const Tool& tool) {
  return std::visit([](const auto& t) { return t.p_TG_mm; }, tool);
}

}  // namespace kerf
