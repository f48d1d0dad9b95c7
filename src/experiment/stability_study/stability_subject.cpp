#include "experiment/stability_study/stability_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "bone/grid/crop.h"
#include "cut/contact/probe.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

/// The tool is moved back by this distance from the contact.
constexpr double kClear_mm = 0.3;
constexpr double kMaxClear_mm = 0.8;
/// Bone within this distance of the tool is kept.
constexpr double kAround_mm = 15;
/// If the component of a disc's motion along its spindle exceeds this fraction of the motion, the disc touches the bone
/// with its flat.
constexpr double kSideways = 0.7;
constexpr double kShortest_s = 1e-7;

/// Returns points on the whole surface of the tool, tool frame.
std::vector<Vec3> CoverTool(const Tool& tool, double spacing_mm) {
  const double pitch_mm = CalcTooth(tool).pitch_mm;
  const int samples = std::clamp(static_cast<int>(std::ceil(pitch_mm / spacing_mm)), 1, 64);
  const ToolShape shape = MakeToolShape(tool, {samples, spacing_mm, 0, 0});
  std::vector<Vec3> points;
  // The rim of a blade is covered in layers from one flat to the other, since bone may be thinner than the blade.
  const double thickness_mm = CalcThickness(tool);
  const int layers = IsBlade(tool) ? std::max(2, static_cast<int>(std::ceil(thickness_mm / spacing_mm)) + 1) : 1;
  for (const EdgePoint& point : shape.edge) {
    for (int i = 0; i < layers; ++i) {
      const double z_mm = layers > 1 ? thickness_mm * (static_cast<double>(i) / (layers - 1) - 0.5) : 0;
      points.push_back(point.p_T + Vec3(0, 0, z_mm));
    }
  }
  for (const FacePoint& point : shape.faces) points.push_back(point.p_T);
  return points;
}

class Feeler {
 public:
  Feeler(const Tool& tool, const Bone& bone)
      : bone_(bone),
        points_(CoverTool(tool, 2 * bone.voxel_mm())),
        bounds_(bone.CalcBounds()),
        reach_mm_(CalcReach(tool)) {}

  /// Returns the minimum distance of the tool to the bone, mm, limited to the band.
  double Distance(const Pose& X_WT) const {
    const Box3 near = bounds_.Grown(reach_mm_ + bone_.band_mm());
    for (int axis = 0; axis < 3; ++axis) {
      if (X_WT.p_AB[axis] < near.lower[axis] || X_WT.p_AB[axis] > near.upper[axis]) return bone_.band_mm();
    }
    double least = bone_.band_mm();
    for (const Vec3& p_T : points_) least = std::min(least, bone_.SignedDistance(X_WT.Point(p_T)));
    return least;
  }
  double reach_mm() const { return reach_mm_; }

 private:
  const Bone& bone_;
  std::vector<Vec3> points_;
  Box3 bounds_;
  double reach_mm_;
};

