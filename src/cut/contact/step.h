// One step of the tool: the motion that is the least of a convex function of six unknowns.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "cut/contact/spring.h"
#include "kerf/force.h"
#include "kerf/geometry.h"

namespace kerf {

/// Velocity of the coupling point C (mm/s) and turning rate (rad/s); or the force and torque about C that go with them
/// (N, N mm). Frame of the tool at the start of the step.
using Twist = std::array<double, 6>;

inline double Dot(const Twist& a, const Twist& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}
/// Takes a motion to the speed along `n` of the tool's point at `r` from C; transposed, a force along n to its wrench.
inline Twist MakeRow(const Vec3& n, const Vec3& r) {
  const Vec3 m = glm::cross(r, n);
  return {n.x, n.y, n.z, m.x, m.y, m.z};
}
inline void AddTo(Twist& sum, double factor, const Twist& row) {
  for (int k = 0; k < 6; ++k) sum[k] += factor * row[k];
}

/// The force on a tooth that a law jumps to with the least bite, N; 0 for a continuous law. Tick-safe.
inline double CalcOnset(const ToothForce& law, double E_star_MPa) {
  return law.law(law.coefficients, 0, E_star_MPa);
}

/// The tie to the handle, as it is at the start of the step.
struct StepCoupling {
  SaturatingSpring spring;   // N/mm, N
  SaturatingSpring torsion;  // N mm/rad, N mm
  SaturatingSpring damper;   // N s/mm, N
  SaturatingSpring torsion_damper;
  Vec3 x_mm{0};       // from the tool's C to the handle's
  Vec3 theta_rad{0};  // rotation vector that takes the tool's orientation to the handle's
  Vec3 v_H_mm_per_s{0};
  Vec3 w_H_rad_per_s{0};
};

/// Bone that teeth cut. Dissipates teeth * F(s / passes_per_s) s at speed s = max(0, row . u) outwards.
struct CuttingPoint {
  Twist row;         // outwards
  double teeth = 0;  // a real number
  double E_star_MPa = 0;
  Twist along{};             // along the edge; of a ring only
  double after_share = 0.5;  // of the teeth: those that lie further along the edge than the point

  /// Unit vector against which the teeth's force acts on a tool with these speeds at the point: outwards there. Where
  /// the point itself moves inwards and only a part of its arc outwards, outwards at the end of that part, so that no
  /// tooth pulls the tool.
  Vec3 FindOutwards(double speed_mm_per_s, double along_mm_per_s) const {
    const Vec3 e(row[0], row[1], row[2]);
    if (speed_mm_per_s >= 0 || !(std::abs(speed_mm_per_s) < std::abs(along_mm_per_s))) return e;
    return glm::normalize(e - speed_mm_per_s / along_mm_per_s * Vec3(along[0], along[1], along[2]));
  }
};

/// Force on a tooth, N: along minus CuttingPoint::row, and along minus CuttingPoint::along.
struct ToothMean {
  double radial_N = 0;
  double along_N = 0;
};

/// Bone that a point of the tool cannot enter: a one-sided spring on how deep it is at the end of the step.
struct SolidPoint {
  Twist row;            // towards the bone
  double depth_mm = 0;  // at the start; negative: still so far away
  double stiffness_N_per_mm = 0;
};

/// The same for a point of a flat face whose normal is +z or -z of the tool: the speed is side (v_z + w_x y - w_y x).
struct FlatPoint {
  double side = 1;
  double x = 0, y = 0;  // of the point from C, mm
  double depth_mm = 0;
};

/// Coulomb friction with a given normal force. The two rows are along two directions across the normal.
struct FrictionPoint {
  Twist row_a, row_b;
  double slip_a_mm_per_s = 0, slip_b_mm_per_s = 0;  // of the spindle's turning
  double limit_N = 0;                               // coefficient times normal force
};

/// A resistance of its own size, ramped as the law is: dissipates force * s at speed s = max(0, row . u). Faster than
/// `rated` it grows with the speed.
struct YieldPoint {
  Twist row;
  double force_N = 0;
  double rated_mm_per_s = std::numeric_limits<double>::infinity();  // not below the ramp

