// Tests of kerf paper, run as a program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;

class Paper : public test::ProgramTest {};

// Returns the lines between the two markers, without the markers.
std::string FindBlock(const std::string& text) {
  const std::string begin = "<!-- kerf paper --markdown -->\n";
  const std::string end = "<!-- end -->\n";
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) return "no block";
  const std::size_t to = text.find(end, from);
  return to == std::string::npos ? "no end" : text.substr(from + begin.size(), to - from - begin.size());
}

std::vector<std::string> Split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
  return parts;
}

TEST_F(Paper, JsonHasThe24ForcesWithinTwoInTenThousand) {
  const ProgramResult result = Kerf("paper --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_EQ(json["forces"].size(), 24u);
  double largest = 0;
  for (const auto& force : json["forces"]) {
    const double printed = force["printed_N"].get<double>();
    const double computed = force["computed_N"].get<double>();
    EXPECT_NEAR(force["relative_difference"].get<double>(), computed / printed - 1, 1e-12);
    EXPECT_GT(force["corrected_N"].get<double>(), 0);
    largest = std::max(largest, std::abs(computed / printed - 1));
  }
  EXPECT_LE(largest, 2e-4);
  EXPECT_NEAR(json["largest_relative_difference"]["force"].get<double>(), largest, 1e-12);
  EXPECT_EQ(json["teeth_counts_that_differ"], 0);
  ASSERT_EQ(json["depths"].size(), 6u);
  for (const auto& row : json["depths"]) EXPECT_TRUE(row["arc"]["within_rounding"].get<bool>());
  ASSERT_EQ(json["regions"].size(), 4u);
  EXPECT_NEAR(json["regions"][0]["K"]["computed_m_per_cbrt_N"].get<double>(), 7.5539e-5, 5e-10);
  EXPECT_EQ(json["discrepancies"].size(), 5u);
  EXPECT_EQ(json["device_advice"]["teeth"], 8);
  EXPECT_NEAR(json["device_advice"]["computed_N"].get<double>(), 28.4, 0.05);
}

TEST_F(Paper, CsvHasARowPerForceWithTheSameValuesAsJson) {
  const auto json = nlohmann::json::parse(Kerf("paper --json").out);
  const std::vector<std::string> lines = Split(Kerf("paper --csv").out, '\n');
  ASSERT_EQ(lines.size(), 25u);
  const std::vector<std::string> names = Split(lines[0], ',');
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  for (std::size_t i = 0; i < 24; ++i) {
    const std::vector<std::string> cells = Split(lines[i + 1], ',');
    ASSERT_EQ(cells.size(), names.size());
    const auto& force = json["forces"][i];
    EXPECT_EQ(std::stod(cells[column("force_printed_N")]), force["printed_N"].get<double>());
    EXPECT_EQ(std::stod(cells[column("force_computed_N")]), force["computed_N"].get<double>());
    EXPECT_EQ(std::stod(cells[column("corrected_force_N")]), force["corrected_N"].get<double>());
    EXPECT_EQ(std::stoi(cells[column("region")]), force["region"].get<int>());
  }
}

TEST_F(Paper, TextShowsTablesDiscrepanciesAndThe28N) {
  const ProgramResult result = Kerf("paper");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("24         6.6     3.54596   3.54609   +3.6e-05"));
  EXPECT_THAT(result.out, HasSubstr("At least 28 N"));
  EXPECT_THAT(result.out, HasSubstr("28.4 N computed"));
  for (const char* number : {"1. 22 mm", "2. 24 teeth", "3. (1 - nu^2)/E", "4. the diameter", "5. radii added"}) {
    EXPECT_THAT(result.out, HasSubstr(number));
  }
  for (const std::string& line : Split(result.out, '\n')) EXPECT_LE(line.size(), 120u) << line;
}

TEST_F(Paper, TableInTheDocumentationMatchesTheProgram) {
  const ProgramResult result = Kerf("paper --markdown");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("| 3.54596 / 3.54609 |"));
  EXPECT_EQ(FindBlock(test::Slurp(KERF_SOURCE_DIR "/docs/paper.md")), result.out);
}

TEST_F(Paper, WritesOutputAndFigureToFiles) {
  const ProgramResult result = Kerf("paper --json -o paper.json --figure force.png");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(test::Slurp(folder_ / "paper.json"), Kerf("paper --json").out);
  const std::string png = test::Slurp(folder_ / "force.png");
  // Width and height are stored big-endian from byte 16 on: 1920 x 1080.
  ASSERT_GT(png.size(), 24u);
  EXPECT_EQ(png.substr(16, 8), std::string("\0\0\x07\x80\0\0\x04\x38", 8));
}

TEST_F(Paper, BadUsageIsRefused) {
  for (const char* arguments : {"paper --json --csv", "paper --json --markdown", "paper --csv --markdown", "paper x",
                                "paper --figure", "paper --tables"}) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
    EXPECT_NE(result.err, "") << arguments;
  }
  const ProgramResult nowhere = Kerf("paper -o none/a.txt");
  EXPECT_EQ(nowhere.code, 1);
  EXPECT_THAT(nowhere.err, HasSubstr("none/a.txt: can't be written"));
}

TEST_F(Paper, FigureThatIsNotAPngOrIsTheOutputIsBadUsage) {
  const ProgramResult text = Kerf("paper --figure a.txt");
  EXPECT_EQ(text.code, 2);
  EXPECT_THAT(text.err, HasSubstr("--figure: 'a.txt' must end in .png; see 'kerf paper --help'\n"));
  const ProgramResult same = Kerf("paper --figure a.png -o ./a.png");
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.err, HasSubstr("--figure: 'a.png' is the same file as that given by -o; see 'kerf paper --help'\n"));
  EXPECT_FALSE(Exists("a.png"));
}

}  // namespace
}  // namespace kerf
