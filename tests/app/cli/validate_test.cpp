// Tests of kerf validate as a user runs it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

class Validate : public test::ProgramTest {};

constexpr const char* kMeasuredSet = R"(title = "t"
citation = "c"
doi = ""
specimen = "s"
setup = "u"
licence = "l"
calibrated = []
[tool]
kind = "tooth"
width_mm = 0.64
[[value]]
quantity = "thrust_N"
bite_um = 5
value = 7.9
sd = 0.6
obtained = "read"
)";

// One law, because all take minutes; validation.EveryFigureIsRecomputed runs them all.
TEST_F(Validate, SetsOfAFolderAreAddedAndFailedRowsAreNoError) {
  std::filesystem::create_directory(folder_ / "sets");
  Write("sets/mine.toml", kMeasuredSet);
  const auto result = Kerf("validate -o out --json --laws edge_plus_chip --sets sets");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, test::Slurp(folder_ / "out/validate.json"));
  const auto json = nlohmann::json::parse(result.out);
  int rows = 0;
  for (const auto& row : json["values"]) rows += row["set"] == "mine";
  EXPECT_EQ(rows, 1);
  EXPECT_LT(json["counts"][0]["values_agree"], json["counts"][0]["values"]);
  for (const char* file : {"report.md", "values.csv", "trends.csv", "teeth.csv", "macavelia_2012_thrust_N.png"}) {
    EXPECT_TRUE(Exists(std::string("out/") + file)) << file;
  }
}

TEST_F(Validate, BadUsageIsRefusedInOneSentence) {
  auto result = Kerf("validate -o out --laws hertz");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--laws: there is no force law \"hertz\"; available: two_component, hertz_chip"));
  result = Kerf("validate --laws two_component none.toml -o out");  // one value: the scene is not a law
  EXPECT_THAT(result.err, HasSubstr("none.toml: there is no such file"));
  result = Kerf("validate -o out --sets none");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("kerf: cannot read the folder none: No such file or directory\n"));
  std::filesystem::create_directory(folder_ / "sets");
  result = Kerf("validate -o out --sets sets");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "kerf: the folder sets has no file with the extension .toml\n");
  Write("sets/mine.toml", std::string(kMeasuredSet) + "widht = 1\n");
  result = Kerf("validate -o out --sets sets");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("kerf: sets/mine.toml:17:1: unknown key \"widht\" in [[value]]; valid keys: "));
  EXPECT_FALSE(Exists("out/report.md"));
}

}  // namespace
}  // namespace kerf
