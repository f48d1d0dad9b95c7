#include "session/scene/exercise.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <numbers>

#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "session/plan/division.h"

namespace kerf {
namespace {

/// Distance from the region that a solid of revolution passes through on its way down its axis, for a point at a
/// distance from the axis and at a height above the tip. Above the solid's top, that is a cylinder.
double CalcDistanceFromPass(const RoundSolid& solid, double radius_mm, double height_mm) {
  const double outside_mm = solid.CalcSignedDistance({radius_mm, 0, std::min(height_mm, solid.top_z_mm)});
  if (outside_mm > 0) return outside_mm;
  const auto faces = solid.CalcFaces();
  return std::max({faces[0].CalcDistance(radius_mm, height_mm), faces[1].CalcDistance(radius_mm, height_mm),
                   radius_mm - solid.top_radius_mm});
}

/// Returns the part of `v` that is perpendicular to the unit vector `axis`, with unit length; none: it has no such
/// part.
std::optional<Vec3> CalcAcross(const Vec3& v, const Vec3& axis) {
  const Vec3 across = v - glm::dot(v, axis) * axis;
  if (!(glm::length(across) > 1e-6)) return {};
  return glm::normalize(across);
}

/// Sets the directions and the length of a cut along a line.
void SetLine(const SceneCut& wanted, WantedCut& cut) {
  const std::optional<Vec3> along = CalcDirection(wanted.end_mm - wanted.start_mm);
  if (!along) throw Error("[exercise] the line has no length: end_mm equals start_mm");
  cut.along_W = *along;
  const std::optional<Vec3> into = CalcDirection(wanted.into);
  const Vec3 aside = into ? *into - glm::dot(*into, cut.along_W) * cut.along_W : Vec3(0);
  if (!(glm::length(aside) > 1e-6)) {
    throw Error("[exercise] into has no component across the line from start_mm to end_mm");
  }
  cut.into_W = glm::normalize(aside);
  cut.length_mm = glm::distance(wanted.start_mm, wanted.end_mm);
}

/// Sets the directions of a hole; those across it have no meaning of their own.
void SetHole(const SceneCut& wanted, WantedCut& cut) {
  const std::optional<Vec3> into = CalcDirection(wanted.into);
  if (!into) throw Error("[exercise] into has no direction: its length is 0");
  cut.into_W = *into;
  const Vec3 a(std::abs(into->x), std::abs(into->y), std::abs(into->z));
  const Vec3 least = a.x <= a.y && a.x <= a.z ? Vec3(1, 0, 0) : a.y <= a.z ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
  cut.along_W = CalcAcross(least, *into).value();
}

/// Sets what the wanted cut of a blade with a stroke has of its own. Neighbouring plunges overlap by a quarter of the
/// edge.
void SetStroke(const Tool& tool, const PlanarBlade& blade, WantedCut& cut) {
  constexpr double kApart = 0.75;
  cut.outline = MakeStrokeOutline(tool);
  cut.radius_mm = 0;
  for (int i = 0; i < cut.outline.size(); ++i) {
    cut.radius_mm = std::max(cut.radius_mm, std::abs(cut.outline.corner(i).y));
  }
  cut.edge_radius_mm = blade.swing_radius_mm;
  cut.below_mm = 0;
  cut.plunges = 1 + static_cast<int>(std::ceil(cut.length_mm / (kApart * blade.edge_mm)));
}

/// Returns the point of an outline that lies furthest along a direction, tool frame.
Vec3 FindFurthest(const ConvexOutline& outline, const Vec3& n_T) {
  ConvexOutline::Point furthest = outline.corner(0);
  for (int i = 1; i < outline.size(); ++i) {
    const ConvexOutline::Point& p = outline.corner(i);
    if ((p.x - furthest.x) * n_T.x + (p.y - furthest.y) * n_T.y > 0) furthest = p;
  }
  return {furthest.x, furthest.y, 0};
}

WantedCut MakeCut(const SceneExercise& exercise, const SceneCut& wanted, const Tool& tool) {
  WantedCut cut;
  cut.start_W = wanted.start_mm;
  if (exercise.kind == ExerciseKind::kDrillHoles) {
    SetHole(wanted, cut);
  } else {
    SetLine(wanted, cut);
  }
  cut.across_W = glm::cross(cut.along_W, cut.into_W);
  cut.depth_mm = wanted.depth_mm;
  cut.margin_mm = exercise.margin_mm;
  cut.radius_mm = cut.edge_radius_mm = CalcRadius(tool);
  cut.form = GetForm(tool);
  cut.solid = CalcRoundSolid(tool);
  if (cut.solid) cut.solid->side_cuts = true;  // of a drill, too, the whole head counts
  cut.below_mm = cut.solid ? 0 : cut.radius_mm;
  cut.reach_mm = CalcReach(tool);
  cut.thickness_mm = CalcCutWidth(tool);
  if (const std::optional<PlanarBlade> blade = FindPlanarBlade(tool)) SetStroke(tool, *blade, cut);
  return cut;
}

}  // namespace

WantedCut MakeWantedCut(const SceneExercise& exercise, const Tool& tool) {
  return MakeCut(exercise, {exercise.start_mm, exercise.end_mm, exercise.into, exercise.depth_mm, ""}, tool);
}

std::vector<WantedCut> MakeWantedCuts(const SceneExercise& exercise, const Tool& tool) {
  std::vector<WantedCut> cuts{MakeWantedCut(exercise, tool)};
  for (const SceneCut& wanted : exercise.further) cuts.push_back(MakeCut(exercise, wanted, tool));
  return cuts;
}

bool IsSamePlace(const WantedCut& a, const WantedCut& b) {
  constexpr double kSame = 1e-6;  // mm, or of a unit vector; coordinates are written with fewer digits
  const auto same = [](const Vec3& p, const Vec3& q) { return glm::distance(p, q) <= kSame; };
  const Vec3 a_end_W = a.ToWorld({a.length_mm, 0, 0});
  const Vec3 b_end_W = b.ToWorld({b.length_mm, 0, 0});
  return same(a.into_W, b.into_W) && ((same(a.start_W, b.start_W) && same(a_end_W, b_end_W)) ||
                                      (same(a.start_W, b_end_W) && same(a_end_W, b.start_W)));
}

const WantedCut& FindNearestCut(const std::vector<WantedCut>& cuts, const Vec3& p_W) {
  return cuts[FindNearest(cuts.size(), [&](std::size_t i) { return cuts[i].CalcDistance(p_W); })];
}

Pose WantedCut::CalcToolPose(double s_mm, double t_mm) const {
  const Vec3 x_W = outline.empty() ? along_W : into_W;
  const Vec3 z_W = solid ? -into_W : outline.empty() ? across_W : -across_W;
  const glm::dmat3 axes(x_W, glm::cross(z_W, x_W), z_W);
  return {glm::normalize(glm::quat_cast(axes)), ToWorld({s_mm, t_mm - below_mm, 0})};
}

Vec3 WantedCut::FindLowest(const Pose& X_WT) const {
  if (!outline.empty()) {
    const Vec3 into_T = X_WT.InverseVector(into_W);
    return X_WT.p_AB + glm::dot(into_T, FindFurthest(outline, into_T)) * into_W;
  }
  switch (form) {
    case ToolForm::kBlade:
      if (const auto down = CalcAcross(into_W, X_WT.R_AB * Vec3(0, 0, 1))) return X_WT.p_AB + radius_mm * *down;
      return X_WT.p_AB;
    case ToolForm::kRound: {
      const Vec3 into_T = X_WT.InverseVector(into_W);
      return X_WT.p_AB + glm::dot(into_T, solid->FindDeepest(into_T)) * into_W;
    }
    case ToolForm::kBall:
      break;
  }
  return X_WT.p_AB + radius_mm * into_W;
}

double WantedCut::CalcTilt_deg(const Pose& X_WT) const {
  if (form == ToolForm::kBall) return 0;
  if (solid && length_mm == 0) {
    return std::acos(std::clamp(-glm::dot(X_WT.R_AB * Vec3(0, 0, 1), into_W), -1.0, 1.0)) * kDegreesPerRad;
  }
  const double cosine = std::min(std::abs(glm::dot(X_WT.R_AB * Vec3(0, 0, 1), across_W)), 1.0);
  return (solid ? std::asin(cosine) : std::acos(cosine)) * kDegreesPerRad;
}

std::vector<Vec3> WantedCut::CalcOutline(const Pose& X_WT, int points) const {
  std::vector<Vec3> made;
  made.reserve(2 * static_cast<std::size_t>(points));
  if (!outline.empty()) {
    for (int i = 0; i < outline.size(); ++i) {
      const ConvexOutline::Point& from = outline.corner(i);
      const ConvexOutline::Point& to = outline.corner(i + 1 < outline.size() ? i + 1 : 0);
      const double side_mm = std::hypot(to.x - from.x, to.y - from.y);
      // The teeth go straight down, so that they pass only the places of their own points.
      constexpr double kTeethStep_mm = 0.1;
      const double step_mm = outline.side(i).normal.x > 0.5 ? kTeethStep_mm : 4 * reach_mm / points;
      const int steps = std::max(1, static_cast<int>(std::ceil(side_mm / step_mm)));
      for (int j = 0; j < steps; ++j) {
        const double at = static_cast<double>(j) / steps;
        made.push_back(ToCut(X_WT.Point({from.x + at * (to.x - from.x), from.y + at * (to.y - from.y), 0})));
      }
    }
    return made;
  }
  const Vec3 centre = ToCut(X_WT.p_AB);
  std::optional<Vec3> last;
  // Of a solid of revolution, the ends of the axis' circles and the straight lines between them.
  const double step_mm = 4 * reach_mm / points;
  for (int i = 0; i < points + (solid ? 1 : 0); ++i) {
    const double turn = 2 * std::numbers::pi * i / points;
    const double c = std::cos(turn);
    const double s = std::sin(turn);
    if (!solid) {
      const double x = radius_mm * c;
      const double y = radius_mm * s;
      made.push_back(form == ToolForm::kBlade ? ToCut(X_WT.Point({x, y, 0})) : centre + Vec3(x, y, 0));
      continue;
    }
    const Vec3 p = ToCut(X_WT.Point(solid->FindDeepest(X_WT.InverseVector(c * along_W + s * into_W))));
    const int between = last ? static_cast<int>(glm::distance(*last, p) / step_mm) : 0;
    for (int j = 1; j <= between; ++j) made.push_back(*last + static_cast<double>(j) / (between + 1) * (p - *last));
    made.push_back(p);
    last = p;
  }
  return made;
}

double WantedCut::CalcReachAlong(double above_mm) const {
  if (!solid && edge_radius_mm == 0) return radius_mm;
  if (!solid) return std::min(radius_mm, std::sqrt(2 * edge_radius_mm * above_mm));
  double along_mm = solid->top_radius_mm;
  for (const RoundSolid::Face& face : solid->CalcFaces()) {
    if (face.r > 0) along_mm = std::min(along_mm, (face.offset_mm - face.z * above_mm) / face.r);
  }
  return along_mm;
}

double WantedCut::CalcFloor(double beyond_mm) const {
  if (!solid && edge_radius_mm == 0) return depth_mm;
  if (!solid) {
    return depth_mm - edge_radius_mm + std::sqrt(edge_radius_mm * edge_radius_mm - beyond_mm * beyond_mm);
  }
  if (beyond_mm >= solid->top_radius_mm) return -std::numeric_limits<double>::infinity();
  double rise_mm = 0;
  for (const RoundSolid::Face& face : solid->CalcFaces()) {
    if (face.z < 0) rise_mm = std::max(rise_mm, (face.offset_mm - face.r * beyond_mm) / face.z);
  }
  return depth_mm - rise_mm;
}

double WantedCut::CalcInPlane(double beyond_mm, double t_mm) const {
  // The tool has also passed through everything above its path.
  const double centre_mm = depth_mm - edge_radius_mm;
  const double below_centre_mm = edge_radius_mm > 0 ? std::max(t_mm - centre_mm, 0.0) : t_mm - depth_mm;
  const double from_centre_mm = edge_radius_mm > 0 ? std::hypot(beyond_mm, below_centre_mm) : below_centre_mm;
  const double out_mm = from_centre_mm - edge_radius_mm;
  const double beside_mm = beyond_mm - radius_mm;
  if (outline.empty() || beside_mm <= 0) return outline.empty() ? out_mm : std::max(out_mm, beside_mm);
  // Beside the blade, the nearest point is on its side, on the arc, or where they meet.
  const double below_corner_mm = t_mm - CalcFloor(radius_mm);
  if (below_corner_mm <= 0) return beside_mm;
  if (edge_radius_mm > 0 && edge_radius_mm * beyond_mm <= radius_mm * from_centre_mm) return out_mm;
  return std::hypot(beside_mm, below_corner_mm);
}

double WantedCut::CalcDistance(const Vec3& p_W) const {
  const Vec3 p = ToCut(p_W);
  const double beyond_mm = std::abs(p.x - std::clamp(p.x, 0.0, length_mm));
  if (solid) return CalcDistanceFromPass(*solid, std::hypot(beyond_mm, p.z), depth_mm - p.y);
  if (form == ToolForm::kBall) {
    const double t = std::max(p.y - (depth_mm - radius_mm), 0.0);
    return std::sqrt(beyond_mm * beyond_mm + t * t + p.z * p.z) - radius_mm;
  }
  const double in_plane = CalcInPlane(beyond_mm, p.y);
  const double across = std::abs(p.z) - 0.5 * thickness_mm;
  if (in_plane <= 0 || across <= 0) return std::max(in_plane, across);
  return std::hypot(in_plane, across);
}

}  // namespace kerf
