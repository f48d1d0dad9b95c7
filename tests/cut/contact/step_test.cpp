// The convex step: its solution is the minimum for any initial guess, and it never creates energy.
#include "cut/contact/step.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <random>

#include "support/seeded_check.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

constexpr double kReach_mm = 11;

/// Makes problems over the whole range that scenes allow; magnitudes are log-uniform.
class ProblemMaker {
 public:
  explicit ProblemMaker(std::uint64_t seed) : random_(seed) {}

  double Uniform(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(random_); }
  double LogUniform(double lower, double upper) { return std::exp(Uniform(std::log(lower), std::log(upper))); }
  Vec3 InBall(double radius) {
    for (;;) {
      const Vec3 v(Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1));
      if (glm::dot(v, v) <= 1 && glm::dot(v, v) > 1e-3) return radius * v;
    }
  }
  Twist Motion(double speed) {
    const Vec3 v = InBall(speed);
    const Vec3 w = InBall(speed / kReach_mm);
    return {v.x, v.y, v.z, w.x, w.y, w.z};
  }

  StepProblem Make() {
    StepProblem problem;
    const char* laws[] = {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"};
    const int law = static_cast<int>(Uniform(0, 2.999));
    problem.law = MakeToothForce(ForceLaw(laws[law]), Tool(DiscSaw{}));
    problem.ramp_mm_per_s = law == 0 ? 0 : 0.02;
    problem.passes_per_s = LogUniform(100, 1e4);
    problem.tau_s = LogUniform(0.25e-3, 4e-3);
    problem.flat_stiffness_N_per_mm = LogUniform(10, 1e5);
    StepCoupling& c = problem.coupling;
    c.spring = {LogUniform(0.1, 1e3), LogUniform(1, 100)};
    c.torsion = {LogUniform(100, 1e6), LogUniform(100, 1e4)};
    if (Uniform(0, 1) < 0.5) {
      c.damper = {LogUniform(1e-4, 1), c.spring.limit};
      c.torsion_damper = {LogUniform(0.01, 1e3), c.torsion.limit};
    }
    c.x_mm = InBall(LogUniform(1e-3, 100));
    c.theta_rad = InBall(LogUniform(1e-5, 1.5));
    c.v_H_mm_per_s = InBall(LogUniform(0.1, 500));
    c.w_H_rad_per_s = InBall(LogUniform(0.01, 20));
    const int teeth = static_cast<int>(Uniform(0, 60));
    const double E_star = LogUniform(1e3, 1e6) * (Uniform(0, 1) < 0.1 ? 1e6 : 1);
    for (int i = 0; i < teeth; ++i) {
      const double a = Uniform(0, 6.28);
      const Vec3 e(std::cos(a), std::sin(a), 0);
      const double teeth_here = Uniform(0.01, 0.2);
      problem.cutting.push_back({MakeRow(e, kReach_mm * e), teeth_here, Cortical(E_star * Uniform(0.5, 1)),
                                 MakeRow({-e.y, e.x, 0}, kReach_mm * e), std::fmod(10 * teeth_here, 1)});
    }
    // In every other problem, a law with a jump is averaged over an arc of between a tiny angle and a tenth of a turn.
    if (law != 0 && teeth % 2 == 0) problem.arc_rad = std::pow(10.0, -0.2 - 0.1 * teeth);
    const int flats = static_cast<int>(Uniform(0, 80));
    for (int i = 0; i < flats; ++i) {
      const double side = Uniform(0, 1) < 0.5 ? -1 : 1;
      problem.flats.push_back({side, Uniform(-10, 10), Uniform(-10, 10), Uniform(-0.02, 0.002)});
    }
    const int solids = static_cast<int>(Uniform(0, 12));
    for (int i = 0; i < solids; ++i) {
      problem.solids.push_back(
          {MakeRow(glm::normalize(InBall(1)), InBall(kReach_mm)), Uniform(-0.05, 0.002), LogUniform(10, 1e4)});
    }
    const int frictions = static_cast<int>(Uniform(0, 16));
    for (int i = 0; i < frictions; ++i) {
      const Vec3 r = InBall(kReach_mm);
      problem.frictions.push_back({MakeRow({1, 0, 0}, r), MakeRow({0, 1, 0}, r), Uniform(-8000, 8000) * (i % 2),
                                   Uniform(-8000, 8000) * (i % 2), LogUniform(1e-3, 10)});
    }
    if (Uniform(0, 1) < 0.5) c.bending = {glm::normalize(InBall(1)), LogUniform(0.03, 1)};
    return problem;
  }

 private:
  std::mt19937_64 random_;
};