/// Returns the pose shortly before the tool touches at X_WT_touch, moving from X_WT_clear.
FirstTouch StepBack(const Scene& scene, const Tool& tool, const Feeler& feeler, double voxel_mm, double time_s,
                    const Pose& X_WT_clear, const Pose& X_WT_touch) {
  const std::optional<Vec3> into = CalcDirection(X_WT_touch.p_AB - X_WT_clear.p_AB);
  if (!into) {
    throw Error(fmt::format("{}: the tool only rotates where it touches the bone, at {:.3f} s of the path; add a feed",
                            scene.name, time_s));
  }
  const Vec3 spindle_W = X_WT_touch.Vector({0, 0, 1});
  if (IsBlade(tool) && std::abs(glm::dot(spindle_W, *into)) > kSideways) {
    throw Error(
        fmt::format("{}: the disc touches the bone with its flat, at {:.3f} s of the path, where no tooth cuts; "
                    "begin with a stroke in the disc's plane",
                    scene.name, time_s));
  }
  FirstTouch touch{time_s, X_WT_clear, *into};
  // Finds the contact by bisection, then moves back.
  double inside = 1;
  double outside = 0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (inside + outside);
    Pose X_WT = X_WT_touch;
    X_WT.p_AB = glm::mix(X_WT_clear.p_AB, X_WT_touch.p_AB, middle);
    (feeler.Distance(X_WT) > 0 ? outside : inside) = middle;
  }
  const double back_mm = std::min(kClear_mm + 0.25 * voxel_mm, kMaxClear_mm);
  touch.X_WT.R_AB = X_WT_touch.R_AB;
  touch.X_WT.p_AB = glm::mix(X_WT_clear.p_AB, X_WT_touch.p_AB, outside) - back_mm * *into;
  if (!(feeler.Distance(touch.X_WT) > 0)) {
    throw Error(
        fmt::format("{}: the tool is in the bone both before and after the contact at {:.3f} s of the path; "
                    "begin the path clear of the bone",
                    scene.name, time_s));
  }
  return touch;
}

}  // namespace

FirstTouch FindFirstTouch(const Scene& scene, const Bone& bone) {
  const Path path = MakePath(scene);
  const Tool tool = MakeTool(scene);
  const Feeler feeler(tool, bone);
  const double voxel_mm = bone.voxel_mm();
  for (std::size_t segment = 0; segment < path.segments().size(); ++segment) {
    const PathSegment& span = path.segments()[segment];
    double t_s = span.start_s;
    Pose X_WT = path.CalcPose(segment, t_s);
    // A tool that only touches the bone does not count as being inside.
    if (span.retract_before && feeler.Distance(X_WT) < -0.5 * voxel_mm) {
      throw Error(
          fmt::format("{}: the path begins inside the bone, at {:.3f} s; begin it clear of the bone", scene.name, t_s));
    }
    double step_s = 1e-3;
    while (t_s < span.end_s) {
      step_s = std::min(2 * step_s, span.end_s - t_s);
      while (step_s > kShortest_s &&
             CalcTravel(X_WT, path.CalcPose(segment, t_s + step_s), feeler.reach_mm()) > voxel_mm) {
        step_s /= 2;
      }
      const Pose X_WT_next = path.CalcPose(segment, t_s + step_s);
      t_s = span.end_s - t_s - step_s < kShortest_s ? span.end_s : t_s + step_s;
      if (!(feeler.Distance(X_WT_next) > 0)) {
        // A tool that moves out of a contact has not touched the bone again.
        if (feeler.Distance(X_WT_next) < feeler.Distance(X_WT) || feeler.Distance(X_WT) > 0) {
          return StepBack(scene, tool, feeler, voxel_mm, t_s, X_WT, X_WT_next);
        }
      }
      X_WT = X_WT_next;
    }
  }
  throw Error(fmt::format("{}: the path never touches the bone, so there is nothing to examine", scene.name));
}

StabilitySubject MakeStabilitySubject(const Scene& scene, const LoopSetup& setup, const Bone& bone,
                                      const FirstTouch& touch) {
  StabilitySubject subject;
  const double around_mm = CalcReach(MakeTool(scene)) + kAround_mm;
  subject.bone = CropBone(bone, Box3{touch.X_WT.p_AB, touch.X_WT.p_AB}.Grown(around_mm));
  subject.setup.coupled = MakeCoupledParams(scene);
  subject.setup.coupled.coupling = setup.fitted.coupling;
  subject.setup.profile = setup.profile;
  subject.setup.hand = setup.hand;
  subject.setup.force_map = setup.force_map;
  subject.setup.period_s = 1 / scene.loop.rate_hz;
  subject.setup.watchdog_ms = scene.loop.watchdog_ms;
  subject.X_WT_start = touch.X_WT;
  subject.into_W = touch.into_W;
  subject.rpm = scene.tool.CalcTickRpm();
  return subject;
}

}  // namespace kerf
