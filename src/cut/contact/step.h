// One step of the tool: the motion that minimises a convex function of six unknowns.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "cut/contact/spring.h"
#include "cut/tool/drive.h"
#include "kerf/force.h"
#include "kerf/geometry.h"

namespace kerf {

/// Velocity of the coupling point C (mm/s) and angular velocity (rad/s); or the conjugate force and torque about C (N,
/// N mm). In the frame of the tool at the start of the step.
using Twist = std::array<double, 6>;
using TwistMatrix = std::array<Twist, 6>;  // symmetric: only the lower triangle is used

inline double Dot(const Twist& a, const Twist& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}
/// Returns the row that maps a motion of the tool to the speed, along `n`, of its point at position `r` relative to C.
/// Its transpose maps a force along n to the wrench of that force about C.
inline Twist MakeRow(const Vec3& n, const Vec3& r) {
  const Vec3 m = glm::cross(r, n);
  return {n.x, n.y, n.z, m.x, m.y, m.z};
}
inline void AddTo(Twist& sum, double factor, const Twist& row) {
  for (int k = 0; k < 6; ++k) sum[k] += factor * row[k];
}

/// Returns the thrust of a law on a tooth in the limit of zero bite, N. It is 0 for a continuous law. Tick-safe.
inline double CalcOnset(const ToothForce& law, const ToothCut& cut) {
  return law.thrust(law, 0, cut);
}

/// A blade that bends sideways, in series with spring and damper of the coupling. Of a displacement x across the blade
/// between handle and blade, the spring takes K_b / (K + K_b) and the blade the rest, so that the force is
/// K K_b / (K + K_b) x. That is the force of the spring for Scale(x), in the direction that Scale() gives it: its
/// energy is convex in x.
struct Bending {
  Vec3 across{0, 0, 1};  // unit vector
  double factor = 1;     // sqrt(K_b / (K + K_b)); 1: the blade is rigid

  Vec3 Scale(const Vec3& x) const { return factor == 1 ? x : x - (1 - factor) * glm::dot(across, x) * across; }
};

/// Coupling to the handle at the start of the step.
struct StepCoupling {
  SaturatingSpring spring;   // N/mm, N
  SaturatingSpring torsion;  // N mm/rad, N mm
  SaturatingSpring damper;   // N s/mm, N
  SaturatingSpring torsion_damper;
  Bending bending;
  Vec3 x_mm{0};       // from the tool's C to the handle's C
  Vec3 theta_rad{0};  // rotation vector from the tool's orientation to the handle's
  Vec3 v_H_mm_per_s{0};
  Vec3 w_H_rad_per_s{0};

  /// Force of the spring on the tool after it has moved by `d_mm`, N. Tick-safe, as the next.
  Vec3 CalcSpringForce(const Vec3& d_mm) const { return bending.Scale(spring.Force(bending.Scale(x_mm - d_mm))); }
  /// Force of the damper on the tool at its velocity, N.
  Vec3 CalcDamperForce(const Vec3& v_mm_per_s) const {
    return bending.Scale(damper.Force(bending.Scale(v_H_mm_per_s - v_mm_per_s)));
  }
};

/// Bone that teeth cut. Dissipates teeth * F(s / passes_per_s) s at the outward speed s = max(0, row . u).
struct CuttingPoint {
  Twist row;         // outward
  double teeth = 0;  // number of teeth, a real number
  ToothCut cut;
  Twist along{};                // along the edge; rings only
  double after_fraction = 0.5;  // fraction of the teeth that lies further along the edge than the point