  /// At a speed above 0. Tick-safe.
  double Force(double speed_mm_per_s, double creep_mm_per_s) const {
    return force_N * std::min(1.0, speed_mm_per_s / creep_mm_per_s) * std::max(1.0, speed_mm_per_s / rated_mm_per_s);
  }
  /// Its slope there.
  double Slope(double speed_mm_per_s, double creep_mm_per_s) const {
    return speed_mm_per_s < creep_mm_per_s   ? force_N / creep_mm_per_s
           : speed_mm_per_s > rated_mm_per_s ? force_N / rated_mm_per_s
                                             : 0;
  }
};

/// J(u) = [U(x - tau u) + contact(depth + tau row.u)] / tau + damper(u_H - u) + cutting(u) + friction(u), in N mm/s:
/// coupling and contact implicitly at the end of the step of length tau. All terms are convex, so there is one least.
struct StepProblem {
  double tau_s = 0.001;
  StepCoupling coupling;
  ToothForce law{};
  double passes_per_s = 0;
  /// A law with a force at the least bite is ramped up to it over this speed, or a resting tool would have no one
  /// force: a tool that is held by such a law creeps at up to this. 0: no ramp. mm/s.
  double ramp_mm_per_s = 0;
  /// Of a law with a force at the least bite: how much of a ring each cutting point stands for. That force is then the
  /// mean over this arc, of which a part may move outwards and the rest not. 0: the force is the one at the point.
  double arc_rad = 0;
  double cutting_share = 1;  // of the teeth's force, 0 to 1
  double flat_stiffness_N_per_mm = 0;
  double creep_mm_per_s = 0.02;  // below this friction sticks: F = limit v / sqrt(v^2 + creep^2); yields' ramp
  std::vector<CuttingPoint> cutting;
  std::vector<FlatPoint> flats;
  std::vector<SolidPoint> solids;
  std::vector<FrictionPoint> frictions;
  std::vector<YieldPoint> yields;

  void Clear();
  bool empty() const { return cutting.empty() && flats.empty() && solids.empty() && yields.empty(); }

  /// Force on one tooth at a speed outwards, N. Tick-safe.
  double ToothForceAt(double speed_mm_per_s, double E_star_MPa) const;
  /// Mean force on the teeth of a point that moves at these speeds along its rows. Tick-safe.
  ToothMean MeanToothForce(const CuttingPoint& point, double speed_mm_per_s, double along_mm_per_s) const;
  /// Gradient of J: what is out of balance. Tick-safe.
  Twist CalcGradient(const Twist& u) const;
  /// J itself but for the cutting law's part, which has no formula: for tests. Tick-safe.
  double CalcValueWithoutCutting(const Twist& u) const;
};

struct StepSolution {
  Twist u{};
  int iterations = 0;
  bool converged = false;
};

/// Semismooth Newton with a line search on the slope: J falls in each iteration. When the bound on iterations is hit
/// the best motion is scaled along itself to where J is least, so that J(u) <= J(0) and the work of the coupling's
/// force is that of the forces it meets: no energy is made, whatever the accuracy.
class StepSolver {
 public:
  /// `capacity`: the most points of a kind in a problem. Allocates.
  explicit StepSolver(std::size_t capacity);

  /// Tick-safe. `reach_mm`: size of the tool, by which torques are judged.
  StepSolution Solve(const StepProblem& problem, const Twist& start, double reach_mm, int max_iterations);

 private:
  void Follow(const StepProblem& problem, const Twist& direction);
  double CalcSlope(const StepProblem& problem, const Twist& u, const Twist& p, double alpha) const;
  double Search(const StepProblem& problem, const Twist& u, const Twist& p, double slope_at_0) const;

  // Speeds of the points at u, and along the direction of search.
  struct Speeds {
    std::vector<double> at, along;
    void SetSize(std::size_t size) {
      at.resize(size);
      along.resize(size);
    }
  };
  Speeds cutting_, along_, flats_, solids_, friction_a_, friction_b_, yields_;
};

}  // namespace kerf
