// Tests of kerf bench as a user runs it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using BenchCommand = test::ProgramTest;

TEST_F(BenchCommand, PrintsJsonOfTheRequestedCase) {
  const auto result = Kerf("bench tick --case ball-0.3 --ticks 20 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json["cases"].size(), 1u);
  EXPECT_EQ(json["cases"][0]["name"], "ball-0.3");
  EXPECT_EQ(json["cases"][0]["tick"]["ticks"], 20);
}

TEST_F(BenchCommand, SameHashAtEachWidth) {
  std::string hash;
  for (const char* width : {"ssse3", "scalar"}) {
    const auto result = Kerf(std::string("bench tick --case ball-0.3 --ticks 20 --json --width ") + width);
    if (result.code == 2) GTEST_SKIP() << "this machine has no " << width;
    ASSERT_EQ(result.code, 0) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["machine"]["vector_width"], width);
    const std::string this_hash = json["cases"][0]["bone_hash"];
    EXPECT_TRUE(hash.empty() || hash == this_hash);
    hash = this_hash;
  }
}

TEST_F(BenchCommand, WritesTheReportToAFile) {
  const auto result = Kerf("bench tick --case idle --ticks 30 --markdown -o bench.md");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(test::Slurp(folder_ / "bench.md").find("| case | what |"), 0u);
}

TEST_F(BenchCommand, RefusesInvalidArguments) {
  const auto unknown = Kerf("bench tick --case idel");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("there is no case \"idel\"; the nearest is \"idle\""), std::string::npos) << unknown.err;
  const auto wide = Kerf("bench tick --width avx9");
  EXPECT_EQ(wide.code, 2);
  EXPECT_NE(wide.err.find("this machine has no vector instructions \"avx9\"; it has "), std::string::npos) << wide.err;
  EXPECT_EQ(Kerf("bench tick --ticks 0").code, 2);
  EXPECT_EQ(Kerf("bench").code, 2);
  ExpectRefusal(Kerf("bench tick --case idle --ticks 5 --core 4000"),
                "can't pin this program to core 4000; choose a core that it is allowed to use");
}

}  // namespace
}  // namespace kerf
