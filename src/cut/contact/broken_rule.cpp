#include "cut/contact/broken_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/core/heap_guard.h"

namespace kerf {
namespace {

bool IsForce(double force_N) {
  return std::isfinite(force_N) && force_N >= 0;
}

bool IsFinite(const Twist& u) {
  return std::all_of(u.begin(), u.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

void BrokenRule::SetTick(std::uint64_t number) {
  const HeapGuardPause pause;
  message_ = fmt::format("tick {}: {}", number, message_);
}

void CheckForces(const StepProblem& problem, const Twist& u, const char* law) {
  for (const CuttingPoint& point : problem.cutting) {
    const double bite_mm = std::max(0.0, Dot(point.row, u)) / problem.passes_per_s;
    const auto check = [&](const char* what, double at_mm, double force_N) {
      if (IsForce(force_N)) return;
      const HeapGuardPause pause;
      throw BrokenRule(fmt::format(
          "the force law {} gives a {} of {:g} N at a bite of {:.3g} um in bone of {:.3g} GPa; a force must "
          "be finite and 0 or more",
          law, what, force_N, 1000 * at_mm, point.cut.E_MPa / 1000));
    };
    const auto check_at = [&](double at_mm) {
      check("thrust", at_mm, problem.law(at_mm, point.cut));
      if (problem.law.HasCutting()) check("cutting force", at_mm, problem.law.Cutting(at_mm, point.cut));
    };
    check_at(bite_mm);
    for (const BitePart& part : problem.bites) {
      check_at(part.bite * bite_mm);
      check_at(part.way_bite * bite_mm);
    }
  }
}

void CheckSolution(const StepProblem& problem, const StepSolution& solution, const Twist& start, const char* law) {
  const bool finite = IsFinite(solution.u);
  if (finite) CheckForces(problem, solution.u, law);
  if (finite && solution.converged) return;
  if (IsFinite(start)) CheckForces(problem, start, law);
  const Vec3 v = problem.coupling.x_mm / problem.tau_s, w = problem.coupling.theta_rad / problem.tau_s;
  CheckForces(problem, {v.x, v.y, v.z, w.x, w.y, w.z}, law);
  if (finite) return;
  const HeapGuardPause pause;
  throw BrokenRule(fmt::format("with the force law {} the tool's motion is {:g} mm/s; it must be finite", law,
                               std::hypot(solution.u[0], solution.u[1], solution.u[2])));
}

void ThrowBadSum(const StepProblem& problem, const Twist& u, double sum_N, const char* law) {
  CheckForces(problem, u, law);
  const HeapGuardPause pause;
  throw BrokenRule(
      fmt::format("the force law {} gives forces whose sum is {:g} N; it must be finite and 0 or more", law, sum_N));
}

void ThrowBrokenRule(const char* what, const char* name, const std::exception* thrown) {
  const HeapGuardPause pause;
  const char* why = thrown != nullptr ? thrown->what() : nullptr;
  throw BrokenRule(why != nullptr ? fmt::format("the {} {} threw an exception: {}", what, name, why)
                                  : fmt::format("the {} {} threw an exception", what, name));
}

}  // namespace kerf
