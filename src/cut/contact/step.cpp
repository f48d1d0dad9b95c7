#include "cut/contact/step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

constexpr double kForceTolerance = 1e-8;  // relative to the forces of the coupling plus 1 N
constexpr double kSlopeTolerance = 0.1;   // of the line search, relative to the slope at its start
constexpr int kMaxSearch = 24;
constexpr double kSecantStep = 1e-6;  // relative, for the slope of a force law: half the digits of a double

/// The speeds of the points are summed over the iterations, and each term is rounded. Returns true if the forces of
/// that rounding may exceed the tolerance: if a long `path` of u has led to points whose force is steep, such as
/// friction with a large limit. The slopes are those of H, of which each entry is at most the root of the product of
/// the two diagonal ones.
bool MayHaveDrifted(const TwistMatrix& H, const Twist& path, double tolerance_N, double reach_mm) {
  constexpr double kRounding =
      8 * std::numeric_limits<double>::epsilon();  // of a sum of six products, and its addition
  double sum = 0;
  for (std::size_t i = 0; i < path.size(); ++i) sum += std::sqrt(std::max(H[i][i], 0.0)) * path[i];
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (kRounding * std::sqrt(std::max(H[i][i], 0.0)) * sum > (i < 3 ? tolerance_N : tolerance_N * reach_mm))
      return true;
  }
  return false;
}

Vec3 Linear(const Twist& u) {
  return {u[0], u[1], u[2]};
}
Vec3 Angular(const Twist& u) {
  return {u[3], u[4], u[5]};
}
double FlatSpeed(const FlatPoint& p, const Twist& u) {
  return p.side * (u[2] + u[3] * p.y - u[4] * p.x);
}

void AddOuter(TwistMatrix& H, double factor, const Twist& row) {
  for (int i = 0; i < 6; ++i) {
    const double f = factor * row[i];
    for (int j = 0; j <= i; ++j) H[i][j] += f * row[j];
  }
}
/// Adds factor (a b^T + b a^T).
void AddMixed(TwistMatrix& H, double factor, const Twist& a, const Twist& b) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) H[i][j] += factor * (a[i] * b[j] + b[i] * a[j]);
  }
}

/// Solves H x = b for a symmetric positive definite H by Cholesky factorisation. The unknowns are scaled for a unit
/// diagonal. A pivot that has been lost to rounding is raised to kMinPivot.
Twist SolveSymmetric(TwistMatrix H, const Twist& b) {
  std::array<double, 6> scale;
  for (int i = 0; i < 6; ++i) scale[i] = 1 / std::sqrt(std::max(H[i][i], 1e-300));
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) H[i][j] *= scale[i] * scale[j];
  }
  constexpr double kMinPivot = 1e-13;
  Twist x;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = H[i][j];
      for (int k = 0; k < j; ++k) sum -= H[i][k] * H[j][k];
      H[i][j] = i == j ? std::sqrt(std::max(sum, kMinPivot)) : sum / H[j][j];
    }
  }
  for (int i = 0; i < 6; ++i) {
    double sum = scale[i] * b[i];
    for (int k = 0; k < i; ++k) sum -= H[i][k] * x[k];
    x[i] = sum / H[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    double sum = x[i];
    for (int k = i + 1; k < 6; ++k) sum -= H[k][i] * x[k];
    x[i] = sum / H[i][i];
  }
  for (int i = 0; i < 6; ++i) x[i] *= scale[i];
  return x;
}

/// Fraction of a law's onset force F0 that acts on a point of the edge: c(x) = clamp(x / ramp, 0, 1) at the outward
/// speed x, averaged over the arc that the point represents. On the arc x = s + t phi, |phi| <= half_rad, with s and t
/// the speeds of the point outwards and along the edge. The mean of the potential is convex in (s, t); its derivatives
/// are:
struct OnsetMean {
  double fraction = 0;  // d/ds: 0 to 1
  double moment = 0;    // d/dt
  double ss = 0, st = 0, tt = 0;
};

