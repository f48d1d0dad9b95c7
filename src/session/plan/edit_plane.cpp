#include "session/plan/edit_plane.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "base/core/printable.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kMinSightSine = 0.052;  // sine of 3 degrees

/// Rotates the plane and its rectangle about its centre.
PlannedPlane Rotated(PlannedPlane plane, const PlaneAxes& axes, const Quat& R) {
  plane.plane.normal_W = glm::normalize(R * axes.normal_W);
  plane.up_W = glm::normalize(R * axes.up_W);
  return plane;
}

bool IsTaken(const Plan& plan, const std::string& name) {
  return std::any_of(plan.planes.begin(), plan.planes.end(), [&](const PlannedPlane& p) { return p.name == name; });
}

/// Returns the point where a line of sight meets the plane through p.
std::optional<Vec3> FindCrossing(const SightLine& line, const Vec3& p, const Vec3& normal) {
  const Vec3 d = glm::normalize(line.direction_W);
  const double sine = glm::dot(d, normal);
  if (!(std::abs(sine) > kMinSightSine)) return {};
  return line.p_W + glm::dot(p - line.p_W, normal) / sine * d;
}

/// Returns how far along the axis through p its point nearest to a line of sight lies, mm.
std::optional<double> FindNearestOnAxis(const SightLine& line, const Vec3& p, const Vec3& axis) {
  const Vec3 d = glm::normalize(line.direction_W);
  const double along = glm::dot(d, axis);
  const double sine2 = 1 - along * along;
  if (!(sine2 > kMinSightSine * kMinSightSine)) return {};
  const Vec3 to_line = line.p_W - p;
  return (glm::dot(to_line, axis) - along * glm::dot(to_line, d)) / sine2;
}

/// Returns the angle by which an edge at distance `arm_mm` from the centre has been raised.
double CalcTilt_deg(double from_mm, double to_mm, double arm_mm) {
  return kDegreesPerRad * (std::atan2(to_mm, arm_mm) - std::atan2(from_mm, arm_mm));
}

}  // namespace

PlaneAxes CalcPlaneAxes(const PlannedPlane& plane) {
  const Vec3& n = plane.plane.normal_W;
  Vec3 up = CalcDirection(plane.up_W).value_or(Vec3(0, 0, 1));
  up -= glm::dot(up, n) * n;
  if (!(glm::length(up) > 1e-6)) {
    const Vec3 a = glm::abs(n);
    up = a.x <= a.y && a.x <= a.z ? Vec3(1, 0, 0) : a.y <= a.z ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
    up -= glm::dot(up, n) * n;
  }
  up = glm::normalize(up);
  return {.across_W = glm::cross(up, n), .up_W = up, .normal_W = n};
}

std::array<Vec3, 4> CalcPlaneCorners(const PlannedPlane& plane) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Vec3 a = 0.5 * plane.width_mm * axes.across_W;
  const Vec3 b = 0.5 * plane.height_mm * axes.up_W;
  const Vec3& p = plane.plane.p_W;
  return {p - a - b, p + a - b, p + a + b, p - a + b};
}

PlannedPlane MovePlane(PlannedPlane plane, const Vec3& move_mm) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  plane.plane.p_W += move_mm.x * axes.across_W + move_mm.y * axes.up_W + move_mm.z * axes.normal_W;
  return plane;
}

PlannedPlane TiltPlane(PlannedPlane plane, double about_across_deg, double about_up_deg) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Quat first = glm::angleAxis(about_across_deg / kDegreesPerRad, axes.across_W);
  const Quat second = glm::angleAxis(about_up_deg / kDegreesPerRad, glm::normalize(first * axes.up_W));
  return Rotated(std::move(plane), axes, glm::normalize(second * first));
}

PlannedPlane TurnPlane(PlannedPlane plane, PlaneAxis axis, double angle_deg) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Vec3& about_W = axis == PlaneAxis::kAcross ? axes.across_W : axis == PlaneAxis::kUp ? axes.up_W : axes.normal_W;
  return Rotated(std::move(plane), axes, glm::angleAxis(angle_deg / kDegreesPerRad, about_W));
}

PatientAngles CalcPatientAngles(const PlannedPlane& plane) {
  const Vec3& n = plane.plane.normal_W;
  // The angle between two planes is that between their normals. The arc tangent is exact for small angles too.
  const auto angle_deg = [&](int i) {
    return kDegreesPerRad * std::atan2(std::hypot(n[(i + 1) % 3], n[(i + 2) % 3]), std::abs(n[i]));
  };
  return {.sagittal_deg = angle_deg(static_cast<int>(PatientPlane::kSagittal)),
          .coronal_deg = angle_deg(static_cast<int>(PatientPlane::kCoronal)),
          .axial_deg = angle_deg(static_cast<int>(PatientPlane::kAxial))};
}

PlannedPlane AlignPlane(PlannedPlane plane, PatientPlane with) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const int i = static_cast<int>(with);
  const auto along = [](int axis, double sign) {
    Vec3 direction(0);
    direction[axis] = sign < 0 ? -1 : 1;
    return direction;
  };
  const int j = (i + 1) % 3;
  const int k = (i + 2) % 3;
  const int up = std::abs(axes.up_W[j]) > std::abs(axes.up_W[k]) ? j : k;
  plane.plane.normal_W = along(i, axes.normal_W[i]);
  plane.up_W = along(up, axes.up_W[up]);
  return plane;
}

