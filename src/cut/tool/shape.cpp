#include "cut/tool/shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {
namespace {

void AddFaceRing(const DiscSaw& disc, double radius, double spacing_mm, double phase, bool while_stopped,
                 ToolShape& shape) {
  const int points = std::max(6, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / spacing_mm)));
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * (i + phase) / points;
    for (const double side : {-1.0, 1.0}) {
      shape.faces.push_back({{radius * std::cos(angle), radius * std::sin(angle), side * 0.5 * disc.thickness_mm},
                             {0, 0, side},
                             while_stopped});
    }
  }
}

ToolShape MakeDiscShape(const DiscSaw& disc, int samples_per_pitch, double face_spacing_mm, double rim_margin_mm,
                        double stopped_margin_mm) {
  ToolShape shape;
  shape.passes_per_turn = disc.teeth;
  shape.edge_is_ring = true;
  const int count = std::max(64, disc.teeth * samples_per_pitch);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const Vec3 e_T(std::cos(angle), std::sin(angle), 0);
    shape.edge.push_back({disc.radius_mm() * e_T, e_T, static_cast<double>(disc.teeth) / count});
  }
  const double outermost = disc.radius_mm() - std::min(rim_margin_mm, 0.5 * disc.radius_mm());
  const double stopped = disc.radius_mm() - std::min(stopped_margin_mm, 0.5 * disc.radius_mm());
  if (stopped > outermost) AddFaceRing(disc, stopped, face_spacing_mm, 0, true, shape);
  // Rings are twice as close along the radius as points along a ring: in a shallow kerf only a few rings hold the disc
  // against tilting.
  const int rings = std::max(1, static_cast<int>(std::ceil(outermost / (0.5 * face_spacing_mm))));
  for (int ring = rings; ring >= 1; --ring) {
    AddFaceRing(disc, outermost * ring / rings, (ring == rings ? 1 : 2) * face_spacing_mm, 0.5 * (ring % 2), false,
                shape);
  }
  return shape;
}

/// The teeth are treated as continuous along the flutes. An element of the sphere between two circles of latitude and
/// two meridians represents flutes / (2 pi) * d(longitude) * r d(latitude) / tooth_width teeth, independent of the
/// latitude.
ToolShape MakeBallShape(const BallBurr& ball, int samples_per_pitch) {
  ToolShape shape;
  shape.passes_per_turn = ball.flutes;
  const double r = ball.radius_mm();
  // The spacing along a meridian is about the same as around the equator.
  const int meridians = std::max(32, 2 * samples_per_pitch);
  const int parallels = std::max(16, samples_per_pitch);
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

}  // namespace

ToolShape MakeToolShape(const Tool& tool, int samples_per_pitch, double face_spacing_mm, double rim_margin_mm,
                        double stopped_margin_mm) {
  const auto* disc = std::get_if<DiscSaw>(&tool);
  ToolShape shape = disc ? MakeDiscShape(*disc, samples_per_pitch, face_spacing_mm, rim_margin_mm, stopped_margin_mm)
                         : MakeBallShape(std::get<BallBurr>(tool), samples_per_pitch);
  shape.reach_mm = CalcReach(tool);
  return shape;
}

double CalcToolDistance(const Tool& tool, const Vec3& p_T) {
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    const double out = std::max(std::hypot(p_T.x, p_T.y) - disc->radius_mm(), 0.0);
    const double across = std::max(std::abs(p_T.z) - 0.5 * disc->thickness_mm, 0.0);
    return std::hypot(out, across);
  }
  return std::max(glm::length(p_T) - std::get<BallBurr>(tool).radius_mm(), 0.0);
}

double CalcTravel(const Pose& from, const Pose& to, double reach_mm) {
  // Half the chord between two unit quaternions (with signs chosen for the shorter one) is sin(angle / 4).
  const Quat d = glm::dot(from.R_AB, to.R_AB) < 0 ? from.R_AB + to.R_AB : from.R_AB - to.R_AB;
  const double angle = 4 * std::asin(std::min(1.0, 0.5 * std::sqrt(glm::dot(d, d))));
  return glm::length(to.p_AB - from.p_AB) + angle * reach_mm;
}

}  // namespace kerf