/// Adds `weight` times the mean over phi from p to q; requires t > 0.
void AddOnsetMean(double s, double t, double p, double q, double weight, double ramp, OnsetMean& mean) {
  const double begin = std::clamp(-s / t, p, q);
  const double full = std::clamp((ramp - s) / t, p, q);
  const double per_rad = weight / (q - p);
  mean.fraction += per_rad * (q - full);
  mean.moment += per_rad * 0.5 * (q * q - full * full);
  if (!(full > begin)) return;
  const double ss = per_rad / ramp * (full - begin);
  const double st = per_rad / ramp * (full * full - begin * begin) / 2;
  const double tt = per_rad / ramp * (full * full * full - begin * begin * begin) / 3;
  mean.fraction += s * ss + t * st;
  mean.moment += s * st + t * tt;
  mean.ss += ss;
  mean.st += st;
  mean.tt += tt;
}

OnsetMean CalcOnsetMean(double s, double t, double half_rad, double after_fraction, double ramp) {
  OnsetMean mean;
  const double spread = half_rad * std::abs(t);
  if (s + spread <= 0) return mean;
  const double middle_rad = half_rad * (after_fraction - 0.5);  // mean angle of the teeth
  if (s - spread >= ramp) return {1, middle_rad, 0, 0, 0};
  constexpr double kNoSpread = 1e-12;  // mm/s
  if (ramp > 0 && spread < kNoSpread) {
    if (s > 0) mean = {s / ramp, middle_rad * s / ramp, 1 / ramp, middle_rad / ramp, half_rad * half_rad / (3 * ramp)};
    return mean;
  }
  const double ahead = t > 0 ? after_fraction : 1 - after_fraction;
  AddOnsetMean(s, std::abs(t), -half_rad, 0, 1 - ahead, ramp, mean);
  AddOnsetMean(s, std::abs(t), 0, half_rad, ahead, ramp, mean);
  if (t < 0) {
    mean.moment = -mean.moment;
    mean.st = -mean.st;
  }
  return mean;
}

/// Returns the OnsetMean less the part c(s) that ToothForceAt() includes, times teeth * F0.
OnsetMean CalcOnsetChange(const StepProblem& problem, const CuttingPoint& point, double s, double t) {
  const double ramp = problem.ramp_mm_per_s;
  OnsetMean mean = CalcOnsetMean(s, t, 0.5 * problem.arc_rad, point.after_fraction, ramp);
  if (s > 0) {
    mean.fraction -= s < ramp ? s / ramp : 1;
    if (s < ramp) mean.ss -= 1 / ramp;
  }
  if (mean.fraction == 0 && mean.moment == 0) return {};
  const double onset_N = point.teeth * problem.cutting_share * CalcOnset(problem.law, point.cut);
  return {onset_N * mean.fraction, onset_N * mean.moment, onset_N * mean.ss, onset_N * mean.st, onset_N * mean.tt};
}

}  // namespace

void StepProblem::Clear() {
  cutting.clear();
  flats.clear();
  solids.clear();
  frictions.clear();
  yields.clear();
  limits = {};
}

double StepProblem::ToothForceAt(double speed, const ToothCut& cut) const {
  if (!(speed > 0)) return 0;
  const double force = cutting_share * law.thrust(law, speed / passes_per_s, cut);
  return speed < ramp_mm_per_s ? force * (speed / ramp_mm_per_s) : force;
}

ToothMean StepProblem::MeanToothForce(const CuttingPoint& point, double speed, double along_speed) const {
  ToothMean mean{ToothForceAt(speed, point.cut), 0};
  if (!bites.empty() && speed > 0) {
    mean.radial_N = 0;
    for (const BitePart& part : bites) mean.radial_N += part.share * ToothForceAt(part.bite * speed, point.cut);
  }
  if (arc_rad > 0 && point.teeth > 0) {
    const OnsetMean change = CalcOnsetChange(*this, point, speed, along_speed);
    mean.radial_N += change.fraction / point.teeth;
    mean.along_N = change.moment / point.teeth;
  }
  return mean;
}

double StepProblem::MeanThrustOnWay(const CuttingPoint& point, double speed, const ToothMean& mean) const {
  if (bites.empty()) return mean.radial_N;
  double thrust_N = 0;
  for (const BitePart& part : bites) thrust_N += part.way_share * ToothForceAt(part.way_bite * speed, point.cut);
  return thrust_N;
}

