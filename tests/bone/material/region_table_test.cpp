#include "bone/material/region_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "kerf/error.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

const std::string kHeader = "id,name,tissue,E_GPa,nu,estimate,source\n";

std::string ErrorOfTable(const std::string& text) {
  return test::MessageOf([&] { ParseRegionTable(text, "t.csv"); }, "accepted");
}

void ExpectEqual(const MaterialTable& a, const MaterialTable& b) {
  ASSERT_EQ(a.regions().size(), b.regions().size());
  for (const auto& [id, r] : a.regions()) {
    ASSERT_TRUE(b.Contains(id));
    const Region& s = b.At(id);
    EXPECT_EQ(r.name, s.name);
    EXPECT_EQ(r.tissue, s.tissue);
    EXPECT_EQ(r.E_MPa, s.E_MPa) << id;  // bit-identical
    EXPECT_EQ(r.nu, s.nu);
    EXPECT_EQ(r.estimate, s.estimate);
    EXPECT_EQ(r.source, s.source);
    EXPECT_EQ(r.E_lower_MPa, s.E_lower_MPa) << id;
    EXPECT_EQ(r.E_upper_MPa, s.E_upper_MPa) << id;
  }
}

TEST(RegionTable, EveryBadRowIsNamedWithFileAndLine) {
  struct Case {
    std::string text;
    std::string message;
  };
  const Case cases[] = {
      {"", "t.csv: no header; it must be id,name,tissue,E_GPa,nu,estimate,source"},
      {"# only a comment\n", "t.csv: no header; it must be id,name,tissue,E_GPa,nu,estimate,source"},
      {kHeader, "t.csv: no region below the header"},
      {"id,name,tissue,E_Gpa,nu,estimate,source\n", "t.csv:1: unknown column \"E_Gpa\"; did you mean \"E_GPa\"?"},
      {"id,name,tissue,E_GPa,nu,estimate,sauce\n", "t.csv:1: unknown column \"sauce\"; did you mean \"source\"?"},
      {"id,name,tissue,E_GPa,nu,estimate,source,density_g_cm3\n",
       "t.csv:1: unknown column \"density_g_cm3\"; the columns are id,name,tissue,E_GPa,nu,estimate,source and, "
       "optionally, E_lower_GPa,E_upper_GPa"},
      {"id,name,tissue,E_GPa,nu,estimate,source,nu\n", "t.csv:1: column \"nu\" is given twice"},
      {"\nid,name,tissue,E_GPa,estimate,source\n",
       "t.csv:2: column \"nu\" is missing; the header must be id,name,tissue,E_GPa,nu,estimate,source"},
      {kHeader + "1,a,cortical,19,0.3,yes\n",
       "t.csv:2: 6 fields instead of 7; a field with a comma must be in double quotes"},
      {kHeader + "1,a,cortical,19,0.3,yes,Smith, 1999\n",
       "t.csv:2: 8 fields instead of 7; a field with a comma must be in double quotes; if the numbers have decimal "
       "commas, save the table again with decimal points"},
      {kHeader + "1,a,cortical,19,0.3,yes,\"Smith\n",
       "t.csv:2: a field begins with a double quote that does not end on this line"},
      {kHeader + "1,\"a\"b,cortical,19,0.3,yes,s\n",
       "t.csv:2: text after a closing double quote; write a quote within a field as \"\""},
      {kHeader + "one,a,cortical,19,0.3,yes,s\n", "t.csv:2: id = \"one\" is not a whole number from 1 to 255"},
      {kHeader + "1.5,a,cortical,19,0.3,yes,s\n", "t.csv:2: id = \"1.5\" is not a whole number from 1 to 255"},
      {kHeader + "0,a,cortical,19,0.3,yes,s\n", "t.csv:2: region: id = 0 is below 1; valid range 1 to 255"},
      {kHeader + "256,a,cortical,19,0.3,yes,s\n", "t.csv:2: region: id = 256 is above 255; valid range 1 to 255"},
      {kHeader + "99999999999999999999,a,cortical,19,0.3,yes,s\n",
       "t.csv:2: id = \"99999999999999999999\" is not a whole number from 1 to 255"},
      {kHeader + "1,,cortical,19,0.3,yes,s\n", "t.csv:2: name is empty"},
      {kHeader + "1,a,bone,19,0.3,yes,s\n",
       "t.csv:2: tissue = \"bone\" is not one of cortical, cancellous, tooth, canal, other, metal, lesion"},
      {kHeader + "1,a,cortical,stiff,0.3,yes,s\n", "t.csv:2: E_GPa = \"stiff\" is not a number"},
      {kHeader + "1,a,cortical,19 GPa,0.3,yes,s\n", "t.csv:2: E_GPa = \"19 GPa\" is not a number"},
      {kHeader + "1,a,cortical,nan,0.3,yes,s\n", "t.csv:2: E_GPa = \"nan\" is not a number"},
      {kHeader + "1,a,cortical,inf,0.3,yes,s\n", "t.csv:2: E_GPa = \"inf\" is not a number"},
      {kHeader + "1,a,cortical,1e,0.3,yes,s\n", "t.csv:2: E_GPa = \"1e\" is not a number"},
      {kHeader + "1,a,cortical,1e400,0.3,yes,s\n", "t.csv:2: E_GPa = \"1e400\" is not a number"},
      {kHeader + "1,a,cortical,,0.3,yes,s\n", "t.csv:2: E_GPa = \"\" is not a number"},
      {kHeader + "1,a,cortical,0,0.3,yes,s\n", "t.csv:2: region 1: E = 0 GPa must be above 0 and at most 10000"},
      {kHeader + "1,a,cortical,-3,0.3,yes,s\n", "t.csv:2: region 1: E = -3 GPa must be above 0 and at most 10000"},
      {kHeader + "1,a,cortical,19300,0.3,yes,s\n",
       "t.csv:2: region 1: E = 19300 GPa must be above 0 and at most 10000"},
      {kHeader + "1,a,cortical,19,0.6,yes,s\n", "t.csv:2: region 1: nu = 0.6 is above 0.5; valid range 0 to 0.5"},
      {kHeader + "1,a,cortical,19,nan,yes,s\n", "t.csv:2: nu = \"nan\" is not a number"},
      {kHeader + "1,a,cortical,19,0.3,maybe,s\n", "t.csv:2: estimate = \"maybe\" is neither yes nor no"},
      {kHeader + "1,a,cortical,19,0.3,yes,\n", "t.csv:2: source is empty; state where the numbers come from"},
      {kHeader + "# a comment\n\n1,a,cortical,19,0.3,yes,s\n1,b,cortical,20,0.3,yes,s\n",
       "t.csv:5: region 1 is given twice"},
      {kHeader + std::string("1,a\0,cortical,19,0.3,yes,s\n", 27), "t.csv:2: the line is not text"},
  };
  for (const Case& c : cases) EXPECT_EQ(ErrorOfTable(c.text), c.message) << c.text;
}

