// The scenarios on the default block and device, and on subjects made bad on purpose.
#include "stability/scenarios.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>

#include "held_block.h"
#include "verdict.h"

namespace kerf {
namespace {

StabilitySubject MakeSubject() {
  StabilitySubject subject;
  subject.bone = test::BlockOfBone(0.2);
  subject.setup = test::HeldBlock("omega_6", "H3");
  subject.X_WT_start = test::OverBlock();
  return subject;
}

void Print(const ScenarioResult& result, double seconds) {
  fmt::print("{} {:.2f} s: {}{}\n", result.name, seconds, result.what, result.holds() ? "" : "  FAILS");
  for (const StabilityFigure& f : result.figures) {
    fmt::print("    {} {} {:.4g} {} {:.4g} {}\n", f.holds() ? " " : "!", f.name, f.value,
               f.at_most ? "<=" : ">=", f.bound, f.unit);
  }
}

TEST(Scenarios, AllHoldOnTheDefaultBlockWithTheDefaultDevice) {
  const StabilitySubject subject = MakeSubject();
  for (const Scenario& scenario : Scenarios()) {
    const auto begun = std::chrono::steady_clock::now();
    const ScenarioResult result = scenario.run(subject, 1);
    Print(result, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    EXPECT_TRUE(result.holds()) << scenario.name;
  }
}

}  // namespace
}  // namespace kerf