double StepProblem::MeanCuttingForce(const CuttingPoint& point, double speed, const ToothMean& mean) const {
  const double bite_mm = std::max(speed, 0.0) / passes_per_s;
  if (!bites.empty() && bite_mm > 0) {
    double cutting_N = 0;
    for (const BitePart& part : bites)
      cutting_N += part.way_share * law.cutting(law, part.way_bite * bite_mm, point.cut);
    return cutting_share * cutting_N;
  }
  const double cutting_N = law.cutting(law, bite_mm, point.cut);
  // Nothing but the law acts: the ratio below is 1.
  if (arc_rad == 0 && ramp_mm_per_s == 0 && cutting_share == 1) return bite_mm > 0 ? cutting_N : 0;
  const double thrust_N = law.thrust(law, bite_mm, point.cut);
  // The parts of the teeth and of the ramp that act are the same for both forces.
  if (thrust_N > 0) return cutting_N * (mean.radial_N / thrust_N);
  return bite_mm > 0 ? cutting_share * cutting_N : 0;
}

Twist StepProblem::CalcGradient(const Twist& u) const {
  const StepCoupling& c = coupling;
  const Vec3 force = c.CalcSpringForce(tau_s * Linear(u)) + c.CalcDamperForce(Linear(u));
  const Vec3 torque =
      c.torsion.Force(c.theta_rad - tau_s * Angular(u)) + c.torsion_damper.Force(c.w_H_rad_per_s - Angular(u));
  Twist g{-force.x, -force.y, -force.z, -torque.x, -torque.y, -torque.z};
  for (const CuttingPoint& p : cutting) {
    const ToothMean mean = MeanToothForce(p, Dot(p.row, u), Dot(p.along, u));
    AddTo(g, p.teeth * mean.radial_N, p.row);
    if (mean.along_N != 0) AddTo(g, p.teeth * mean.along_N, p.along);
  }
  for (const FlatPoint& p : flats) {
    const double depth = p.depth_mm + tau_s * FlatSpeed(p, u);
    if (depth > 0) AddTo(g, flat_stiffness_N_per_mm * depth * p.side, {0, 0, 1, p.y, -p.x, 0});
  }
  for (const SolidPoint& p : solids) {
    const double depth = p.depth_mm + tau_s * Dot(p.row, u);
    if (depth > 0) AddTo(g, p.stiffness_N_per_mm * depth, p.row);
  }
  for (const FrictionPoint& p : frictions) {
    const double a = Dot(p.row_a, u) + p.slip_a_mm_per_s;
    const double b = Dot(p.row_b, u) + p.slip_b_mm_per_s;
    const double factor = p.limit_N / std::sqrt(a * a + b * b + creep_mm_per_s * creep_mm_per_s);
    AddTo(g, factor * a, p.row_a);
    AddTo(g, factor * b, p.row_b);
  }
  for (const YieldPoint& p : yields) {
    const double speed = Dot(p.row, u);
    if (speed > 0) AddTo(g, p.Force(speed, creep_mm_per_s), p.row);
  }
  return g;
}

StepSolver::StepSolver(std::size_t capacity) {
  for (Speeds* speeds : {&cutting_, &along_, &flats_, &solids_, &friction_a_, &friction_b_, &yields_}) {
    speeds->at.reserve(capacity);
    speeds->along.reserve(capacity);
  }
  last_.thrust_N.resize(capacity);
  halfway_.thrust_N.resize(capacity);
}

/// Computes the speeds of all points along a search direction.
void StepSolver::Follow(const StepProblem& problem, const Twist& p) {
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) cutting_.along[i] = Dot(problem.cutting[i].row, p);
  for (std::size_t i = 0; i < along_.along.size(); ++i) along_.along[i] = Dot(problem.cutting[i].along, p);
  for (std::size_t i = 0; i < problem.flats.size(); ++i) flats_.along[i] = FlatSpeed(problem.flats[i], p);
  for (std::size_t i = 0; i < problem.solids.size(); ++i) solids_.along[i] = Dot(problem.solids[i].row, p);
  for (std::size_t i = 0; i < problem.frictions.size(); ++i) {
    friction_a_.along[i] = Dot(problem.frictions[i].row_a, p);
    friction_b_.along[i] = Dot(problem.frictions[i].row_b, p);
  }
  for (std::size_t i = 0; i < problem.yields.size(); ++i) yields_.along[i] = Dot(problem.yields[i].row, p);
}

