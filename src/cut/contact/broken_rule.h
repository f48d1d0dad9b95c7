// Faults of a force law or an effect of another program that appear only in a tick: it throws, or gives a number that
// cannot be used. kerf checks a law when it is registered, but not for every cut.
#pragma once

#include <cstdint>
#include <exception>
#include <string>

#include "cut/contact/step.h"
#include "kerf/error.h"

namespace kerf {

/// Thrown out of a tick. The message is a sentence that names the tick and the law or the effect.
class BrokenRule final : public Error {
 public:
  explicit BrokenRule(const std::string& fault) : Error(fault), message_(fault) {}
  const char* what() const noexcept override { return message_.c_str(); }
  /// Puts the number of the tick, counted from 1, into the message.
  void SetTick(std::uint64_t number);

 private:
  std::string message_;
};

/// Throws BrokenRule if the law gives a tooth at one of the points, which move as `u` says, a force that is not finite,
/// or below 0. Tick-safe if it does not throw.
void CheckForces(const StepProblem& problem, const Twist& u, const char* law);
/// Does the same for the solution `u` of a step, which may itself be the result of such forces: if it is not a
/// solution, it also checks the motion from which the search began and that of the handle.
void CheckSolution(const StepProblem& problem, const StepSolution& solution, const Twist& start, const char* law);
/// Does the same, and throws in any case: for forces whose sum cannot be used.
[[noreturn]] void ThrowBadSum(const StepProblem& problem, const Twist& u, double sum_N, const char* law);

/// Throws BrokenRule, such as "the effect x threw an exception: ...". `thrown`: null if it is no std::exception.
[[noreturn]] void ThrowBrokenRule(const char* what, const char* name, const std::exception* thrown);

/// Calls functions of another program. `what`: "force law" or "effect". Throws BrokenRule if they throw.
template <typename Call>
auto CallOwn(const char* what, const char* name, Call&& call) {
  try {
    return call();
  } catch (const BrokenRule&) {
    throw;
  } catch (const std::exception& e) {
    ThrowBrokenRule(what, name, &e);
  } catch (...) {
    ThrowBrokenRule(what, name, nullptr);
  }
}

}  // namespace kerf
