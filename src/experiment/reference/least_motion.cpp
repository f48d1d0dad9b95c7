#include "experiment/reference/least_motion.h"

#include <algorithm>
#include <cmath>

namespace kerf::reference {
namespace {

using Matrix = std::array<Six, 6>;

constexpr int kMaxIterations = 200;
constexpr double kBalance = 1e-9;
constexpr double kSlopeFraction = 0.1;

double Dot(const Six& a, const Six& b) {
  double sum = 0;
  for (int i = 0; i < 6; ++i) sum += a[i] * b[i];
  return sum;
}
Six Step(const Six& u, double alpha, const Six& p) {
  Six sum = u;
  for (int i = 0; i < 6; ++i) sum[i] += alpha * p[i];
  return sum;
}

/// Returns the slope of the function along p, at u + alpha p.
double CalcSlope(const MotionProblem& problem, const Six& u, double alpha, const Six& p) {
  return Dot(problem.CalcGradient(Step(u, alpha, p)), p);
}

/// Returns the second derivatives. For a tie at its limit, the secant stiffness is used, which is never smaller.
Matrix CalcCurvature(const MotionProblem& m, const Six& u) {
  Matrix H{};
  const double k = m.tau_s * m.spring.Fraction(m.x_mm - m.tau_s * Upper(u)) + m.damper.Fraction(m.v_H - Upper(u));
  const double k_turn =
      m.tau_s * m.torsion.Fraction(m.theta_rad - m.tau_s * Lower(u)) + m.torsion_damper.Fraction(m.w_H - Lower(u));
  for (int i = 0; i < 3; ++i) {
    H[i][i] = k;
    H[i + 3][i + 3] = k_turn;
  }
  const auto add = [&H](double factor, const Six& along) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) H[i][j] += factor * along[i] * along[j];
    }
  };
  for (const Cut& cut : m.cuts) {
    const double speed = Dot(cut.along, u);
    if (!(speed > 0)) continue;
    const double d = 1e-5 * speed;
    add(cut.teeth * (m.CalcTooth(speed + d, cut.bone) - m.CalcTooth(speed - d, cut.bone)) / (2 * d), cut.along);
  }
  for (const Wall& wall : m.walls) {
    if (wall.depth_mm + m.tau_s * Dot(wall.along, u) > 0) add(m.tau_s * wall.K, wall.along);
  }
  return H;
}

/// Solves (H + ridge) p = -g by Cholesky decomposition, with each unknown scaled to a diagonal of 1. Returns false if a
/// pivot vanishes.
bool Solve(const Matrix& H, const Six& g, double ridge, Six& p) {
  Six scale;
  for (int i = 0; i < 6; ++i) scale[i] = 1 / std::sqrt(H[i][i]);
  Matrix L{};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = H[i][j] * scale[i] * scale[j] + (i == j ? ridge : 0);
      for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (i != j) {
        L[i][j] = sum / L[j][j];
      } else if (sum > 1e-15) {
        L[i][i] = std::sqrt(sum);
      } else {
        return false;
      }
    }
  }
  for (int i = 0; i < 6; ++i) {
    double sum = -g[i] * scale[i];
    for (int k = 0; k < i; ++k) sum -= L[i][k] * p[k];
    p[i] = sum / L[i][i];
  }
  for (int i = 5; i >= 0; --i) {
    double sum = p[i];
    for (int k = i + 1; k < 6; ++k) sum -= L[k][i] * p[k];
    p[i] = sum / L[i][i];
  }
  for (int i = 0; i < 6; ++i) p[i] *= scale[i];
  return true;
}

/// Returns the step length along p, a descent direction with slope `slope_at_0`.
double FindAlpha(const MotionProblem& problem, const Six& u, const Six& p, double slope_at_0) {
  const double enough = kSlopeFraction * std::abs(slope_at_0);
  double low = 0;
  double high = 1;
  double slope = CalcSlope(problem, u, high, p);
  for (int i = 0; i < 20 && slope < -enough; ++i) {
    low = high;
    high *= 2;
    slope = CalcSlope(problem, u, high, p);
  }
  if (std::abs(slope) <= enough) return high;
  if (slope < 0) return high;
  double alpha = high;
  for (int i = 0; i < 60; ++i) {
    alpha = 0.5 * (low + high);
    slope = CalcSlope(problem, u, alpha, p);
    if (std::abs(slope) <= enough) break;
    (slope < 0 ? low : high) = alpha;
  }
  return alpha;
}

}  // namespace

double MotionProblem::CalcTooth(double speed_mm_per_s, const ToothCut& bone) const {
  if (!(speed_mm_per_s > 0)) return 0;
  const double force = law(speed_mm_per_s / passes_per_s, bone);
  return speed_mm_per_s < ramp_mm_per_s ? force * speed_mm_per_s / ramp_mm_per_s : force;
}

Six MotionProblem::CalcGradient(const Six& u) const {
  const Vec3 force = spring.Pull(x_mm - tau_s * Upper(u)) + damper.Pull(v_H - Upper(u));
  const Vec3 torque = torsion.Pull(theta_rad - tau_s * Lower(u)) + torsion_damper.Pull(w_H - Lower(u));
  Six g = Join(-force, -torque);
  for (const Cut& cut : cuts) {
    const double tooth = CalcTooth(Dot(cut.along, u), cut.bone);
    if (tooth > 0) g = Step(g, cut.teeth * tooth, cut.along);
  }
  for (const Wall& wall : walls) {
    const double depth_mm = wall.depth_mm + tau_s * Dot(wall.along, u);
    if (depth_mm > 0) g = Step(g, wall.K * depth_mm, wall.along);
  }
  return g;
}

Motion FindMinimum(const MotionProblem& problem, const Six& start, double reach_mm) {
  Motion motion;
  motion.u = start;
  for (; motion.iterations < kMaxIterations; ++motion.iterations) {
    const Six g = problem.CalcGradient(motion.u);
    const double force = glm::length(problem.spring.Pull(problem.x_mm - problem.tau_s * Upper(motion.u)));
    const double torque = glm::length(problem.torsion.Pull(problem.theta_rad - problem.tau_s * Lower(motion.u)));
    const double enough = kBalance * (1 + force + torque / reach_mm);
    if (glm::length(Upper(g)) <= enough && glm::length(Lower(g)) <= enough * reach_mm) {
      motion.settled = true;
      break;
    }
    const Matrix H = CalcCurvature(problem, motion.u);
    Six p{};
    double ridge = 0;
    while (!Solve(H, g, ridge, p)) ridge = ridge > 0 ? 10 * ridge : 1e-12;
    const double slope = Dot(g, p);
    if (!(slope < 0)) break;
    motion.u = Step(motion.u, FindAlpha(problem, motion.u, p, slope), p);
  }
  return motion;
}

}  // namespace kerf::reference