/// Sets the speeds of all points at `u`; those along the search direction are lost.
void StepSolver::SetSpeeds(const StepProblem& problem, const Twist& u) {
  Follow(problem, u);
  for (Speeds* speeds : {&cutting_, &along_, &flats_, &solids_, &friction_a_, &friction_b_, &yields_})
    speeds->at.swap(speeds->along);
}

/// Returns d/d(alpha) J(u + alpha p), from the known speeds at u and along p. Sets `forces`.
double StepSolver::CalcSlope(const StepProblem& problem, const Twist& u, const Twist& p, double alpha,
                             Forces& forces) const {
  forces.alpha = alpha;
  const StepCoupling& c = problem.coupling;
  const double tau = problem.tau_s;
  const Vec3 v = Linear(u) + alpha * Linear(p);
  const Vec3 w = Angular(u) + alpha * Angular(p);
  double slope =
      -glm::dot(c.CalcSpringForce(tau * v) + c.CalcDamperForce(v), Linear(p)) -
      glm::dot(c.torsion.Force(c.theta_rad - tau * w) + c.torsion_damper.Force(c.w_H_rad_per_s - w), Angular(p));
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const CuttingPoint& point = problem.cutting[i];
    const double speed = cutting_.at[i] + alpha * cutting_.along[i];
    forces.thrust_N[i] = problem.ToothForceAt(speed, point.cut);
    if (speed > 0) slope += point.teeth * forces.thrust_N[i] * cutting_.along[i];
  }
  for (std::size_t i = 0; i < along_.at.size(); ++i) {
    const OnsetMean change = CalcOnsetChange(problem, problem.cutting[i], cutting_.at[i] + alpha * cutting_.along[i],
                                             along_.at[i] + alpha * along_.along[i]);
    slope += change.fraction * cutting_.along[i] + change.moment * along_.along[i];
  }
  double flats = 0;
  for (std::size_t i = 0; i < problem.flats.size(); ++i) {
    const double depth = problem.flats[i].depth_mm + tau * (flats_.at[i] + alpha * flats_.along[i]);
    flats += std::max(depth, 0.0) * flats_.along[i];
  }
  slope += problem.flat_stiffness_N_per_mm * flats;
  for (std::size_t i = 0; i < problem.solids.size(); ++i) {
    const SolidPoint& point = problem.solids[i];
    const double depth = point.depth_mm + tau * (solids_.at[i] + alpha * solids_.along[i]);
    if (depth > 0) slope += point.stiffness_N_per_mm * depth * solids_.along[i];
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  for (std::size_t i = 0; i < problem.frictions.size(); ++i) {
    const FrictionPoint& point = problem.frictions[i];
    const double a = friction_a_.at[i] + alpha * friction_a_.along[i] + point.slip_a_mm_per_s;
    const double b = friction_b_.at[i] + alpha * friction_b_.along[i] + point.slip_b_mm_per_s;
    slope += point.limit_N * (a * friction_a_.along[i] + b * friction_b_.along[i]) / std::sqrt(a * a + b * b + creep2);
  }
  for (std::size_t i = 0; i < problem.yields.size(); ++i) {
    const double speed = yields_.at[i] + alpha * yields_.along[i];
    if (speed > 0) slope += problem.yields[i].Force(speed, problem.creep_mm_per_s) * yields_.along[i];
  }
  return slope;
}

/// Returns an alpha >= 0 at which the slope is nearly 0 and J is at most its value at 0. The slope at 0 must be
/// negative.
double StepSolver::Search(const StepProblem& problem, const Twist& u, const Twist& p, double slope_at_0) {
  const double enough = kSlopeTolerance * std::abs(slope_at_0);
  double low = 0;
  double slope_low = slope_at_0;
  double high = 1;
  double slope_high = CalcSlope(problem, u, p, high, last_);
  for (int n = 0; n < kMaxSearch && slope_high < -enough; ++n) {
    low = high;
    slope_low = slope_high;
    high *= 2;
    slope_high = CalcSlope(problem, u, p, high, last_);
  }
  if (slope_high <= 0) return high;
  // A point slightly past the minimum is accepted if the slope half-way proves that J has decreased overall.
  if (slope_high <= enough && CalcSlope(problem, u, p, 0.5 * (low + high), halfway_) <= -slope_high) return high;
  // Method of false position with the Illinois rule: the value at an end that stays in place is halved.
  double weight_low = slope_low;
  double weight_high = slope_high;
  int last = 0;
  for (int n = 0; n < kMaxSearch && slope_low < -enough; ++n) {
    const double middle = low + (high - low) * std::clamp(weight_low / (weight_low - weight_high), 0.02, 0.98);
    if (!(middle > low && middle < high)) break;
    const double slope = CalcSlope(problem, u, p, middle, last_);
    if (slope <= 0) {
      low = middle;
      slope_low = weight_low = slope;
      if (last == -1) weight_high *= 0.5;
      last = -1;
    } else {
      high = middle;
      slope_high = weight_high = slope;
      if (last == 1) weight_low *= 0.5;
      last = 1;
    }
  }
  return low;
}

