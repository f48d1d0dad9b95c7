#include "cut/tool/ball_burr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {

std::string ToolKind<BallBurr>::Name(const BallBurr& ball) {
  return fmt::format("ball burr {:g} mm, {} flutes", ball.diameter_mm, ball.flutes);
}

std::string ToolKind<BallBurr>::ShortName(const BallBurr& ball) {
  return fmt::format("{:g} mm ball", ball.diameter_mm);
}

Tooth ToolKind<BallBurr>::CalcTooth(const BallBurr& ball) {
  return {ball.radius_mm(), 2 * std::numbers::pi * ball.radius_mm() / ball.flutes, ball.tooth_width_mm, ball.rake_deg,
          1e-3 * ball.edge_radius_um};
}

Vec3 ToolKind<BallBurr>::FindNearest(const BallBurr& ball, const Vec3& p_T) {
  const double length = glm::length(p_T);
  return length > ball.radius_mm() ? ball.radius_mm() / length * p_T : p_T;
}

double ToolKind<BallBurr>::CalcSignedDistance(const BallBurr& ball, const Vec3& p_T) {
  return glm::length(p_T) - ball.radius_mm();
}

Vec3 ToolKind<BallBurr>::FindDeepest(const BallBurr& ball, const Vec3& n_T) {
  const double length = glm::length(n_T);
  return length > 1e-9 ? ball.radius_mm() / length * n_T : Vec3(0);
}

ToolShape ToolKind<BallBurr>::MakeShape(const BallBurr& ball, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = ball.flutes;
  const double r = ball.radius_mm();
  // The spacing along a meridian is about the same as around the equator.
  const int meridians = std::max(32, 2 * sampling.samples_per_pitch);
  const int parallels = std::max(16, sampling.samples_per_pitch);
  for (int j = 0; j < parallels; ++j) {
    const double colatitude = std::numbers::pi * (j + 0.5) / parallels;
    for (int i = 0; i < meridians; ++i) {
      const double longitude = 2 * std::numbers::pi * (i + 0.5 * (j % 2)) / meridians;
      const Vec3 e_T(std::sin(colatitude) * std::cos(longitude), std::sin(colatitude) * std::sin(longitude),
                     std::cos(colatitude));
      const double edge_mm = ball.flutes * std::numbers::pi * r / (parallels * meridians);
      shape.edge.push_back({r * e_T, e_T, edge_mm / ball.tooth_width_mm});
    }
  }
  return shape;
}

}  // namespace kerf
