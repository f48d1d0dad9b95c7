// What a hard case was found to be: kept with the test's result, from where tools/stability_table takes it into
// docs/stability.md.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace kerf::test {

/// At the top of each test of tests/experiment/stability whose figures belong into the document.
///   Verdict verdict("holds");                       or "holds, but ...", "applies in part: ...": the judgement of the
///   case verdict.AtMost("largest force step", step_N, 1, "N");
class Verdict {
 public:
  explicit Verdict(const std::string& judgement) { ::testing::Test::RecordProperty("verdict", judgement); }

  /// Asserts the bound and keeps the figure.
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
  /// A figure with nothing to hold it against.
  void Note(const std::string& name, double value, const std::string& unit = "") {
    Keep(fmt::format("{} {:.3g}{}", name, value, Space(unit)));
  }

 private:
  static std::string Space(const std::string& unit) { return unit.empty() ? "" : " " + unit; }
  void Keep(const std::string& text) { ::testing::Test::RecordProperty(fmt::format("figure_{:02}", ++count_), text); }
  int count_ = 0;
};

/// How many times the usual work: 1, or what KERF_STABILITY_EFFORT says (a tenth under the sanitizers, 20 in a soak).
/// For counts of ticks, seeds and rounds of a search; never for bounds.
inline double Effort() {
  const char* asked = std::getenv("KERF_STABILITY_EFFORT");
  const double effort = asked ? std::atof(asked) : 1;
  return effort > 0 ? effort : 1;
}

}  // namespace kerf::test