  /// Returns the unit vector e such that the teeth's force on the tool acts along -e, for the given speeds at the
  /// point. It is the outward direction at the point. If the point itself moves inwards and only a part of its arc
  /// moves outwards, it is the outward direction at the end of that part, so that no tooth pulls the tool.
  Vec3 FindOutwards(double speed_mm_per_s, double along_mm_per_s) const {
    const Vec3 e(row[0], row[1], row[2]);
    if (speed_mm_per_s >= 0 || !(std::abs(speed_mm_per_s) < std::abs(along_mm_per_s))) return e;
    return glm::normalize(e - speed_mm_per_s / along_mm_per_s * Vec3(along[0], along[1], along[2]));
  }
};

/// Force on a tooth, N: components along -CuttingPoint::row and -CuttingPoint::along.
struct ToothMean {
  double radial_N = 0;
  double along_N = 0;
};

/// Bone that a point of the tool cannot enter: a one-sided spring on the depth of the point at the end of the step.
struct SolidPoint {
  Twist row;            // towards the bone
  double depth_mm = 0;  // at the start of the step; negative: the distance from the bone
  double stiffness_N_per_mm = 0;
};

/// SolidPoint for a flat face whose normal is +z or -z of the tool. The speed is side (v_z + w_x y - w_y x).
struct FlatPoint {
  double side = 1;
  double x = 0, y = 0;  // position of the point relative to C, mm
  double depth_mm = 0;
};

/// Coulomb friction with a given normal force. The rows are two directions in the tangent plane.
struct FrictionPoint {
  Twist row_a, row_b;
  double slip_a_mm_per_s = 0, slip_b_mm_per_s = 0;  // due to the rotation of the spindle
  double limit_N = 0;                               // friction coefficient times normal force
};

/// Resistance with a given force: dissipates force * s at speed s = max(0, row . u). Below the creep speed the force is
/// ramped, as in the cutting law; above the rated speed the force grows in proportion to the speed.
struct YieldPoint {
  Twist row;
  double force_N = 0;
  double rated_mm_per_s = std::numeric_limits<double>::infinity();  // at least the creep speed

  /// Force at a speed above 0, N. Tick-safe.
  double Force(double speed_mm_per_s, double creep_mm_per_s) const {
    return force_N * std::min(1.0, speed_mm_per_s / creep_mm_per_s) * std::max(1.0, speed_mm_per_s / rated_mm_per_s);
  }
  /// Derivative of Force() with respect to the speed, N s/mm.
  double Slope(double speed_mm_per_s, double creep_mm_per_s) const {
    return speed_mm_per_s < creep_mm_per_s   ? force_N / creep_mm_per_s
           : speed_mm_per_s > rated_mm_per_s ? force_N / rated_mm_per_s
                                             : 0;
  }
};

/// The function that a step minimises:
/// J(u) = [U(x - tau u) + contact(depth + tau row.u)] / tau + damper(u_H - u) + cutting(u) + friction(u), in N mm/s.
/// Coupling and contact are implicit: they are evaluated at the end of the step, whose length is tau. All terms are
/// convex, so the minimum is unique.
struct StepProblem {
  double tau_s = 0.001;
  StepCoupling coupling;
  ToothForce law{};
  double passes_per_s = 0;
  /// With a stroke: the bites of which the mean forces are means; empty: there is one bite.
  std::span<const BitePart> bites;
  double edge_mm_per_s =
      0;  // mean speed of the teeth of a straight edge; those of a turning edge follow from passes_per_s
  /// Speed over which a law with a nonzero force at zero bite is ramped up to that force, mm/s; 0: no ramp. Without a
  /// ramp the force on a resting tool is not unique. With it, a tool held by such a law creeps at up to this speed.
  double ramp_mm_per_s = 0;
  /// For a law with a nonzero force at zero bite: the arc of a ring that each cutting point represents, rad. That force
  /// is then averaged over the arc, because only a part of the arc may move outwards. 0: use the force at the point.
  double arc_rad = 0;
  double cutting_share = 1;  // factor on the teeth's force, 0 to 1
  double flat_stiffness_N_per_mm = 0;
  double creep_mm_per_s = 0.02;  // friction sticks below: F = limit v / sqrt(v^2 + creep^2); also the yields' ramp
  /// Points of an effect within `reach_mm` of C move by at most `largest_mm` in a substep; reach 0: there are none.
  struct MotionLimit {
    double reach_mm = 0;
    double largest_mm = 1;
  };
  std::array<MotionLimit, 2> limits;  // of points near bone, and of others
  std::vector<CuttingPoint> cutting;
  std::vector<FlatPoint> flats;
  std::vector<SolidPoint> solids;
  std::vector<FrictionPoint> frictions;
  std::vector<YieldPoint> yields;

