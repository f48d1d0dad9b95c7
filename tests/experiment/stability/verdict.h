// Records the result of a hard case in the test's properties. tools/stability_table copies it to docs/stability.md.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace kerf::test {

/// Records a verdict. Declare one at the top of each test of tests/experiment/stability whose figures belong in the
/// document:
///
///   Verdict verdict("holds");  // the judgement; or "holds, but ...", "applies in part: ..."
///   verdict.AtMost("largest force step", step_N, 1, "N");
class Verdict {
 public:
  explicit Verdict(const std::string& judgement) { ::testing::Test::RecordProperty("verdict", judgement); }

  /// Asserts the bound and records the figure.
  void AtMost(const std::string& name, double value, double bound, const std::string& unit = "") {
    EXPECT_LE(value, bound) << name;
    Keep(fmt::format("{} {:.3g} (at most {:.3g}){}", name, value, bound, Space(unit)));
  }
  void AtLeast(const std::string& name, double value, double bound, const std::string& unit = "") {
    EXPECT_GE(value, bound) << name;
    Keep(fmt::format("{} {:.3g} (at least {:.3g}){}", name, value, bound, Space(unit)));
  }
  void Equal(const std::string& name, double value, double expected, const std::string& unit = "") {
    EXPECT_EQ(value, expected) << name;
    Keep(fmt::format("{} {:.6g} (exactly){}", name, value, Space(unit)));
  }
  /// Records a figure without a bound.
  void Note(const std::string& name, double value, const std::string& unit = "") {
    Keep(fmt::format("{} {:.3g}{}", name, value, Space(unit)));
  }

 private:
  static std::string Space(const std::string& unit) { return unit.empty() ? "" : " " + unit; }
  void Keep(const std::string& text) { ::testing::Test::RecordProperty(fmt::format("figure_{:02}", ++count_), text); }
  int count_ = 0;
};

/// Returns the factor for the amount of work: 1, or the value of KERF_STABILITY_EFFORT (a tenth under the sanitizers,
/// 20 in a soak test). It is used for numbers of ticks, seeds and search rounds, never for bounds.
inline double Effort() {
  const char* asked = std::getenv("KERF_STABILITY_EFFORT");
  const double effort = asked ? std::atof(asked) : 1;
  return effort > 0 ? effort : 1;
}

}  // namespace kerf::test