/// Returns the forces of the coupling at `u`, with the slopes of the spring and the damper together. A saturated spring
/// has zero tangent stiffness along its own direction; its secant stiffness keeps the step finite.
StepSolver::Coupled StepSolver::CalcCoupled(const StepProblem& problem, const Twist& u) {
  const StepCoupling& c = problem.coupling;
  const double tau = problem.tau_s;
  const Vec3 e = c.bending.Scale(c.x_mm - tau * Linear(u));
  const Vec3 e_turn = c.theta_rad - tau * Angular(u);
  const Vec3 rel = c.bending.Scale(c.v_H_mm_per_s - Linear(u));
  const Vec3 rel_turn = c.w_H_rad_per_s - Angular(u);
  const double k = c.spring.Secant(glm::length(e));
  const double k_turn = c.torsion.Secant(glm::length(e_turn));
  const double b = c.damper.Secant(glm::length(rel));
  const double b_turn = c.torsion_damper.Secant(glm::length(rel_turn));
  return {c.bending.Scale(k * e + b * rel), k_turn * e_turn + b_turn * rel_turn, tau * k + b, tau * k_turn + b_turn};
}

/// Returns the gradient of J from the known speeds. Sets the thrusts of last_, unless they are known.
Twist StepSolver::CalcGradient(const StepProblem& problem, const Coupled& coupled, bool knows_forces) {
  const Vec3& force = coupled.force_N;
  const Vec3& torque = coupled.torque_N_mm;
  Twist g{-force.x, -force.y, -force.z, -torque.x, -torque.y, -torque.z};
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const CuttingPoint& point = problem.cutting[i];
    if (!knows_forces) last_.thrust_N[i] = problem.ToothForceAt(cutting_.at[i], point.cut);
    if (cutting_.at[i] > 0) AddTo(g, point.teeth * last_.thrust_N[i], point.row);
  }
  for (std::size_t i = 0; i < along_.at.size(); ++i) {
    const CuttingPoint& point = problem.cutting[i];
    const OnsetMean change = CalcOnsetChange(problem, point, cutting_.at[i], along_.at[i]);
    if (change.fraction == 0 && change.moment == 0) continue;
    AddTo(g, change.fraction, point.row);
    AddTo(g, change.moment, point.along);
  }
  double f[3] = {};
  for (std::size_t i = 0; i < problem.flats.size(); ++i) {
    const FlatPoint& point = problem.flats[i];
    const double depth = point.depth_mm + problem.tau_s * flats_.at[i];
    if (!(depth > 0)) continue;
    const double push = depth * point.side;
    f[0] += push;
    f[1] += push * point.y;
    f[2] -= push * point.x;
  }
  for (int i = 0; i < 3; ++i) g[2 + i] += problem.flat_stiffness_N_per_mm * f[i];
  for (std::size_t i = 0; i < problem.solids.size(); ++i) {
    const SolidPoint& point = problem.solids[i];
    const double depth = point.depth_mm + problem.tau_s * solids_.at[i];
    if (depth > 0) AddTo(g, point.stiffness_N_per_mm * depth, point.row);
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  for (std::size_t i = 0; i < problem.frictions.size(); ++i) {
    const FrictionPoint& point = problem.frictions[i];
    const double va = friction_a_.at[i] + point.slip_a_mm_per_s;
    const double vb = friction_b_.at[i] + point.slip_b_mm_per_s;
    const double factor = point.limit_N * (1 / std::sqrt(va * va + vb * vb + creep2));
    AddTo(g, factor * va, point.row_a);
    AddTo(g, factor * vb, point.row_b);
  }
  for (std::size_t i = 0; i < problem.yields.size(); ++i) {
    const YieldPoint& point = problem.yields[i];
    const double speed = yields_.at[i];
    if (speed > 0) AddTo(g, point.Force(speed, problem.creep_mm_per_s), point.row);
  }
  return g;
}

