// The motion of a tool without mass: the least of a convex function of six unknowns (docs/tick.md, One step).
#pragma once

#include <array>
#include <vector>

#include "kerf/force.h"
#include "kerf/geometry.h"

namespace kerf::reference {

/// Velocity of the coupling point C (mm/s) and turning rate (rad/s), in the tool's frame; or what goes with them (N,
/// N mm about C).
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

/// K x, but never more than `most`.
struct Tie {
  double K = 0;
  double most = 0;

  double Share(const Vec3& x) const {
    const double drawn = K * glm::length(x);
    return drawn > most ? K * most / drawn : K;
  }
  Vec3 Pull(const Vec3& x) const { return Share(x) * x; }
};

/// Bone before so many teeth, met along `along` (a speed by its product with a motion).
struct Cut {
  Six along;
  double teeth = 0;
  double E_star_MPa = 0;
};

/// A spring against a point going further along `along` than `depth_mm` below 0 is away.
struct Wall {
  Six along;
  double depth_mm = 0;
  double K = 0;
};

struct MotionProblem {
  double tau_s = 0;
  Tie spring, torsion, damper, torsion_damper;
  Vec3 x_mm{0};       // from the tool's C to the handle's
  Vec3 theta_rad{0};  // turns the tool to the handle
  Vec3 v_H{0}, w_H{0};
  ToothForce law;
  double passes_per_s = 0;
  double ramp_mm_per_s = 0;  // up to which a force at the smallest bite sets in; 0: none
  std::vector<Cut> cuts;
  std::vector<Wall> walls;

  double CalcTooth(double speed_mm_per_s, double E_star_MPa) const;
  /// Of the function that is least; at the least it is 0.
  Six CalcGradient(const Six& u) const;
};

struct Motion {
  Six u{};
  bool settled = false;  // out of balance by no more than 1e-9 of the forces in play
  int iterations = 0;
};

/// Newton's method from `start`. Along each direction the point is sought where the slope has fallen to a tenth, by
/// bisection: the function is convex, so this always comes down. `reach_mm` weighs torques against forces.
Motion FindLeast(const MotionProblem& problem, const Six& start, double reach_mm);

}  // namespace kerf::reference
