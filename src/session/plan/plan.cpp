#include "session/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>
#include <string_view>
#include <variant>

#include "cut/tool/shape.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kUnitTolerance = 1e-6;
constexpr double kMaxStopAngle_deg = 20;  // maximum angle between a stop's direction and the plane of a guide
constexpr double kFree_mm = 100;          // maximum of the guide's tolerance, within which the tool moves freely

template <typename Item>
void CheckNames(const std::vector<Item>& items, const char* what) {
  if (items.size() > kMaxPlanned) throw Error(fmt::format("a plan has at most {} {}s", kMaxPlanned, what));
  std::set<std::string> names;
  for (const Item& item : items) {
    if (item.name.empty()) throw Error(fmt::format("a {} of the plan has no name", what));
    if (!names.insert(item.name).second) {
      throw Error(fmt::format("two {}s of the plan are named '{}'; each needs its own name", what, item.name));
    }
  }
}

template <typename Item>
std::string MakeName(const std::vector<Item>& items, const char* what) {
  for (std::size_t i = 1;; ++i) {
    std::string name = fmt::format("{} {}", what, i);
    const bool taken = std::any_of(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
    if (!taken) return name;
  }
}

bool IsUnit(const Vec3& v) {
  return std::abs(glm::length(v) - 1) <= kUnitTolerance;
}

}  // namespace

void CheckPlan(const Plan& plan) {
  CheckNames(plan.planes, "plane");
  CheckNames(plan.stops, "stop");
  for (const PlannedPlane& p : plan.planes) {
    CheckParameters(p, fmt::format("plane '{}'", p.name));
    if (!IsUnit(p.plane.normal_W)) throw Error(fmt::format("plane '{}': its normal must have length 1", p.name));
  }
  for (const DepthStop& s : plan.stops) {
    CheckParameters(s, fmt::format("stop '{}'", s.name));
    if (!IsUnit(s.direction_W)) throw Error(fmt::format("stop '{}': its direction must have length 1", s.name));
  }
}

std::string MakePlaneName(const Plan& plan) {
  return MakeName(plan.planes, "plane");
}
std::string MakeStopName(const Plan& plan) {
  return MakeName(plan.stops, "stop");
}

PlannedPlane PlacePlane(const std::string& name, const Vec3& a_W, const Vec3& b_W, const Vec3& c_W) {
  const Vec3 u = b_W - a_W;
  const Vec3 v = c_W - a_W;
  const Vec3 n = glm::cross(u, v);
  const double longest = std::max({glm::length(u), glm::length(v), glm::length(c_W - b_W)});
  if (!(glm::length(n) > 1e-3 * longest * longest) || !(longest > 1e-6)) {
    throw Error("the three points lie on a line, so they do not define a plane; pick them further apart");
  }
  return {.name = name, .plane = {(a_W + b_W + c_W) / 3.0, glm::normalize(n)}, .margin_mm = 1};
}

PlannedPlane PlacePlane(const std::string& name, const Pose& X_WT) {
  return {.name = name, .plane = {X_WT.p_AB, glm::normalize(X_WT.Vector({0, 0, 1}))}, .margin_mm = 1};
}

std::vector<PlaneMarkup> MakeMarkups(const Plan& plan) {
  std::vector<PlaneMarkup> markups;
  for (const PlannedPlane& p : plan.planes) markups.push_back({.name = p.name, .plane = p.plane});
  return markups;
}

PlaneAngles CalcPlaneAngles(const Vec3& planned_normal_W, const Vec3& normal_W, const Vec3& depth_W) {
  const Vec3& n = planned_normal_W;
  const Vec3 z = glm::dot(n, normal_W) < 0 ? -normal_W : normal_W;
  const Vec3 d = glm::normalize(depth_W - glm::dot(depth_W, n) * n);
  const Vec3 a = glm::cross(n, d);
  const double up = glm::dot(z, n);
  // Along the plane across z, the offset grows by -(z.d)/(z.n) with depth.
  return {.angle_deg = kDegreesPerRad * std::atan2(glm::length(glm::cross(z, n)), up),
          .pitch_deg = kDegreesPerRad * std::atan2(-glm::dot(z, a), up),
          .roll_deg = kDegreesPerRad * std::atan2(-glm::dot(z, d), up)};
}

