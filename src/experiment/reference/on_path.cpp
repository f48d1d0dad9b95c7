#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "experiment/reference/check.h"
#include "experiment/reference/reference.h"
#include "experiment/reference/rim.h"

namespace kerf {
namespace {

using reference::Piece;

constexpr double kMaxPathStep_mm = 0.1;    // maximum motion in a step, across the spindle
constexpr double kMaxAxialFraction = 0.1;  // maximum motion in a step along the spindle, as a fraction of the thickness

struct Load {
  Vec3 f_T_N{0};
  double thrust_N = 0;
  double teeth = 0;
};

/// Returns the mean force over many tooth passages: wherever the rim moves outwards into bone, there are Z / (2 pi)
/// teeth per radian.
Load CalcLoad(const ReferenceParams& params, const ToothForce& law, const ExactBone& bone, const Pose& X_WT,
              const Vec3& v_T_mm_per_s, std::vector<Piece>& pieces) {
  Load load;
  const double speed = std::hypot(v_T_mm_per_s.x, v_T_mm_per_s.y);
  const double passes_per_s = params.saw.teeth * std::abs(params.rpm) / 60;
  if (!(speed > 0 && passes_per_s > 0)) return load;
  const double feed = std::atan2(v_T_mm_per_s.y, v_T_mm_per_s.x);
  const reference::Circle ahead{params.saw.radius_mm() + params.fineness.look_ahead_mm, 0, true};
  FindPieces(bone, params.saw, X_WT, ahead, feed - 0.5 * std::numbers::pi, feed + 0.5 * std::numbers::pi,
             params.fineness.rim_points, pieces);
  const double teeth_per_rad = params.saw.teeth / (2 * std::numbers::pi);
  for (const Piece& piece : pieces) {
    const double width = piece.to_rad - piece.from_rad;
    load.teeth += teeth_per_rad * width;
    // This is Gauss quadrature with two points.
    for (const double t : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
      const double angle = piece.from_rad + t * width;
      const double bite_mm = speed * std::cos(angle - feed) / passes_per_s;
      const double force = 0.5 * width * teeth_per_rad * law(bite_mm, piece.Cut(angle));
      load.thrust_N += force;
      load.f_T_N -= force * Vec3(std::cos(angle), std::sin(angle), 0);
    }
  }
  return load;
}

}  // namespace

ReferenceRun RunReferenceOnPath(ExactSolid solid, const ReferenceParams& params, const std::vector<Pose>& X_WT,
                                const std::atomic<bool>* stop) {
  reference::Check(params, X_WT);
  const ToothForce law = MakeToothForce(params.law, params.saw);
  ReferenceRun run{{}, ExactBone(std::move(solid), params.saw)};
  const reference::Flux flux(params.saw, std::max(16, params.fineness.rim_points / kFluxFraction),
                             0.5 * params.fineness.flat_spacing_mm, true);
  std::vector<Piece> pieces;
  double removed_mm3 = 0;
  for (std::size_t k = 1; k < X_WT.size(); ++k) {
    reference::StopIf(stop);
    const Pose& X_a = X_WT[k - 1];
    const Pose& X_b = X_WT[k];
    const Vec3 turn_T = reference::TurnBetween(X_a.R_AB, X_b.R_AB);
    const Vec3 way_T = X_a.InverseVector(X_b.p_AB - X_a.p_AB);
    const double axial_mm = std::abs(way_T.z) + params.saw.radius_mm() * std::hypot(turn_T.x, turn_T.y);
    const int steps =
        std::max({params.fineness.steps_per_tick, static_cast<int>(std::ceil(glm::length(way_T) / kMaxPathStep_mm)),
                  static_cast<int>(std::ceil(axial_mm / (kMaxAxialFraction * params.saw.thickness_mm)))});
    const double step_s = params.tick_s / steps;
    ReferenceTick tick;
    tick.X_WT = X_b;
    if (reference::IsSetDown(params, k)) {
      tick.removed_mm3 = removed_mm3;
      run.ticks.push_back(tick);
      continue;
    }
    for (int i = 0; i < steps; ++i) {
      const Pose X_from = reference::Between(X_a, X_b, static_cast<double>(i) / steps);
      const Pose X_to = reference::Between(X_a, X_b, (i + 1.0) / steps);
      // Halfway through the step the rim is as deep in uncut bone as it has moved in half a step.
      const Pose X_middle = reference::Between(X_a, X_b, (i + 0.5) / steps);
      const Vec3 v_T = X_middle.InverseVector(X_b.p_AB - X_a.p_AB) / params.tick_s;
      const Load load = CalcLoad(params, law, run.bone, X_middle, v_T, pieces);
      tick.f_W_N += X_middle.Vector(load.f_T_N) / static_cast<double>(steps);
      tick.thrust_sum_N += load.thrust_N / steps;
      tick.engaged_teeth += load.teeth / steps;
      if (params.rpm == 0) continue;
      removed_mm3 += step_s * flux.Calc(run.bone, X_middle, v_T, turn_T / params.tick_s);
      run.bone.Sweep(X_from, X_to, 0);
    }
    tick.removed_mm3 = removed_mm3;
    run.ticks.push_back(tick);
  }
  reference::SettleRemoved(run);
  return run;
}

}  // namespace kerf
