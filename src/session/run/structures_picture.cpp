#include "session/run/structures_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>
#include <variant>

#include "cut/effects/structures.h"
#include "kerf/surface.h"
#include "view/picture/picture.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

// After Okabe and Ito (2008), distinguishable with red-green colour blindness.
constexpr Rgb8 kStructureColour{213, 94, 0};
constexpr Rgb8 kDistanceColour{0, 114, 178};
constexpr Rgb8 kMarginColour{120, 120, 120};
constexpr Rgb8 kBreachBand{246, 206, 180};
constexpr Rgb8 kArrowColour{0, 90, 60};
constexpr std::size_t kMaxHistoryPoints = 1200;
constexpr int kPictureRows = 720, kPlotRows = 440;
constexpr double kMinArrow_mm = 0.5;

Image RenderScene(const StructuresTrack& track, const Bone& bone, const Tool& tool, bool patient,
                  const std::string& name) {
  const StructuresTrack::Closest& closest = track.closest().value();
  const bool breach = track.moments().back().breach_mm3 > 0;
  PictureSpec spec;
  spec.height = kPictureRows;
  spec.title = name + ": structures";
  spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
  Shape bone_shape;
  bone_shape.mesh_W = ExtractSurface(bone);
  bone_shape.opacity = 0.3;
  spec.shapes.push_back(std::move(bone_shape));
  Shape structure;
  structure.mesh_W = track.surface_W();
  structure.colour = kStructureColour;
  spec.shapes.push_back(std::move(structure));
  spec.legend.push_back({"structure", kStructureColour});
  spec.legend.push_back({"bone after the cut", kBoneColour});
  spec.tools.push_back({tool, closest.X_WT, 0.85});

  Vec3 p_structure_W(0), p_tool_W(0);
  double smallest = 1e300;
  for (const Vec3& p : track.surface_W().points) {
    const Vec3 q = closest.X_WT.Point(FindNearestOfTool(tool, closest.X_WT.InversePoint(p)));
    if (glm::length(p - q) >= smallest) continue;
    smallest = glm::length(p - q);
    p_structure_W = p;
    p_tool_W = q;
  }
  if (smallest >= kMinArrow_mm) {
    spec.arrows.push_back({p_tool_W, p_structure_W, kArrowColour, fmt::format("{:.1f} mm", closest.distance_mm)});
  }
  if (breach) {
    spec.caption = fmt::format("blade at its greatest depth, at {:.2f} s; up to {:.2f} mm deep, with {:.2g} N",
                               closest.time_s, closest.depth_mm, closest.force_N);
  } else if (closest.distance_mm >= StructuresEffect::kLook_mm) {
    spec.caption = fmt::format("blade never closer than {:g} mm", StructuresEffect::kLook_mm);
  } else {
    spec.caption =
        fmt::format("blade at its closest, {:.2f} mm away, at {:.2f} s", closest.distance_mm, closest.time_s);
  }

  // Oblique view of the blade from outside the bone, slightly from above.
  const Vec3 normal = closest.X_WT.Vector({0, 0, 1});
  Vec3 outward = p_structure_W - bone.CalcBounds().centre();
  outward.z = 0;
  outward -= glm::dot(outward, normal) * normal;
  outward.z = 0;
  outward = glm::length(outward) > 1e-6 ? glm::normalize(outward) : Vec3(0, -1, 0);
  const Vec3 eye = outward + (normal.y > 0 ? -0.7 : 0.7) * normal + Vec3(0, 0, 0.3);
  const Vec3 up = std::abs(glm::normalize(eye).z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
  spec.camera = MakeCamera(eye, up, 0.5 * (p_structure_W + closest.X_WT.p_AB), std::max(30.0, 4 * CalcReach(tool)));
  return RenderPicture(spec);
}

Image RenderDistance(const StructuresTrack& track) {
  const std::vector<StructuresTrack::Moment>& moments = track.moments();
  PlotSpec plot;
  plot.height = kPlotRows;
  const double breach_mm3 = static_cast<double>(moments.back().breach_mm3);
  plot.title = "Distance of the blade from the structure";
  plot.caption = breach_mm3 > 0 ? fmt::format("breach: {:.3g} mm³ of it cut", breach_mm3) : std::string("no breach");
  plot.caption += fmt::format("; not measured beyond {:g} mm", StructuresEffect::kLook_mm);
  plot.x.label = "time (s)";
  plot.y.label = "distance (mm)";
  plot.y.lower = 0;
  PlotSeries distance, margin, volume;
  distance.label = "distance";
  distance.colour = kDistanceColour;
  margin.label = fmt::format("warning below {:g} mm", track.warn_mm());
  margin.colour = kMarginColour;
  margin.dash = 6;
  volume.label = "volume cut so far";
  volume.colour = kStructureColour;
  volume.right_axis = true;
  // Plot at most one point per pixel, the minimum distance of each interval, so that no short event is lost.
  const std::size_t stride = moments.size() / kMaxHistoryPoints + 1;
  double before_mm3 = 0;
  for (std::size_t i = 0; i < moments.size(); i += stride) {
    const std::size_t end = std::min(i + stride, moments.size());
    float mm = moments[i].distance_mm;
    for (std::size_t k = i; k < end; ++k) mm = std::min(mm, moments[k].distance_mm);
    const auto t = static_cast<double>(moments[i].time_s);
    const auto mm3 = static_cast<double>(moments[end - 1].breach_mm3);
    distance.x.push_back(t), distance.y.push_back(static_cast<double>(mm));
    margin.x.push_back(t), margin.y.push_back(track.warn_mm());
    volume.x.push_back(t), volume.y.push_back(mm3);
    if (mm3 > before_mm3) {
      const auto until = static_cast<double>(moments[std::min(end, moments.size() - 1)].time_s);
      // Bites with only a short gap between them belong to the same breach.
      if (!plot.bands.empty() && t - plot.bands.back().x1 < 0.1) {
        plot.bands.back().x1 = until;
      } else {
        plot.bands.push_back({t, until, "breach", kBreachBand});
      }
    }
    before_mm3 = mm3;
  }
  plot.series = {distance, margin};
  if (breach_mm3 > 0) {
    plot.y_right.label = "volume cut (mm³)";
    plot.y_right.lower = 0;
    plot.series.push_back(volume);
  }
  return RenderPlot(plot);
}

}  // namespace

