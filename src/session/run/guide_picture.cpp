#include "session/run/guide_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "kerf/surface.h"
#include "view/picture/picture.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr Rgb8 kPlanColour{0, 158, 115};
constexpr Rgb8 kStopColour{213, 94, 0};
constexpr Rgb8 kPathColour{0, 70, 160};
constexpr double kPathHalf_mm = 0.25;
constexpr double kStopHalf_mm = 0.3;
constexpr std::size_t kMaxPoints = 1200;

/// Adds a box with the centre `middle`; `a`, `b` and `c` are its half edges.
void AddBox(TriangleMesh& mesh, const Vec3& middle, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (int i = 0; i < 8; ++i) {
    mesh.points.push_back(middle + ((i & 1) != 0 ? a : -a) + ((i & 2) != 0 ? b : -b) + ((i & 4) != 0 ? c : -c));
  }
  constexpr std::uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                          {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({first + f[0], first + f[1], first + f[2]});
    mesh.triangles.push_back({first + f[0], first + f[2], first + f[3]});
  }
}

}  // namespace

GuideTrack::GuideTrack(const EffectPlan& plan, std::size_t ticks) {
  const auto* guide = dynamic_cast<const GuideEffect*>(plan.Find("guide"));
  if (guide == nullptr) return;
  guide_ = guide->params();
  moments_.Reserve(ticks);
  for (const EffectPlan::Entry& entry : plan.entries()) {
    if (std::string_view(entry.info->name) != "guide") continue;
    for (std::size_t i = 0; i < entry.info->channels.size(); ++i) {
      const std::string_view channel = entry.info->channels[i].name;
      if (channel == "deviation_mm") deviation_ = entry.first_channel + i;
      if (channel == "force_N") force_ = entry.first_channel + i;
    }
  }
}

void GuideTrack::Take(double time_s, const Vec3& p_WT_mm, std::span<const double> channels) {
  if (!guide_) return;
  moments_.Add({static_cast<float>(time_s), static_cast<float>(channels[deviation_]),
                static_cast<float>(channels[force_]), p_WT_mm});
}

