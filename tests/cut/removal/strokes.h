// Strokes of a tool through a block, for tests of the cutter.
#pragma once

#include <numbers>
#include <random>
#include <vector>

#include "cut/removal/cutter.h"
#include "cut/tool/shape.h"
#include "support/cuts.h"
#include "support/solids.h"

namespace kerf::test {

/// One step of a tool; `lifted` means that the tool was set down at the step's start.
struct Step {
  Pose X_from;
  Pose X_to;
  bool lifted = false;
};

/// Splits strokes into steps as the simulation does.
inline std::vector<Step> MakeSteps(const std::vector<Pose>& poses, const Tool& tool, double voxel_mm) {
  std::vector<Step> steps;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double count = CountSubsteps(poses[i - 1], poses[i], tool, voxel_mm);
    Pose X_a = poses[i - 1];
    for (double k = 1; k <= count; ++k) {
      const Pose X_b = k == count ? poses[i] : Interpolate(poses[i - 1], poses[i], k / count);
      steps.push_back({X_a, X_b, i == 1 && k == 1});
      X_a = X_b;
    }
  }
  return steps;
}

/// Makes all cuts and returns the sum of their results; not valid if leaves may run out.
inline double CutAll(Cutter& cutter, const std::vector<Step>& steps) {
  double removed_mm3 = 0;
  for (const Step& step : steps) {
    if (step.lifted) cutter.Lift();
    removed_mm3 += cutter.Cut(step.X_from, step.X_to).removed_mm3;
  }
  return removed_mm3;
}

inline Vec3 DrawVector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random);
  const double y = normal(random);
  return {x, y, normal(random)};
}

inline Quat DrawRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double w = normal(random);
  const Vec3 v = DrawVector(random);
  return glm::normalize(Quat(w, v.x, v.y, v.z));
}

/// Kind of motion of a random stroke.
enum class StrokeKind {
  kInPlane,  // a disc stays in its plane; same as kFree for a ball
  kFree,     // the tool also slides along the spindle and tilts
};

/// Makes `count` random strokes of a tool about the origin, of `ticks` ticks each: started inside or outside of bone,
/// with turns, stops and reversals.
inline std::vector<Step> DrawSteps(std::mt19937& random, const Tool& tool, StrokeKind kind, double voxel_mm, int count,
                                   int ticks) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const bool is_disc = std::holds_alternative<DiscSaw>(tool);
  std::vector<Step> steps;
  for (int n = 0; n < count; ++n) {
    Pose X;
    X.R_AB = DrawRotation(random);
    // The edge is somewhere near the middle of the block.
    const double angle = 2 * std::numbers::pi * uniform(random);
    const Vec3 edge_T = is_disc ? Vec3(std::cos(angle), std::sin(angle), 0) : glm::normalize(DrawVector(random));
    const bool is_bur = GetForm(tool) == ToolForm::kRound;
    X.p_AB = DrawVector(random) - X.Vector(is_bur ? FindDeepest(tool, edge_T) : CalcReach(tool) * edge_T);
    std::vector<Pose> poses = {X};
    Vec3 v_T = glm::normalize(DrawVector(random)) * 0.8 * uniform(random) * voxel_mm;
    for (int i = 0; i < ticks; ++i) {
      if (uniform(random) < 0.1) v_T = glm::normalize(DrawVector(random)) * 0.8 * uniform(random) * voxel_mm;
      if (uniform(random) < 0.05) v_T = Vec3(0);
      if (is_disc) v_T.z *= kind == StrokeKind::kInPlane ? 0 : 0.1;
      X.p_AB += X.Vector(v_T);
      if (kind == StrokeKind::kFree) {
        X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(0.002 * uniform(random), glm::normalize(DrawVector(random))));
      }
      poses.push_back(X);
    }
    for (const Step& step : MakeSteps(poses, tool, voxel_mm)) steps.push_back(step);
  }
  return steps;
}

inline FissureBur DrawBur(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  FissureBur bur;
  bur.diameter_mm = 0.5 + 3 * uniform(random);
  bur.length_mm = (1.2 + 4 * uniform(random)) * bur.diameter_mm;
  bur.taper = uniform(random) < 0.5 ? 1 : 0.3 + 0.7 * uniform(random);
  bur.point_angle_deg = uniform(random) < 0.3 ? 180 : 60 + 120 * uniform(random);
  return bur;
}

/// Returns a random disc, ball or bur; discs are from thinner than a voxel to thick.
inline Tool DrawTool(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  if (uniform(random) < 0.4) return DrawBur(random);
  if (uniform(random) < 0.4) {
    BallBurr ball;
    ball.diameter_mm = 1 + 5 * uniform(random);
    return ball;
  }
  DiscSaw disc;
  disc.diameter_mm = 3 + 19 * uniform(random);
  disc.thickness_mm = 0.1 + 1.2 * uniform(random) * uniform(random);
  return disc;
}

}  // namespace kerf::test
