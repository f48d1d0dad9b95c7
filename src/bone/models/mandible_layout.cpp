#include "bone/models/mandible_layout.h"

#include <glm/gtc/constants.hpp>

namespace kerf {
namespace {

constexpr double kBaseSlope_deg = 16.5;  // angle of the base line to the occlusal plane
constexpr double kGonion_y = 68;

}  // namespace

double MandibleLayout::RamusV(double u, double height) const {
  const double angle = glm::radians(params.gonial_angle_deg);
  return (height + u * std::cos(angle)) / std::sin(angle);
}

double MandibleLayout::RamusX(double u, double v) const {
  const double widen_gonion = 0.5 * (params.bigonial_mm - 97);
  const double widen_condyle = 0.5 * (params.bicondylar_mm - 118);
  const double outward = Mix(widen_gonion, widen_condyle, SmoothStep(0, 50, v)) * (1 - 0.5 * SmoothStep(0, 45, u));
  // Near the lower border the plate follows the body; above it the plate is straighter towards the back.
  const double low = 44.2 - 0.07 * u - 0.0125 * u * u;
  const double high = 44.5 - 0.145 * u + 0.149 * v + 0.0004 * u * v;
  return Mix(low, high, SmoothStep(-8, 22, v + 0.35 * u)) + outward;
}

MandibleLayout MakeMandibleLayout(const MandibleParams& params) {
  MandibleLayout m;
  m.params = params;
  const double widen = 0.5 * (params.bigonial_mm - 97);
  std::vector<Vec2> base = {{0, 6.5},     {9.5, 8.2},   {16.8, 13.0}, {21.8, 20.5},
                            {27.0, 31.0}, {33.3, 42.0}, {39.3, 52.0}, {42.6, 58.0}};
  for (Vec2& p : base) p.x += widen * SmoothStep(10, 60, p.y);
  m.base = PlaneCurve(base);
  m.dental = PlaneCurve({{0, 0.9},
                         {5.3, 1.5},
                         {9.5, 3.3},
                         {13.2, 6.6},
                         {16, 11.6},
                         {18.2, 17.6},
                         {20.6, 26.6},
                         {23.4, 37.2},
                         {26, 47.7},
                         {28, 56}});
  // Widths of the teeth from the midline, mm: 5.3, 5.9, 6.9, 7.0, 7.1, 11.2, 10.7, 10.5 (docs/mandible.md).
  m.on_dental = {14.65, 27.2, 35.5, 48.75, 59.35};
  const auto to_base = [&m](double s) { return m.base.FindClosest(m.dental.Point(s)).s; };
  m.on_base = {to_base(m.on_dental.canine), to_base(m.on_dental.mental_foramen), to_base(m.on_dental.first_molar),
               to_base(m.on_dental.second_molar), to_base(m.on_dental.third_molar)};

  m.base_slope = glm::radians(kBaseSlope_deg);
  // The knobs of the chin are slightly below the swept body.
  m.menton_yz = {7.5, -10.3 - params.symphysis_height_mm - 0.3};
  m.gonion_yz = {kGonion_y, m.BaseLineZ(kGonion_y)};
  const double lean = glm::radians(params.gonial_angle_deg - 90 - kBaseSlope_deg);
  m.v_yz = {std::sin(lean), std::cos(lean)};
  m.u_yz = {-std::cos(lean), std::sin(lean)};
  return m;
}

}  // namespace kerf