/// Adds the slopes of the teeth's forces to H. The thrusts of last_ must be those at the known speeds.
void StepSolver::AddCuttingSlopes(const StepProblem& problem, TwistMatrix& H) const {
  for (std::size_t i = 0; i < problem.cutting.size(); ++i) {
    const double speed = cutting_.at[i];
    if (!(speed > 0)) continue;
    const CuttingPoint& point = problem.cutting[i];
    const double beyond = speed * (1 + kSecantStep);
    const double slope = (problem.ToothForceAt(beyond, point.cut) - last_.thrust_N[i]) / (beyond - speed);
    AddOuter(H, point.teeth * slope, point.row);
  }
}

/// Adds the slopes of all other forces, but for the coupling's, to H.
void StepSolver::AddOtherSlopes(const StepProblem& problem, TwistMatrix& H) const {
  for (std::size_t i = 0; i < along_.at.size(); ++i) {
    const CuttingPoint& point = problem.cutting[i];
    const OnsetMean change = CalcOnsetChange(problem, point, cutting_.at[i], along_.at[i]);
    if (change.fraction == 0 && change.moment == 0) continue;
    AddOuter(H, change.ss, point.row);
    AddMixed(H, change.st, point.row, point.along);
    AddOuter(H, change.tt, point.along);
  }
  double h[6] = {};
  for (std::size_t i = 0; i < problem.flats.size(); ++i) {
    const FlatPoint& point = problem.flats[i];
    if (!(point.depth_mm + problem.tau_s * flats_.at[i] > 0)) continue;
    h[0] += 1;
    h[1] += point.y;
    h[2] += point.y * point.y;
    h[3] -= point.x;
    h[4] -= point.x * point.y;
    h[5] += point.x * point.x;
  }
  const double flat_slope = problem.tau_s * problem.flat_stiffness_N_per_mm;
  H[2][2] += flat_slope * h[0];
  H[3][2] += flat_slope * h[1];
  H[3][3] += flat_slope * h[2];
  H[4][2] += flat_slope * h[3];
  H[4][3] += flat_slope * h[4];
  H[4][4] += flat_slope * h[5];
  for (std::size_t i = 0; i < problem.solids.size(); ++i) {
    const SolidPoint& point = problem.solids[i];
    if (!(point.depth_mm + problem.tau_s * solids_.at[i] > 0)) continue;
    AddOuter(H, problem.tau_s * point.stiffness_N_per_mm, point.row);
  }
  const double creep2 = problem.creep_mm_per_s * problem.creep_mm_per_s;
  for (std::size_t i = 0; i < problem.frictions.size(); ++i) {
    const FrictionPoint& point = problem.frictions[i];
    const double va = friction_a_.at[i] + point.slip_a_mm_per_s;
    const double vb = friction_b_.at[i] + point.slip_b_mm_per_s;
    const double inv = 1 / std::sqrt(va * va + vb * vb + creep2);
    const double factor = point.limit_N * inv;
    AddOuter(H, factor * (1 - va * va * inv * inv), point.row_a);
    AddOuter(H, factor * (1 - vb * vb * inv * inv), point.row_b);
    AddMixed(H, -factor * va * vb * inv * inv, point.row_a, point.row_b);
  }
  for (std::size_t i = 0; i < problem.yields.size(); ++i) {
    const YieldPoint& point = problem.yields[i];
    const double speed = yields_.at[i];
    if (speed > 0) AddOuter(H, point.Slope(speed, problem.creep_mm_per_s), point.row);
  }
}