StructuresTrack::StructuresTrack(const EffectPlan& plan, std::size_t ticks) {
  const auto* structures = dynamic_cast<const StructuresEffect*>(plan.Find("structures"));
  if (structures == nullptr) return;
  for (const EffectPlan::Entry& entry : plan.entries()) {
    if (std::string_view(entry.info->name) == "structures") first_channel_ = entry.first_channel;
  }
  warn_mm_ = structures->warn_mm();
  surface_W_ = structures->voxels().MakeSurface();
  moments_.Reserve(ticks);
}

void StructuresTrack::Take(double time_s, const Pose& X_WT, std::span<const double> channels) {
  if (!first_channel_) return;
  const auto own = channels.subspan(*first_channel_);
  const double distance_mm = own[0], depth_mm = own[3], force_N = own[4];
  moments_.Add({static_cast<float>(time_s), static_cast<float>(distance_mm), static_cast<float>(own[2])});
  if (!closest_ || distance_mm < closest_->distance_mm || depth_mm > closest_->depth_mm) {
    closest_ = Closest{X_WT, time_s, distance_mm, depth_mm, force_N};
  }
  closest_->force_N = force_N;
}

void WriteStructuresPicture(const StructuresTrack& track, const Bone& bone, const Tool& tool, bool patient,
                            const std::string& name, const std::string& path) {
  Image image = RenderScene(track, bone, tool, patient, name);
  AppendImage(RenderDistance(track), image);
  WritePng(image, path);
}

}  // namespace kerf
