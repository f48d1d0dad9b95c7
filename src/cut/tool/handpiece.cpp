#include "cut/tool/handpiece.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <variant>

#include "cut/tool/disc_saw.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kBehindGrip_mm = 25;
// Of a solid of revolution, which has a long shank: its visible length and the least radius of the neck that holds it.
constexpr double kShankShown_mm = 5;
constexpr double kLeastNeck_mm = 1.2;
// Radius of a shank as a fraction of the tool's, and where that of a ball begins.
constexpr double kRoundShank = 0.6;
constexpr double kBallShank = 0.45;
constexpr double kAboveBall = 1.1;
constexpr double kSpindleOfHub = 0.6;  // radius of a disc's spindle as a fraction of its hub's

/// In a frame H whose z axis is that of the neck.
struct Proportions {
  Pose X_TH;         // that of the tool for a tool that turns; of a blade with a stroke behind it
  double start_mm;   // where the neck begins, along z
  double neck_mm;    // radius of the neck at its start
  double collar_mm;  // where the handle begins, along z
  Vec3 end_H{0};     // end of the handle
};

Proportions CalcProportions(const Tool& tool) {
  const double radius = CalcReach(tool);
  const bool blade = IsBlade(tool);
  Proportions p{};
  p.start_mm = blade ? 0.45 * radius : 1.6 * radius;
  p.neck_mm = blade ? 0.17 * radius : 0.55 * radius;
  p.collar_mm = p.start_mm + std::clamp(2 * radius, 10.0, 24.0);
  if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
    p.start_mm = solid->top_z_mm + kShankShown_mm;
    p.neck_mm = std::max(solid->top_radius_mm, kLeastNeck_mm);
    p.collar_mm = p.start_mm + 10;
  }
  Vec3 grip = CalcGrip(tool);
  if (const ConvexOutline outline = MakeStrokeOutline(tool); !outline.empty()) {
    Box3 box;
    for (int i = 0; i < outline.size(); ++i) box.Include({outline.corner(i).x, outline.corner(i).y, 0});
    // The handle follows a blade with a tip at its end: z of H is -y of T. Other blades it follows at their back: -x.
    const bool at_end = FindPlanarBlade(tool)->has_tip;
    const double quarter_rad = 0.5 * std::numbers::pi;
    p.X_TH = {at_end ? glm::angleAxis(quarter_rad, Vec3{1, 0, 0}) : glm::angleAxis(-quarter_rad, Vec3{0, 1, 0}),
              box.centre()};
    p.start_mm = 0.5 * (at_end ? box.size().y : box.size().x);
    p.neck_mm = 0.4 * (at_end ? box.size().x : box.size().y);
    p.collar_mm = p.start_mm + 12;
    grip = p.X_TH.InversePoint(grip);
  }
  // The axis from the collar through the grip, unless the grip lies beside or before the collar.
  const Vec3 from{0, 0, p.collar_mm};
  const Vec3 to_grip = grip - from;
  const bool on_side = to_grip.z > 10 && to_grip.z > 0.4 * glm::length(to_grip);
  const Vec3 axis = on_side ? glm::normalize(to_grip) : Vec3{0, 0, 1};
  const double length = on_side ? std::min(glm::length(to_grip), 150.0) : 60.0;
  p.end_H = from + (length + kBehindGrip_mm) * axis;
  return p;
}

/// Returns a cylinder about the z axis of T.
HolderBody MakeCylinder(HolderBody::Part part, double radius_mm, double from_mm, double to_mm) {
  return {part, {{{0, 0, from_mm}, {1, 0, 0, 0}, radius_mm}, {{0, 0, to_mm}, {1, 0, 0, 0}, radius_mm}}};
}

}  // namespace

HolderBody MakeHandpiece(const Tool& tool) {
  const Proportions p = CalcProportions(tool);
  const Vec3 from{0, 0, p.collar_mm};
  const Vec3 along = p.end_H - from;
  const double handle = std::clamp(0.07 * glm::length(along), 4.0, 6.5);
  const double collar = std::max(0.62 * handle, 1.15 * p.neck_mm);
  const double neck = std::min(1.3 * p.neck_mm, collar);
  HolderBody body;
  const auto add = [&](const Vec3& middle_H, double radius_mm, const Quat& R_HS) {
    body.sections.push_back({p.X_TH.Point(middle_H), p.X_TH.R_AB * R_HS, radius_mm});
  };
  const double rise = p.collar_mm - p.start_mm;
  const Quat straight{1, 0, 0, 0};
  add({0, 0, p.start_mm}, p.neck_mm, straight);
  add({0, 0, p.start_mm + 0.55 * rise}, neck, straight);
  add({0, 0, p.start_mm + 0.62 * rise}, collar, straight);
  add(from, collar, straight);
  const Vec3 axis = glm::normalize(along);
  const Vec3 turn = glm::cross(Vec3{0, 0, 1}, axis);
  const Quat bent =
      glm::length(turn) > 1e-9 ? glm::angleAxis(std::atan2(glm::length(turn), axis.z), glm::normalize(turn)) : straight;
  // Fractions of the handle's length and radius: a waist, a grip and a rounded end.
  constexpr double kProfile[][2] = {{0.06, 0.78}, {0.1, 0.7},   {0.16, 0.82}, {0.3, 0.97}, {0.5, 1.0},
                                    {0.78, 0.94}, {0.94, 0.88}, {0.98, 0.7},  {1.0, 0.42}};
  for (const auto& [fraction, width] : kProfile) add(from + fraction * along, width * handle, bent);
  return body;
}

std::vector<HolderBody> MakeHolder(const Tool& tool) {
  std::vector<HolderBody> bodies;
  HolderBody handpiece = MakeHandpiece(tool);
  const double neck_z = handpiece.sections.front().middle_T.z;
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) {
    const DiscHub hub = CalcHub(*disc);
    const double half = 0.5 * disc->thickness_mm;
    bodies.push_back(MakeCylinder(HolderBody::Part::kHub, hub.radius_mm, -hub.outer_z_mm, -half));
    bodies.push_back(MakeCylinder(HolderBody::Part::kHub, hub.radius_mm, half, hub.outer_z_mm));
    bodies.push_back(MakeCylinder(HolderBody::Part::kShank, kSpindleOfHub * hub.radius_mm, hub.outer_z_mm, neck_z));
  } else if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
    bodies.push_back(
        MakeCylinder(HolderBody::Part::kShank, kRoundShank * solid->top_radius_mm, solid->top_z_mm, neck_z));
  } else if (GetForm(tool) == ToolForm::kBall) {
    const double radius = CalcReach(tool);
    bodies.push_back(MakeCylinder(HolderBody::Part::kShank, kBallShank * radius, kAboveBall * radius, neck_z));
  }
  bodies.push_back(std::move(handpiece));
  return bodies;
}

}  // namespace kerf
