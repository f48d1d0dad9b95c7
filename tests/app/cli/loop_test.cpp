// Tests of kerf loop, run as a program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::HasSubstr;

const std::string kLoopScene = test::BlockToml({6, 4, 3}, 0.25) + test::SawToml(12, 0.5, 16) +
                               test::StrokeToml({0, 0, 6.5}, {0, 0, 0.5}, 6, {1, 0, 0});

class Loop : public test::ProgramTest {
 protected:
  Loop() : ProgramTest({{"s.toml", kLoopScene}}) {}
};

TEST_F(Loop, TitleIsEscapedInTheReport) {
  Write("a<b>.toml", std::string("title = \"<script>alert(1)</script> | [x](y)\"\n") + kLoopScene);
  ASSERT_EQ(Kerf("loop 'a<b>.toml' --virtual --seconds 0.1 -o out").code, 0);
  const std::string report = test::Slurp(folder_ / "out" / "report.md");
  EXPECT_THAT(report, HasSubstr("# &lt;script&gt;alert(1)&lt;/script&gt; \\| \\[x\\](y)\n"));
  EXPECT_THAT(report, HasSubstr("a&lt;b&gt; with"));
  EXPECT_THAT(report, testing::Not(HasSubstr("<")));
}

TEST_F(Loop, VirtualTimeIsReproducible) {
  const ProgramResult a = Kerf("loop s.toml --seconds 1 --virtual --hand h2 --rate-hz 2000 --json");
  ASSERT_EQ(a.code, 0) << a.err;
  EXPECT_EQ(a.err, "");  // no warnings
  const ProgramResult b = Kerf("loop s.toml --seconds 1 --virtual --hand H2 --rate-hz 2000 --json");
  Json first = Json::parse(a.out);
  Json second = Json::parse(b.out);
  first["ticks"].erase("wall_s");
  second["ticks"].erase("wall_s");
  EXPECT_EQ(first, second);
  EXPECT_EQ(first["hand"], "H2");
  EXPECT_EQ(first["ticks"]["count"], 2000);
  EXPECT_GT(first["removed_mm3"], 0.5);
  EXPECT_EQ(first["force"]["not_finite"], 0);
}

TEST_F(Loop, LiveLoopReportsSchedulingAndLateness) {
  const ProgramResult result = Kerf("loop s.toml --seconds 0.3 -o out");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("SCHED_FIFO was "));
  EXPECT_THAT(result.out, HasSubstr("emory"));
  EXPECT_THAT(result.out, HasSubstr("p99.9"));
  EXPECT_THAT(result.out, HasSubstr("lateness"));
  EXPECT_THAT(result.out, HasSubstr("bit-identical"));
  for (const char* name : {"report.md", "loop.json", "forces.csv", "lateness.png", "force.png", "scene.toml"}) {
    EXPECT_TRUE(Exists(std::string("out/") + name)) << name;
  }
}

TEST_F(Loop, RefusesInvalidInput) {
  EXPECT_EQ(Kerf("loop s.toml --hand H7").code, 2);
  EXPECT_EQ(Kerf("loop s.toml --rate-hz 5000").code, 2);
  EXPECT_EQ(Kerf("loop s.toml --seconds 0").code, 2);
  EXPECT_EQ(Kerf("loop none.toml").code, 1);
  const ProgramResult over = Kerf("loop s.toml --seconds 0.1 --virtual -o .");
  EXPECT_EQ(over.code, 0) << over.err;  // allowed: s.toml is not scene.toml
  Write("scene.toml", kLoopScene);
  const ProgramResult same = Kerf("loop scene.toml --seconds 0.1 --virtual -o .");
  EXPECT_EQ(same.code, 1);
  EXPECT_THAT(same.err, HasSubstr("scene.toml"));
}

TEST_F(Loop, ControlCEndsItWithAReport) {
  // On a busy machine the signal may arrive before the loop begins. Then the program just ends, and a later signal is
  // tried.
  ProgramResult result;
  for (const char* seconds : {"2", "8", "30"}) {
    result = KerfWithin(std::string("timeout --preserve-status -s INT ") + seconds, "loop s.toml --seconds 600");
    if (result.code != 130) break;
  }
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("removed"));
}

}  // namespace
}  // namespace kerf
