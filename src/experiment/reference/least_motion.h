// The motion of a massless tool: the minimum of a convex function of six unknowns (docs/tick.md, One step).
#pragma once

#include <array>
#include <vector>

#include "kerf/force.h"
#include "kerf/geometry.h"

namespace kerf::reference {

/// Velocity of the coupling point C (mm/s) and angular velocity (rad/s) in the tool frame, or the conjugate force and
/// torque (N, N mm about C).
using Six = std::array<double, 6>;

inline Vec3 Upper(const Six& u) {
  return {u[0], u[1], u[2]};
}
inline Vec3 Lower(const Six& u) {
  return {u[3], u[4], u[5]};
}
inline Six Join(const Vec3& upper, const Vec3& lower) {
  return {upper.x, upper.y, upper.z, lower.x, lower.y, lower.z};
}

/// A spring or damper with a limited force: K x, but at most `limit`.
struct Tie {
  double K = 0;
  double limit = 0;

  double Fraction(const Vec3& x) const {
    const double drawn = K * glm::length(x);
    return drawn > limit ? K * limit / drawn : K;
  }
  Vec3 Pull(const Vec3& x) const { return Fraction(x) * x; }
};

/// Bone in front of a number of teeth, cut in the direction `along` (speed = along . motion).
struct Cut {
  Six along;
  double teeth = 0;
  ToothCut bone;
};

/// A spring that resists a point once its displacement along `along` exceeds -`depth_mm`.
struct Wall {
  Six along;
  double depth_mm = 0;
  double K = 0;
};

struct MotionProblem {
  double tau_s = 0;
  Tie spring, torsion, damper, torsion_damper;
  Vec3 x_mm{0};       // vector from C of the tool to C of the handle
  Vec3 theta_rad{0};  // rotation from the tool to the handle
  Vec3 v_H{0}, w_H{0};
  ToothForce law;
  double passes_per_s = 0;
  double ramp_mm_per_s = 0;  // below this speed, a force that is not zero at the smallest bite is ramped in; 0: no ramp
  std::vector<Cut> cuts;
  std::vector<Wall> walls;

  double CalcTooth(double speed_mm_per_s, const ToothCut& bone) const;
  /// Returns the gradient of the function that is minimised; it is 0 at the minimum.
  Six CalcGradient(const Six& u) const;
};

struct Motion {
  Six u{};
  bool settled = false;  // the imbalance is at most 1e-9 of the acting forces
  int iterations = 0;
};

/// Finds the minimum by Newton's method from `start`. The line search along each direction uses bisection until the
/// slope has fallen to a tenth; it always converges since the function is convex. `reach_mm` is the length that scales
/// torques relative to forces.
Motion FindMinimum(const MotionProblem& problem, const Six& start, double reach_mm);

}  // namespace kerf::reference