TEST(RegionTable, EveryBadIntervalIsNamedWithFileAndLine) {
  const std::string header =
      "id,name,tissue,E_GPa,nu,estimate,source,E_lower_GPa,E_upper_GPa\n1,a,cortical,19,0.3,yes,s,";
  const std::pair<const char*, const char*> cases[] = {
      {"10,", "t.csv:2: region 1: give both E_lower_GPa and E_upper_GPa, or neither"},
      {",30", "t.csv:2: region 1: give both E_lower_GPa and E_upper_GPa, or neither"},
      {"10", "t.csv:2: 8 fields instead of 9; a field with a comma must be in double quotes"},
      {"ten,30", "t.csv:2: E_lower_GPa = \"ten\" is not a number"},
      {"10,nan", "t.csv:2: E_upper_GPa = \"nan\" is not a number"},
      {"0,30", "t.csv:2: region 1: E_lower_GPa must be above 0"},
      {"10,30000", "t.csv:2: region 1: E_upper_GPa must be at most 10000"},
      {"20,30", "t.csv:2: region 1: E = 19 GPa must lie in its interval, 20 to 30 GPa"},
      {"10,18", "t.csv:2: region 1: E = 19 GPa must lie in its interval, 10 to 18 GPa"},
      {"30,10", "t.csv:2: region 1: E = 19 GPa must lie in its interval, 30 to 10 GPa"}};
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(ErrorOfTable(header + text + "\n"), testing::StartsWith(message)) << text;
  }
  // One column alone states no interval, but is refused if it has a value.
  const std::string half = "id,name,tissue,E_GPa,nu,estimate,source,E_upper_GPa\n1,a,cortical,19,0.3,yes,s,";
  EXPECT_EQ(ErrorOfTable(half + "30\n"), "t.csv:2: region 1: give both E_lower_GPa and E_upper_GPa, or neither");
}