void WriteGuidePicture(const GuideTrack& track, const Bone& bone, const Tool& tool, bool patient,
                       const std::string& name, const std::string& path) {
  const GuideParams& guide = track.guide().value();
  const Vec3 n = glm::normalize(guide.normal_W);
  Vec3 deep = guide.depth_direction_W - glm::dot(guide.depth_direction_W, n) * n;
  deep = glm::normalize(deep);
  const Vec3 along = glm::cross(n, deep);
  const double reach_mm = CalcReach(tool);

  // Draw the part of the plane within the tool's reach along its path, and the stops.
  double a0 = -reach_mm, a1 = reach_mm, d0 = -reach_mm, d1 = guide.depth_mm;
  for (const GuideTrack::Moment& moment : track.moments()) {
    const Vec3 p = moment.p_WT_mm - guide.point_W_mm;
    a0 = std::min(a0, glm::dot(p, along) - reach_mm), a1 = std::max(a1, glm::dot(p, along) + reach_mm);
    d0 = std::min(d0, glm::dot(p, deep)), d1 = std::max(d1, glm::dot(p, deep) + reach_mm);
  }
  const Vec3 middle = guide.point_W_mm + 0.5 * (a0 + a1) * along + 0.5 * (d0 + d1) * deep;
  const Vec3 half_along = 0.5 * (a1 - a0) * along, half_deep = 0.5 * (d1 - d0) * deep;

  PictureSpec spec;
  spec.title = name + ": the guide";
  spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
  Shape bone_shape;
  bone_shape.mesh_W = ExtractSurface(bone);
  spec.shapes.push_back(std::move(bone_shape));

  Shape plane;
  AddBox(plane.mesh_W, middle, std::max(guide.tolerance_mm, 0.02) * n, half_along, half_deep);
  plane.colour = kPlanColour;
  plane.opacity = 0.35;
  spec.shapes.push_back(plane);
  spec.legend.push_back({fmt::format("planned plane, ±{:g} mm", guide.tolerance_mm), kPlanColour});

  const Vec3 across = (guide.tolerance_mm + kStopHalf_mm) * n;
  Shape stops;
  stops.colour = kStopColour;
  if (guide.depth_mm > 0) {
    AddBox(stops.mesh_W, guide.point_W_mm + guide.depth_mm * deep + 0.5 * (a0 + a1) * along, across, half_along,
           kStopHalf_mm * deep);
  }
  if (guide.slot_length_mm > 0) {
    for (const double side : {-0.5, 0.5}) {
      AddBox(stops.mesh_W, guide.point_W_mm + side * guide.slot_length_mm * along + 0.5 * (d0 + d1) * deep, across,
             kStopHalf_mm * along, half_deep);
    }
  }
  if (!stops.mesh_W.points.empty()) spec.shapes.push_back(stops);
  if (guide.depth_mm > 0) spec.legend.push_back({fmt::format("depth stop, {:g} mm", guide.depth_mm), kStopColour});
  if (guide.slot_length_mm > 0) {
    spec.legend.push_back({fmt::format("slot ends, {:g} mm", guide.slot_length_mm), kStopColour});
  }

  Shape tool_path;
  tool_path.colour = kPathColour;
  const std::size_t stride = track.moments().size() / kMaxPoints + 1;
  std::optional<Vec3> before;
  for (std::size_t i = 0; i < track.moments().size(); i += stride) {
    const Vec3 p = track.moments()[i].p_WT_mm;
    if (before && glm::length(p - *before) < kPathHalf_mm) continue;
    if (before) {
      const Vec3 step = p - *before;
      Vec3 side = glm::cross(step, n);
      side = glm::length(side) > 1e-6 * glm::length(step) ? glm::normalize(side) : along;
      AddBox(tool_path.mesh_W, 0.5 * (p + *before), 0.5 * step, kPathHalf_mm * side,
             kPathHalf_mm * glm::normalize(glm::cross(side, step)));
    }
    before = p;
  }
  if (!tool_path.mesh_W.points.empty()) {
    spec.shapes.push_back(tool_path);
    spec.legend.push_back({"tool's centre", kPathColour});
  }
  double worst_mm = 0;
  for (const GuideTrack::Moment& m : track.moments())
    worst_mm = std::max(worst_mm, static_cast<double>(m.deviation_mm));
  spec.caption = fmt::format(
      "bone after the cut; rim at most {2:.2f} mm off the plane;\n{0:g} N/mm beyond the tolerance, up to {1:g} N; the "
      "slot ends limit the tool's centre",
      guide.stiffness_N_per_mm, guide.max_force_N, worst_mm);
  // Oblique view of the plane from above.
  Vec3 eye = 0.55 * n - 0.45 * deep + 0.7 * along;
  if (eye.y > 0) eye = -0.55 * n - 0.45 * deep - 0.7 * along;
  const Vec3 up = std::abs(glm::dot(glm::normalize(eye), deep)) < 0.9 ? -deep : along;
  spec.camera = MakeCamera(eye, up, middle, 1.35 * std::max(a1 - a0, d1 - d0));
  WritePicture(spec, path);
}

void WriteDeviationPlot(const GuideTrack& track, const std::string& name, const std::string& path) {
  const GuideParams& guide = track.guide().value();
  PlotSpec plot;
  plot.title = name + ": distance from the plan";
  plot.caption = fmt::format("distance of the rim's furthest point from the planned plane; free up to {:g} mm",
                             guide.tolerance_mm);
  plot.x.label = "time (s)";
  plot.y.label = "distance (mm)";
  plot.y.lower = 0;
  plot.y_right.label = "force of the guide (N)";
  plot.y_right.lower = 0;
  PlotSeries distance, force, tolerance;
  distance.label = "distance";
  tolerance.label = "tolerance";
  tolerance.dash = 6;
  tolerance.colour = Rgb8{120, 120, 120};
  force.label = "force of the guide";
  force.right_axis = true;
  force.width = 1;
  // Plot at most one point per pixel, the maximum of each interval, so that no short event is lost.
  const std::size_t stride = track.moments().size() / kMaxPoints + 1;
  for (std::size_t i = 0; i < track.moments().size(); i += stride) {
    float mm = 0, N = 0;
    for (std::size_t k = i; k < std::min(i + stride, track.moments().size()); ++k) {
      mm = std::max(mm, track.moments()[k].deviation_mm);
      N = std::max(N, track.moments()[k].force_N);
    }
    const double t = static_cast<double>(track.moments()[i].time_s);
    distance.x.push_back(t), distance.y.push_back(static_cast<double>(mm));
    force.x.push_back(t), force.y.push_back(static_cast<double>(N));
    tolerance.x.push_back(t), tolerance.y.push_back(guide.tolerance_mm);
  }
  plot.series = {distance, tolerance, force};
  WritePlot(plot, path);
}

}  // namespace kerf