/// Returns the rise of J from 0 to u along a straight line, by Gauss-Legendre integration of its slope, which needs
/// only the gradient.
double CalcRise(const StepProblem& problem, const Twist& u, int pieces = 1000) {
  double sum = 0;
  for (int i = 0; i < pieces; ++i) {
    // Intervals are finer near 0, where the laws and friction are curved.
    const double t0 = std::pow(static_cast<double>(i) / pieces, 3);
    const double t1 = std::pow(static_cast<double>(i + 1) / pieces, 3);
    for (const double g : {-0.577350269189626, 0.577350269189626}) {
      const double t = 0.5 * (t0 + t1) + 0.5 * g * (t1 - t0);
      Twist at = u;
      for (double& x : at) x *= t;
      sum += 0.5 * (t1 - t0) * Dot(problem.CalcGradient(at), u);
    }
  }
  return sum;
}

double ForceOf(const StepProblem& problem) {
  const StepCoupling& c = problem.coupling;
  return 1 + glm::length(c.spring.Force(c.x_mm)) + glm::length(c.torsion.Force(c.theta_rad)) / kReach_mm +
         glm::length(c.damper.Force(c.v_H_mm_per_s)) + glm::length(c.torsion_damper.Force(c.w_H_rad_per_s)) / kReach_mm;
}

TEST(StepSolver, ForcesBalanceAtTheSolution) {
  const bool passed = test::CheckSeeded(20261120, 200, [](std::uint64_t seed) {
    ProblemMaker maker(seed);
    const StepProblem problem = maker.Make();
    StepSolver solver(128);
    const StepSolution solution = solver.Solve(problem, {}, kReach_mm, 1000);
    RC_ASSERT(solution.converged);
    const Twist g = problem.CalcGradient(solution.u);
    const double tolerance = 2e-8 * ForceOf(problem);  // the solver's tolerance for forces at the end of the step
    for (int k = 0; k < 3; ++k) RC_ASSERT(std::abs(g[k]) <= tolerance);
    for (int k = 3; k < 6; ++k) RC_ASSERT(std::abs(g[k]) <= tolerance * kReach_mm);
  });
  EXPECT_TRUE(passed);
}

// A start far from the solution and friction with limits of up to 1e6 N, whose force is steep within the creep speed:
// the rounding of a long way must not be taken for balance. What remains beyond the solver's tolerance is the rounding
// of the speeds at the solution itself: of six products and their sum.
TEST(StepSolver, ForcesBalanceAfterALongWayToSteepFriction) {
  int converged = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    ProblemMaker maker(seed);
    StepProblem problem = maker.Make();
    for (FrictionPoint& p : problem.frictions) {
      p.limit_N = maker.LogUniform(1e3, 1e6);
      p.slip_a_mm_per_s = p.slip_b_mm_per_s = 0;
    }
    StepSolver solver(128);
    const StepSolution solution = solver.Solve(problem, maker.Motion(maker.LogUniform(1e3, 1e6)), kReach_mm, 1000);
    if (!solution.converged) continue;
    ++converged;
    Twist allowed;
    for (int k = 0; k < 6; ++k) allowed[k] = 2e-8 * ForceOf(problem) * (k < 3 ? 1 : kReach_mm);
    for (const FrictionPoint& p : problem.frictions) {
      for (const Twist& row : {p.row_a, p.row_b}) {
        double size = 0;
        for (int k = 0; k < 6; ++k) size += std::abs(row[k] * solution.u[k]);
        const double rounding_N = 8 * 2.3e-16 * size * p.limit_N / problem.creep_mm_per_s;
        for (int k = 0; k < 6; ++k) allowed[k] += rounding_N * std::abs(row[k]);
      }
    }
    const Twist g = problem.CalcGradient(solution.u);
    for (int k = 0; k < 6; ++k) EXPECT_LE(std::abs(g[k]), allowed[k]) << "seed " << seed << ", component " << k;
  }
  EXPECT_GT(converged, 250);
}

TEST(StepSolver, SolutionIsTheMinimum) {
  const bool passed = test::CheckSeeded(20261120, 200, [](std::uint64_t seed) {
    ProblemMaker maker(seed);
    const StepProblem problem = maker.Make();
    StepSolver solver(128);
    const Twist u = solver.Solve(problem, {}, kReach_mm, 1000).u;
    for (int n = 0; n < 40; ++n) {
      // By convexity, J(v) - J(u) is at least the slope at u towards v, and because u is the minimum, the slope at v
      // towards u is not positive.
      const Twist step = maker.Motion(maker.LogUniform(1e-4, 1e3));
      Twist v = u;
      AddTo(v, 1, step);
      RC_ASSERT(Dot(problem.CalcGradient(v), step) >= -1e-6 * ForceOf(problem) * std::sqrt(Dot(step, step)));
    }
  });
  EXPECT_TRUE(passed);
}

