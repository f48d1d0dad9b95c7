#include "session/plan/assess.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "session/plan/division.h"
#include "session/plan/lost_voxels.h"

namespace kerf {
namespace {

constexpr double kInPlane = 0.35;      // sine of the maximum angle between a stop's direction and its plane
constexpr double kStopReach_mm = 10;   // maximum distance of a stop's point from its plane
constexpr double kRounding_mm = 1e-6;  // the bone's distances are floats, which have steps of 1e-7 mm at 1 mm

double OffPlane(const CutPlane& plane, const Vec3& p) {
  return glm::dot(plane.normal_W, p - plane.p_W);
}

/// Returns the index of the plane that contains a stop, or -1.
int FindPlaneOf(const Plan& plan, const DepthStop& stop) {
  int best = -1;
  double least = kStopReach_mm;
  for (std::size_t i = 0; i < plan.planes.size(); ++i) {
    const CutPlane& plane = plan.planes[i].plane;
    const double off = std::abs(OffPlane(plane, stop.p_W_mm));
    if (std::abs(glm::dot(plane.normal_W, stop.direction_W)) > kInPlane || off >= least) continue;
    best = static_cast<int>(i);
    least = off;
  }
  return best;
}

PlaneResult AssessPlane(const Plan& plan, const PlaneDivision& division, std::size_t i, const Bone& before,
                        const Bone& after, const AssessOptions& options) {
  PlaneResult result;
  result.planned = plan.planes[i];
  const CutPlane& planned = result.planned.plane;
  KerfSearch search;
  search.near = planned;
  search.reach_mm = std::max(options.reach_mm, 2 * result.planned.margin_mm);
  search.max_tilt_deg = options.max_tilt_deg;
  search.belongs = [&](const Vec3& p_W) { return division.Find(p_W) == static_cast<int>(i); };
  result.reach_mm = search.reach_mm;
  result.cut = FitKerf(before, after, search, &result.no_kerf);
  if (!result.cut) return result;
  const FittedPlane& cut = *result.cut;
  result.offset_mm = OffPlane(planned, cut.p_W_mm);
  const Vec3 across = glm::cross(cut.normal_W, cut.depth_W);
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 p = cut.p_W_mm + (corner & 1 ? 0.5 : -0.5) * cut.depth_mm * cut.depth_W +
                   (corner & 2 ? 0.5 : -0.5) * cut.length_mm * across;
    const double off = OffPlane(planned, p);
    if (std::abs(off) > std::abs(result.furthest_mm)) result.furthest_mm = off;
  }
  Vec3 depth_W = cut.depth_W;
  for (const DepthStop& stop : plan.stops) {
    if (FindPlaneOf(plan, stop) == static_cast<int>(i)) depth_W = stop.direction_W;
  }
  result.angles = CalcPlaneAngles(planned.normal_W, cut.normal_W, depth_W);
  result.within_margin = std::abs(result.furthest_mm) <= result.planned.margin_mm + kRounding_mm;
  return result;
}

/// Returns the last place on a line through a cell, within two voxels on either side, where the line enters the bone
/// (`into`) or leaves it; mm along the direction from the cell.
std::optional<double> FindCrossing(const Bone& bone, const Vec3& from, const Vec3& direction_W, double h, bool into) {
  constexpr double kSteps = 8;  // per voxel
  std::optional<double> crossing_mm;
  double last = bone.SignedDistance(from - 2 * h * direction_W);
  for (int k = 1; k <= static_cast<int>(4 * kSteps); ++k) {
    const double distance_mm = -2 * h + k * h / kSteps;
    const double phi = bone.SignedDistance(from + distance_mm * direction_W);
    if (into ? last >= 0 && phi < 0 : last < 0 && phi >= 0) crossing_mm = distance_mm - h / kSteps * phi / (phi - last);
    last = phi;
  }
  return crossing_mm;
}

}  // namespace