StepSolution StepSolver::Solve(const StepProblem& problem, const Twist& start, double reach_mm, int max_iterations) {
  StepSolution solution;
  Twist& u = solution.u;
  u = start;
  cutting_.SetSize(problem.cutting.size());
  along_.SetSize(problem.arc_rad > 0 ? problem.cutting.size() : 0);
  flats_.SetSize(problem.flats.size());
  solids_.SetSize(problem.solids.size());
  friction_a_.SetSize(problem.frictions.size());
  friction_b_.SetSize(problem.frictions.size());
  yields_.SetSize(problem.yields.size());
  SetSpeeds(problem, u);

  bool knows_forces = false;  // last_ holds those at u
  double tolerance_N = 0;
  Coupled coupled;
  const auto gradient = [&] {
    coupled = CalcCoupled(problem, u);
    const Twist g = CalcGradient(problem, coupled, knows_forces);
    tolerance_N = kForceTolerance * (1 + glm::length(coupled.force_N) + glm::length(coupled.torque_N_mm) / reach_mm);
    solution.converged = std::abs(g[0]) + std::abs(g[1]) + std::abs(g[2]) <= tolerance_N &&
                         std::abs(g[3]) + std::abs(g[4]) + std::abs(g[5]) <= tolerance_N * reach_mm;
    return g;
  };
  const auto coupling_slopes = [&] {
    TwistMatrix H{};
    for (std::size_t i = 0; i < 3; ++i) {
      H[i][i] = coupled.slope;
      H[i + 3][i + 3] = coupled.turning_slope;
    }
    if (const double factor = problem.coupling.bending.factor; factor != 1) {
      const Vec3& n = problem.coupling.bending.across;
      AddOuter(H, (factor * factor - 1) * coupled.slope, {n.x, n.y, n.z, 0, 0, 0});
    }
    return H;
  };

  Twist path{};   // sum of the absolute changes of u since the speeds were set
  Twist steep{};  // diagonal of the slopes of the teeth's forces in the last iteration
  const auto may_have_drifted = [&] {
    TwistMatrix H = coupling_slopes();
    AddOtherSlopes(problem, H);
    for (std::size_t i = 0; i < steep.size(); ++i) H[i][i] += steep[i];
    return MayHaveDrifted(H, path, tolerance_N, reach_mm);
  };
  for (;;) {
    Twist g = gradient();
    if (solution.converged && may_have_drifted()) {
      SetSpeeds(problem, u);
      knows_forces = false;
      path = {};
      g = gradient();
    }
    if (solution.converged || solution.iterations == max_iterations) break;
    ++solution.iterations;
    TwistMatrix H = coupling_slopes();
    for (std::size_t i = 0; i < steep.size(); ++i) steep[i] = -H[i][i];
    AddCuttingSlopes(problem, H);
    for (std::size_t i = 0; i < steep.size(); ++i) steep[i] += H[i][i];
    AddOtherSlopes(problem, H);
    const Twist p = SolveSymmetric(H, {-g[0], -g[1], -g[2], -g[3], -g[4], -g[5]});
    const double slope = Dot(g, p);
    if (!(slope < 0)) break;
    Follow(problem, p);
    const double alpha = Search(problem, u, p, slope);
    if (alpha == 0) break;
    knows_forces = alpha == last_.alpha;
    AddTo(u, alpha, p);
    for (std::size_t i = 0; i < path.size(); ++i) path[i] += std::abs(alpha * p[i]);
    for (Speeds* speeds : {&cutting_, &along_, &flats_, &solids_, &friction_a_, &friction_b_, &yields_}) {
      for (std::size_t i = 0; i < speeds->at.size(); ++i) speeds->at[i] += alpha * speeds->along[i];
    }
  }
  if (solution.converged) return solution;

  // Scale the last motion by the factor that minimises J: u . gradient = 0.
  const Twist best = u;
  u = {};
  for (Speeds* speeds : {&cutting_, &along_, &flats_, &solids_, &friction_a_, &friction_b_, &yields_}) {
    std::fill(speeds->at.begin(), speeds->at.end(), 0.0);
  }
  Follow(problem, best);
  if (CalcSlope(problem, u, best, 0, last_) >= 0) return solution;
  double low = 0;
  double high = 1;
  while (CalcSlope(problem, u, best, high, last_) < 0 && high < 1e6) high *= 2;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (low + high);
    (CalcSlope(problem, u, best, middle, last_) < 0 ? low : high) = middle;
  }
  AddTo(u, low, best);
  return solution;
}

}  // namespace kerf