  void Clear();
  bool empty() const { return cutting.empty() && flats.empty() && solids.empty() && yields.empty(); }

  /// Returns the thrust on one tooth at an outward speed, N. Tick-safe.
  double ToothForceAt(double speed_mm_per_s, const ToothCut& cut) const;
  /// Returns the mean thrust on the teeth of a point that moves at these speeds along its rows. Tick-safe.
  ToothMean MeanToothForce(const CuttingPoint& point, double speed_mm_per_s, double along_mm_per_s) const;
  /// Returns the mean thrust on the teeth of a point over their way, from that over the time: N. Tick-safe.
  double MeanThrustOnWay(const CuttingPoint& point, double speed_mm_per_s, const ToothMean& mean) const;
  /// Returns the mean cutting force over their way of the teeth of a point whose mean thrust is `mean`, N: it is there
  /// for its work. The law must have a cutting force. Tick-safe.
  double MeanCuttingForce(const CuttingPoint& point, double speed_mm_per_s, const ToothMean& mean) const;
  /// Returns the gradient of J, i.e. the unbalanced force and torque. Tick-safe.
  Twist CalcGradient(const Twist& u) const;
};

/// Returns a problem without points.
inline StepProblem MakeStepProblem(ToothForce law) {
  StepProblem problem;
  problem.law = std::move(law);
  return problem;
}

/// Result of StepSolver::Solve().
struct StepSolution {
  Twist u{};
  int iterations = 0;
  bool converged = false;
};

/// Semismooth Newton method with a line search on the slope; J decreases in each iteration. If the iteration does not
/// converge, its last motion is scaled by the factor that minimises J. Then J(u) <= J(0), and the work of the
/// coupling force equals the work of the opposing forces: the step creates no energy, whatever the accuracy.
class StepSolver {
 public:
  /// `capacity`: maximum number of points of one kind in a problem. Allocates.
  explicit StepSolver(std::size_t capacity);

  /// Tick-safe. `reach_mm`: size of the tool, with which the test for convergence converts torques to forces.
  StepSolution Solve(const StepProblem& problem, const Twist& start, double reach_mm, int max_iterations);

 private:
  /// Thrust on a tooth of each cutting point, N, at u + alpha p.
  struct Forces {
    double alpha;
    std::vector<double> thrust_N;
  };

  /// Forces of the coupling on the tool, and their slopes.
  struct Coupled {
    Vec3 force_N, torque_N_mm;
    double slope, turning_slope;
  };

  void Follow(const StepProblem& problem, const Twist& direction);
  void SetSpeeds(const StepProblem& problem, const Twist& u);
  double CalcSlope(const StepProblem& problem, const Twist& u, const Twist& p, double alpha, Forces& forces) const;
  double Search(const StepProblem& problem, const Twist& u, const Twist& p, double slope_at_0);
  static Coupled CalcCoupled(const StepProblem& problem, const Twist& u);
  Twist CalcGradient(const StepProblem& problem, const Coupled& coupled, bool knows_forces);
  void AddCuttingSlopes(const StepProblem& problem, TwistMatrix& H) const;
  void AddOtherSlopes(const StepProblem& problem, TwistMatrix& H) const;

  // Speeds of the points at u, and along the search direction.
  struct Speeds {
    std::vector<double> at, along;
    void SetSize(std::size_t size) {
      at.resize(size);
      along.resize(size);
    }
  };
  Speeds cutting_, along_, flats_, solids_, friction_a_, friction_b_, yields_;
  Forces last_, halfway_;  // of the line search: at the alpha tried last; where the decrease of J is proven
};

}  // namespace kerf