Assessment AssessCut(const Plan& plan, const Bone& before, const Bone& after, double blade_mm,
                     const AssessOptions& options) {
  CheckPlan(plan);
  Assessment out;
  out.before_mm3 = before.CalcVolume();
  out.after_mm3 = after.CalcVolume();
  out.removed_mm3 = out.before_mm3 - out.after_mm3;
  const PlaneDivision division(plan.planes);
  for (std::size_t i = 0; i < plan.planes.size(); ++i) {
    out.planes.push_back(AssessPlane(plan, division, i, before, after, options));
  }
  const Loss loss = FindLoss(before, after, {}, nullptr);
  const double h = before.voxel_mm();
  std::vector<int> plane_of_stop;
  for (const DepthStop& stop : plan.stops) {
    out.stops.push_back({.planned = stop, .depth_mm = {}, .over_mm = 0});
    plane_of_stop.push_back(FindPlaneOf(plan, stop));
  }
  if (!plan.planes.empty()) out.outside_mm3 = 0;
  if (!plan.stops.empty()) out.too_deep_mm3 = 0;
  std::vector<double> deepest(plan.stops.size(), 0);
  for (const LostCell& cell : loss.cells) {
    const int nearest = division.Find(cell.p_W);
    bool outside = nearest >= 0;
    for (const PlannedPlane& p : plan.planes) {
      outside = outside && std::abs(OffPlane(p.plane, cell.p_W)) > p.margin_mm + 0.5 * blade_mm;
    }
    if (outside) *out.outside_mm3 += cell.mm3;
    bool too_deep = false;
    for (std::size_t i = 0; i < plan.stops.size(); ++i) {
      if (plane_of_stop[i] >= 0 && plane_of_stop[i] != nearest) continue;
      const double depth = glm::dot(plan.stops[i].direction_W, cell.p_W - plan.stops[i].p_W_mm);
      too_deep = too_deep || depth > plan.stops[i].depth_mm;
      if (cell.mm3 > 0.25 * h * h * h * std::min(1.0, blade_mm / h)) deepest[i] = std::max(deepest[i], depth);
    }
    if (too_deep) *out.too_deep_mm3 += cell.mm3;
  }
  // Measure from the deepest cells on to the point where the remaining bone begins.
  for (std::size_t i = 0; i < plan.stops.size(); ++i) {
    if (!(deepest[i] > 0)) continue;
    StopResult& stop = out.stops[i];
    const Vec3& d = stop.planned.direction_W;
    double depth_mm = 0;
    for (const LostCell& cell : loss.cells) {
      if (plane_of_stop[i] >= 0 && plane_of_stop[i] != division.Find(cell.p_W)) continue;
      const double depth = glm::dot(d, cell.p_W - stop.planned.p_W_mm);
      if (depth < deepest[i] - 1.5 * h || cell.mm3 <= 0) continue;
      const std::optional<double> end = FindCrossing(after, cell.p_W, d, h, true);
      // The kerf's edges are rounded near the bone's surface.
      if (end && before.SignedDistance(cell.p_W + *end * d) < -h) depth_mm = std::max(depth_mm, depth + *end);
      // If the cut goes through, there is no bone behind it: the depth ends where the bone ended.
      const std::optional<double> bone_end = FindCrossing(before, cell.p_W, d, h, false);
      if (bone_end && after.SignedDistance(cell.p_W + (*bone_end - 0.5 * h) * d) > 0) {
        depth_mm = std::max(depth_mm, depth + *bone_end);
      }
    }
    if (depth_mm == 0) depth_mm = deepest[i];
    stop.depth_mm = depth_mm;
    stop.over_mm = depth_mm - stop.planned.depth_mm;
  }
  return out;
}

std::string DescribeNoKerf(const PlaneResult& result) {
  const NoKerf& why = result.no_kerf;
  if (!(why.removed_mm3 > 0)) return fmt::format("no bone was removed within {:g} mm of it", result.reach_mm);
  const std::string removed =
      fmt::format("{:.2f} mm3 were removed within {:g} mm of it", why.removed_mm3, result.reach_mm);
  const auto& [length_mm, second_mm, third_mm] = why.extents_mm;
  if (!(third_mm > 0)) return removed + ", in too few voxels for a plane";
  const std::string extents =
      fmt::format("{}, about {:.1f} x {:.1f} x {:.1f} mm", removed, length_mm, second_mm, third_mm);
  if (second_mm >= why.least_second_mm) return extents + ", too uneven for a plane";
  return fmt::format("{}; for a plane, the second must be at least {:.1f} mm", extents, why.least_second_mm);
}

std::vector<PlaneMarkup> MakeCutMarkups(const Assessment& assessment) {
  std::vector<PlaneMarkup> markups;
  for (const PlaneResult& result : assessment.planes) {
    if (!result.cut) continue;
    markups.push_back({.name = result.planned.name + kAsCut, .plane = {result.cut->p_W_mm, result.cut->normal_W}});
  }
  return markups;
}

}  // namespace kerf