TEST(RegionTable, IntervalsAreOptionalAndWrittenOnlyIfThereIsOne) {
  const std::string both = "E_upper_GPa,id,name,tissue,E_GPa,nu,estimate,source,E_lower_GPa\n";
  const MaterialTable table =
      ParseRegionTable(both + "30,1,a,cortical,19,0.3,yes,s,10\n,2,b,cortical,19,0.3,yes,s,\n", "t.csv");
  EXPECT_EQ(table.At(1).E_lower_MPa, 10000);
  EXPECT_EQ(table.At(1).E_upper_MPa, 30000);
  EXPECT_TRUE(table.At(1).has_interval());
  EXPECT_FALSE(table.At(2).has_interval());
  EXPECT_EQ(FormatRegionTable(table),
            "id,name,tissue,E_GPa,nu,estimate,source,E_lower_GPa,E_upper_GPa\n1,a,cortical,19,0.3,yes,s,10,30\n"
            "2,b,cortical,19,0.3,yes,s,,\n");
  const MaterialTable uniform = MakeUniformTable(table, 50000, 0.3);  // outside the interval, which no longer applies
  EXPECT_FALSE(uniform.At(1).has_interval());
  EXPECT_EQ(FormatRegionTable(uniform).find("E_lower_GPa"), std::string::npos);
}

TEST(RegionTable, ColumnsMayComeInAnyOrderWithQuotesCommentsAndCarriageReturns) {
  const MaterialTable table = ParseRegionTable(
      "\xEF\xBB\xBF# mine\r\nname,id,nu,E_GPa,tissue,source,estimate\r\n\r\n \"a, \"\"b\"\" \" , 7 "
      ",0.25,2.05e1,tooth,s,no",
      "t.csv");
  const Region& r = table.At(7);
  EXPECT_EQ(r.name, "a, \"b\" ");
  EXPECT_EQ(r.tissue, Tissue::kTooth);
  EXPECT_EQ(r.E_MPa, 20500);
  EXPECT_EQ(r.nu, 0.25);
  EXPECT_FALSE(r.estimate);
}

TEST(RegionTable, RoundTripIsBitIdentical) {
  ExpectEqual(DefaultMandibleTable(), ParseRegionTable(FormatRegionTable(DefaultMandibleTable()), "t.csv"));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-3, 6.9);
  std::uniform_real_distribution<double> nu(0, 0.5);
  MaterialTable table;
  for (int id = 1; id <= 255; ++id) {
    Region region{id,
                  id % 2 ? "plain" : "with, comma and \"quote\"",
                  Tissue::kOther,
                  std::pow(10, exponent(random)),
                  nu(random),
                  id % 3 == 0,
                  id % 5 ? "s" : "# not a comment"};
    if (id % 4 == 0) {
      region.E_lower_MPa = 0.7 * region.E_MPa;
      region.E_upper_MPa = 1.1 * region.E_MPa;
    }
    table.Add(std::move(region));
  }
  ExpectEqual(table, ParseRegionTable(FormatRegionTable(table), "t.csv"));
}

TEST(RegionTable, BuiltInTableMatchesTheFile) {
  std::ifstream file(KERF_SOURCE_DIR "/volumes/mandible_regions.csv");
  std::stringstream text;
  text << file.rdbuf();
  ExpectEqual(DefaultMandibleTable(), ParseRegionTable(text.str(), "t.csv"));
}

TEST(RegionTable, OnlyThePapersFourRowsAreExactAndNotEstimates) {
  const MaterialTable& table = DefaultMandibleTable();
  const struct {
    int id;
    double E_MPa;
    double nu;
  } paper[] = {{24, 19300, 0.28}, {21, 20500, 0.25}, {13, 19300, 0.25}, {6, 17300, 0.38}};
  for (const auto& row : paper) {
    EXPECT_EQ(table.At(row.id).E_MPa, row.E_MPa);
    EXPECT_EQ(table.At(row.id).nu, row.nu);
    EXPECT_FALSE(table.At(row.id).estimate);
    EXPECT_THAT(table.At(row.id).source, testing::HasSubstr("Table 1"));
  }
  ASSERT_EQ(table.regions().size(), 34u);
  for (const auto& [id, region] : table.regions()) {
    const bool printed = id == 24 || id == 21 || id == 13 || id == 6;
    EXPECT_EQ(region.estimate, !printed) << id;
    EXPECT_EQ(region.source.starts_with("Estimate"), !printed) << id;
    EXPECT_EQ(region.tissue == Tissue::kCortical, id <= 31) << id;
    EXPECT_EQ(region.has_interval(), id <= 31 || id == kCancellousRegion) << id;
    // Over all sites and directions, Schwartz-Dabney and Dechow measured 10 to 30 GPa.
    if (id <= 31) {
      EXPECT_GE(region.E_MPa, 10000) << id;
      EXPECT_LE(region.E_MPa, 30000) << id;
      EXPECT_EQ(region.E_lower_MPa, 10000) << id;
      EXPECT_EQ(region.E_upper_MPa, 30000) << id;
    }
  }
  EXPECT_EQ(table.At(kCancellousRegion).tissue, Tissue::kCancellous);
  EXPECT_EQ(table.At(kToothRegion).tissue, Tissue::kTooth);
  EXPECT_EQ(table.At(kCanalRegion).tissue, Tissue::kCanal);
}

}  // namespace
}  // namespace kerf