TEST(StepSolver, SolutionDoesNotDependOnTheStart) {
  const bool passed = test::CheckSeeded(20261120, 200, [](std::uint64_t seed) {
    ProblemMaker maker(seed);
    const StepProblem problem = maker.Make();
    StepSolver solver(128);
    const StepSolution a = solver.Solve(problem, {}, kReach_mm, 1000);
    const StepSolution b = solver.Solve(problem, maker.Motion(maker.LogUniform(1e-3, 1e4)), kReach_mm, 1000);
    RC_ASSERT(b.converged);
    // Along every line, J is curved at least as much as the energy of the unsaturated coupling. If the coupling is
    // saturated, only the forces are unique, not the motion.
    const StepCoupling& c = problem.coupling;
    const double tau = problem.tau_s;
    const Vec3 v(a.u[0], a.u[1], a.u[2]);
    const Vec3 w(a.u[3], a.u[4], a.u[5]);
    if (c.spring.IsSaturated(c.bending.Scale(c.x_mm - tau * v)) || c.torsion.IsSaturated(c.theta_rad - tau * w)) return;
    const double force = 4e-8 * ForceOf(problem);
    const double stiffness = c.spring.stiffness * c.bending.factor * c.bending.factor;
    for (int k = 0; k < 3; ++k)
      RC_ASSERT(std::abs(a.u[k] - b.u[k]) <=
                2 * force / (tau * stiffness) + 2 * kReach_mm * force * kReach_mm / (tau * c.torsion.stiffness));
  });
  EXPECT_TRUE(passed);
}

TEST(StepSolver, CreatesNoEnergyWhenStoppedEarly) {
  const bool passed = test::CheckSeeded(20261120, 200, [](std::uint64_t seed) {
    ProblemMaker maker(seed);
    const StepProblem problem = maker.Make();
    StepSolver solver(128);
    for (const int bound : {1, 2, 3, 5, 8}) {
      const StepSolution solution = solver.Solve(problem, maker.Motion(maker.LogUniform(1e-2, 1e4)), kReach_mm, bound);
      RC_ASSERT(solution.iterations <= bound);
      const Twist g = problem.CalcGradient(solution.u);
      const double speed = std::sqrt(Dot(solution.u, solution.u)) * kReach_mm;
      RC_ASSERT(std::abs(Dot(g, solution.u)) <= 1e-6 * ForceOf(problem) * (speed + 1e-9));
      RC_ASSERT(CalcRise(problem, solution.u) <= 1e-6 * ForceOf(problem) * (speed + 1e-9));
    }
  });
  EXPECT_TRUE(passed);
}

TEST(StepSolver, OneToothAgainstASpringMatchesTheClosedForm) {
  // The closed form is K (x - tau v) = n F(v / f), with Hertz's law for the chip; its root is found by bisection.
  StepProblem problem;
  problem.law = MakeToothForce(ForceLaw("hertz_chip"), Tool(DiscSaw{}));
  problem.passes_per_s = 3000;
  problem.coupling.spring = {1.5, 1000};
  problem.coupling.torsion = {5000, 1e6};
  problem.cutting.push_back({MakeRow({0, 0, 1}, {0, 0, 0}), 3.2, 18000});
  for (const double x : {0.01, 0.5, 5.0, 20.0}) {
    problem.coupling.x_mm = {0, 0, x};
    double low = 0;
    double high = x / problem.tau_s;
    for (int n = 0; n < 200; ++n) {
      const double v = 0.5 * (low + high);
      const double bite = v / 3000;
      const double force = 3.2 * 4.0 / 3.0 * 18000 * std::sqrt(11.0) * bite * std::sqrt(bite);
      (1.5 * (x - problem.tau_s * v) > force ? low : high) = v;
    }
    StepSolver solver(4);
    const StepSolution solution = solver.Solve(problem, {}, kReach_mm, 40);
    EXPECT_TRUE(solution.converged);
    EXPECT_NEAR(solution.u[2] / low, 1, 1e-6);
    EXPECT_LE(solution.iterations, 12);
  }
}

}  // namespace
}  // namespace kerf