PlaneDeviation CalcDeviation(const PlannedPlane& planned, const Tool& tool, const Pose& X_WT) {
  const CutPlane& plane = planned.plane;
  PlaneDeviation out;
  out.p_W_mm = X_WT.p_AB;
  if (IsBlade(tool)) {
    const Vec3 z = X_WT.Vector({0, 0, 1});
    const Vec3 to_point = plane.p_W - X_WT.p_AB;
    const Vec3 across = to_point - glm::dot(to_point, z) * z;
    const double distance_mm = glm::length(across);
    Vec3 depth = X_WT.Vector({1, 0, 0});
    if (CalcStroke(tool) > 0) {
      const Vec3 p_T = X_WT.InversePoint(plane.p_W);
      const ConvexOutline::Point nearest = MakeToolOutline(tool).FindNearest({p_T.x, p_T.y});
      out.p_W_mm = X_WT.Point({nearest.x, nearest.y, 0});
    } else {
      const double R = CalcRadius(tool);
      out.p_W_mm = X_WT.p_AB + (distance_mm > R ? R / distance_mm : 1.0) * across;
      if (distance_mm > 1e-9) depth = across;
    }
    // If the blade is perpendicular to the planned plane, any depth direction in the plane is valid.
    const auto is_across = [&](const Vec3& v) {
      return !(glm::length(glm::cross(v, plane.normal_W)) > 1e-9 * glm::length(v));
    };
    if (is_across(depth)) depth = X_WT.Vector({0, 1, 0});
    if (is_across(depth)) depth = z;
    const PlaneAngles angles = CalcPlaneAngles(plane.normal_W, z, depth);
    out.angle_deg = angles.angle_deg;
    out.pitch_deg = angles.pitch_deg;
    out.roll_deg = angles.roll_deg;
  }
  out.offset_mm = glm::dot(plane.normal_W, out.p_W_mm - plane.p_W);
  out.within_margin = std::abs(out.offset_mm) <= planned.margin_mm;
  return out;
}

StopDeviation CalcDeviation(const DepthStop& stop, const Tool& tool, const Pose& X_WT) {
  if (GetForm(tool) == ToolForm::kRound || CalcStroke(tool) > 0) {
    const Vec3 deepest_W = X_WT.Point(FindDeepest(tool, X_WT.InverseVector(stop.direction_W)));
    const double depth_mm = glm::dot(stop.direction_W, deepest_W - stop.p_W_mm);
    return {.depth_mm = depth_mm, .left_mm = stop.depth_mm - depth_mm};
  }
  double fraction = 1;
  if (IsBlade(tool)) {
    const double along = glm::dot(X_WT.Vector({0, 0, 1}), stop.direction_W);
    fraction = std::sqrt(std::max(0.0, 1 - along * along));
  }
  const double depth_mm = glm::dot(stop.direction_W, X_WT.p_AB - stop.p_W_mm) + fraction * CalcRadius(tool);
  return {.depth_mm = depth_mm, .left_mm = stop.depth_mm - depth_mm};
}

EffectChoice MakeGuide(const PlannedPlane* plane, const DepthStop* stop) {
  if (plane == nullptr && stop == nullptr) throw Error("a guide needs a plane or a stop in the plan");
  EffectChoice guide("guide");
  Vec3 normal_W(0, 0, 1);
  Vec3 p_W_mm(0);
  Vec3 depth_W(1, 0, 0);
  if (plane != nullptr) {
    normal_W = plane->plane.normal_W;
    p_W_mm = plane->plane.p_W;
    guide.Set("tolerance_mm", std::min(plane->margin_mm, kGuidePlay_mm));
  }
  const Vec3 other_axis = std::abs(normal_W.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  depth_W = glm::normalize(other_axis - glm::dot(other_axis, normal_W) * normal_W);
  if (stop != nullptr) {
    depth_W = stop->direction_W;
    p_W_mm = stop->p_W_mm;
    if (plane != nullptr) {
      const double sine = glm::dot(depth_W, normal_W);
      if (std::abs(sine) > std::sin(kMaxStopAngle_deg / kDegreesPerRad)) {
        throw Error(
            fmt::format("stop '{}' points {:.0f} degrees out of plane '{}'; a guide limits the depth within its plane",
                        stop->name, kDegreesPerRad * std::asin(std::min(1.0, std::abs(sine))), plane->name));
      }
      depth_W = glm::normalize(depth_W - sine * normal_W);
      p_W_mm -= glm::dot(normal_W, p_W_mm - plane->plane.p_W) * normal_W;
    } else {
      const Vec3 axis = std::abs(depth_W.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
      normal_W = glm::normalize(glm::cross(depth_W, axis));
      guide.Set("tolerance_mm", kFree_mm);
    }
    // A depth of 0 would mean that there is no stop.
    guide.Set("depth_mm", std::max(stop->depth_mm, 1e-6));
  }
  guide.Set("point_mm", p_W_mm);
  guide.Set("normal", normal_W);
  guide.Set("depth_direction", depth_W);
  return guide;
}

bool IsGuideOf(const EffectChoice& guide, const PlannedPlane& plane) {
  const auto get = [&guide](std::string_view key) {
    return std::get<Vec3>(guide.values()[guide.info().FindParameter(key)]);
  };
  const Vec3 normal_W = glm::normalize(get("normal"));
  constexpr double kSame_mm = 0.01;
  constexpr double kSame_rad = 1e-3;
  return glm::length(glm::cross(normal_W, plane.plane.normal_W)) < kSame_rad &&
         std::abs(glm::dot(get("point_mm") - plane.plane.p_W, plane.plane.normal_W)) < kSame_mm;
}

}  // namespace kerf
