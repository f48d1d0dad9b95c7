// A force law that is nonzero at the smallest bite is averaged over the arc that an edge point represents. The average
// is compared with the integral over that arc, and tested as the gradient of a convex function.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "cut/contact/step.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

constexpr double kArm_mm = 11;

CuttingPoint PointAt(double angle, double after_fraction) {
  const Vec3 e(std::cos(angle), std::sin(angle), 0);
  return {MakeRow(e, kArm_mm * e), 0.05, Cortical(19140), MakeRow({-e.y, e.x, 0}, kArm_mm * e), after_fraction};
}

StepProblem MakeProblem(const char* law, double arc_rad, double ramp_mm_per_s) {
  StepProblem problem;
  problem.law = MakeToothForce(ForceLaw(law), Tool(DiscSaw{}));
  problem.passes_per_s = 3000;
  problem.arc_rad = arc_rad;
  problem.ramp_mm_per_s = ramp_mm_per_s;
  return problem;
}

/// Computes the radial force and the force along the edge with the midpoint rule over the arc, for the constant law
/// with its ramp, at the speed s + t phi; the teeth behind and ahead of the point are weighted by their fractions.
ToothMean Integrate(const StepProblem& problem, const CuttingPoint& point, double s, double t) {
  constexpr int kIntervals = 20000;
  ToothMean mean;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = problem.arc_rad * ((i + 0.5) / kIntervals - 0.5);
    const double weight = 2 * (phi < 0 ? 1 - point.after_fraction : point.after_fraction) / kIntervals;
    const double force = problem.ToothForceAt(s + t * phi, point.cut);
    mean.radial_N += weight * force;
    mean.along_N += weight * phi * force;
  }
  return mean;
}

TEST(Onset, MeanForceEqualsTheIntegralOverTheArc) {
  std::mt19937_64 random(20261122);
  const auto uniform = [&](double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random);
  };
  for (int n = 0; n < 300; ++n) {
    const double ramp = n % 3 == 0 ? 0 : 0.02;
    const StepProblem problem = MakeProblem("hertz_constant_bite", uniform(0.005, 0.1), ramp);
    const CuttingPoint point = PointAt(uniform(0, 6), uniform(0, 1));
    const double t = uniform(-8, 8);
    const double s = uniform(-1.2, 1.5) * (0.5 * problem.arc_rad * std::abs(t) + ramp);
    const ToothMean expected = Integrate(problem, point, s, t);
    const ToothMean mean = problem.MeanToothForce(point, s, t);
    // The midpoint rule locates the jump to within half an interval, an error of 1e-4 of the force and of its lever
    // arm.
    const double onset = CalcOnset(problem.law, point.cut);
    EXPECT_NEAR(mean.radial_N, expected.radial_N, 2e-4 * onset) << "s " << s << ", t " << t;
    EXPECT_NEAR(mean.along_N, expected.along_N, 2e-4 * onset * problem.arc_rad) << "s " << s << ", t " << t;
  }
}

TEST(Onset, SmoothLawIsUnchanged) {
  const StepProblem problem = MakeProblem("hertz_chip", 0.05, 0);
  for (const double s : {-0.1, 0.0, 1e-9, 0.03, 2.0}) {
    const ToothMean mean = problem.MeanToothForce(PointAt(1, 0.3), s, 4);
    EXPECT_EQ(mean.radial_N, problem.ToothForceAt(s, Cortical(19140)));
    EXPECT_EQ(mean.along_N, 0);
  }
}

TEST(Onset, ForceNeverDrivesTheToolAndIsMonotone) {
  // For the gradient g of a convex function that is 0 at rest, (g(u) - g(v)) . (u - v) >= 0, and therefore g(u) . u >=
  // 0.
  std::mt19937_64 random(20261122);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 2000; ++n) {
    StepProblem problem = MakeProblem(n % 2 == 0 ? "edge_plus_chip" : "hertz_constant_bite", 0.08, 0.02);
    problem.cutting.push_back(PointAt(0.003 * n, 0.5 + 0.4 * std::sin(n)));
    const auto motion = [&] {
      Twist u{};
      for (int k = 0; k < 3; ++k) u[k] = normal(random);
      for (int k = 3; k < 6; ++k) u[k] = normal(random) / kArm_mm;
      // This motion is close to the one at which the point stops moving outwards.
      AddTo(u, -Dot(problem.cutting[0].row, u) * (1 + 0.05 * normal(random)) / 2, problem.cutting[0].row);
      return u;
    };
    const Twist u = motion();
    const Twist v = motion();
    Twist step = u;
    AddTo(step, -1, v);
    Twist change = problem.CalcGradient(u);
    AddTo(change, -1, problem.CalcGradient(v));
    EXPECT_GE(Dot(change, step), -1e-12);
    EXPECT_GE(Dot(problem.CalcGradient(u), u), -1e-12);
  }
}

}  // namespace
}  // namespace kerf
