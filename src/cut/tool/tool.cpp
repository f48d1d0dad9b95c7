#include "kerf/tool.h"

#include <cmath>
#include <numbers>

namespace kerf {
void DiscSaw::Validate() const {
  CheckParameters(*this);
}

void BallBurr::Validate() const {
  CheckParameters(*this);
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
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    return {disc->radius_mm(), disc->pitch_mm(), disc->thickness_mm, disc->rake_deg, 1e-3 * disc->edge_radius_um};
  }
  const auto& ball = std::get<BallBurr>(tool);
  return {ball.radius_mm(), 2 * std::numbers::pi * ball.radius_mm() / ball.flutes, ball.tooth_width_mm, ball.rake_deg,
          1e-3 * ball.edge_radius_um};
}
Vec3 CalcGrip(const Tool& tool) {
  return std::visit([](const auto& t) { return t.p_TG_mm; }, tool);
}

}  // namespace kerf