PlannedPlane MirrorPlane(const Plan& plan, const PlannedPlane& plane, double mid_x_mm) {
  PlannedPlane mirrored = plane;
  mirrored.name = MakeUniquePlaneName(plan, fmt::format("{} mirrored", plane.name));
  mirrored.plane.p_W.x = 2 * mid_x_mm - plane.plane.p_W.x;
  mirrored.plane.normal_W.x = -plane.plane.normal_W.x;
  mirrored.up_W.x = -plane.up_W.x;
  mirrored.state = PlaneState::kPlanned;
  return mirrored;
}

std::string MakeUniquePlaneName(const Plan& plan, const std::string& wanted) {
  const std::size_t limit = kPlanNameLimit.characters;
  const std::string base = wanted.empty() ? std::string("plane") : wanted;
  std::string name = FirstCharacters(base, limit);
  for (int i = 2; IsTaken(plan, name); ++i) {
    const std::string ending = fmt::format(" {}", i);
    name = FirstCharacters(base, limit - ending.size()) + ending;
  }
  return name;
}

void RenamePlane(Plan& plan, std::size_t i, const std::string& name) {
  if (i >= plan.planes.size()) throw Error(fmt::format("the plan has no plane {}", i + 1));
  if (name.empty()) throw Error("the name of a plane must not be empty");
  if (CountCharacters(name) > kPlanNameLimit.characters) {
    throw Error(fmt::format("the name of a plane must have at most {} characters", kPlanNameLimit.characters));
  }
  if (plan.planes[i].name == name) return;
  if (IsTaken(plan, name)) throw Error(fmt::format("another plane of the plan is named '{}'", name));
  plan.planes[i].name = name;
}

void ReorderPlane(Plan& plan, std::size_t from, std::size_t to) {
  const std::size_t count = plan.planes.size();
  if (from >= count || to >= count) {
    throw Error(fmt::format("the plan has {} planes, so none can move from place {} to {}", count, from + 1, to + 1));
  }
  const auto at = [&](std::size_t i) { return plan.planes.begin() + static_cast<std::ptrdiff_t>(i); };
  if (from < to) {
    std::rotate(at(from), at(from + 1), at(to + 1));
  } else {
    std::rotate(at(to), at(from), at(from + 1));
  }
}

std::vector<PlaneHandle> PlaneHandles(const PlannedPlane& plane, double arrow_mm) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Vec3& p = plane.plane.p_W;
  std::vector<PlaneHandle> handles{
      {.kind = PlaneHandleKind::kCentre, .p_W = p},
      {.kind = PlaneHandleKind::kNormal, .p_W = p + arrow_mm * axes.normal_W},
      {.kind = PlaneHandleKind::kTiltAcross, .p_W = p + 0.5 * plane.height_mm * axes.up_W},
      {.kind = PlaneHandleKind::kTiltUp, .p_W = p + 0.5 * plane.width_mm * axes.across_W},
  };
  const std::array<Vec3, 4> corners = CalcPlaneCorners(plane);
  for (int i = 0; i < 4; ++i) {
    handles.push_back({.kind = PlaneHandleKind::kCorner, .corner = i, .p_W = corners[static_cast<std::size_t>(i)]});
  }
  return handles;
}

PlannedPlane DragHandle(const PlannedPlane& plane, const PlaneHandle& handle, const SightLine& from,
                        const SightLine& to) {
  const PlaneAxes axes = CalcPlaneAxes(plane);
  const Vec3& p = plane.plane.p_W;
  if (handle.kind == PlaneHandleKind::kCentre || handle.kind == PlaneHandleKind::kCorner) {
    const std::optional<Vec3> a = FindCrossing(from, p, axes.normal_W);
    const std::optional<Vec3> b = FindCrossing(to, p, axes.normal_W);
    if (!a || !b) return plane;
    const double across = glm::dot(*b - *a, axes.across_W);
    const double up = glm::dot(*b - *a, axes.up_W);
    if (handle.kind == PlaneHandleKind::kCentre) return MovePlane(plane, {across, up, 0});
    const double right = handle.corner == 1 || handle.corner == 2 ? 1 : -1;
    const double upper = handle.corner >= 2 ? 1 : -1;
    PlannedPlane sized = plane;
    sized.width_mm = kPlaneSizeRange_mm.Clamp(plane.width_mm + right * across);
    sized.height_mm = kPlaneSizeRange_mm.Clamp(plane.height_mm + upper * up);
    return MovePlane(
        sized, {0.5 * right * (sized.width_mm - plane.width_mm), 0.5 * upper * (sized.height_mm - plane.height_mm), 0});
  }
  const std::optional<double> a = FindNearestOnAxis(from, handle.p_W, axes.normal_W);
  const std::optional<double> b = FindNearestOnAxis(to, handle.p_W, axes.normal_W);
  if (!a || !b) return plane;
  switch (handle.kind) {
    case PlaneHandleKind::kTiltAcross:
      return TiltPlane(plane, CalcTilt_deg(*a, *b, 0.5 * plane.height_mm), 0);
    case PlaneHandleKind::kTiltUp:
      return TiltPlane(plane, 0, -CalcTilt_deg(*a, *b, 0.5 * plane.width_mm));
    default:
      return MovePlane(plane, {0, 0, *b - *a});
  }
}

}  // namespace kerf
