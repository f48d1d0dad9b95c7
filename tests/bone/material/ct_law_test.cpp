// Laws from CT number to density to modulus: values computed by hand, borders and ranges, laws as text, and damaged
// files.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "bone/material/ct_law_table.h"
#include "bone/material/region_table.h"
#include "kerf/error.h"
#include "kerf/material.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

using testing::StartsWith;

const CtLaw& Law(const char* name) {
  return FindCtLaw(DefaultCtLaws(), name);
}

TEST(CtLaw, ModulusFollowsThePowerLawOfItsBand) {
  // The expected values were computed by hand, to the digits given here.
  const CtLaw& matmap = Law("mandible_matmap");
  EXPECT_NEAR(CalcModulus(matmap, 1.0), 1157.1, 1e-9);
  EXPECT_NEAR(CalcModulus(matmap, 0.8), 777.8056, 1e-4);   // 1157.1 * exp(1.78 * ln 0.8) = 1157.1 * 0.672203
  EXPECT_NEAR(CalcModulus(matmap, 2.14), 13514.65, 0.01);  // 2017.3 * 2.14^2 * sqrt(2.14) = 2017.3 * 4.5796 * 1.462874
  EXPECT_NEAR(CalcModulus(Law("morgan_2003_vertebra"), 0.25), 544.061, 1e-3);      // 4730 / 4^1.56 = 4730 / 8.693879
  EXPECT_NEAR(CalcModulus(Law("morgan_2003_tibia"), 0.25), 1066.782, 1e-3);        // 15490 / 4^1.93 = 15490 / 14.52031
  EXPECT_NEAR(CalcModulus(Law("morgan_2003_trochanter"), 0.25), 730.954, 1e-3);    // 15010 / 4^2.18 = 15010 / 20.53481
  EXPECT_NEAR(CalcModulus(Law("morgan_2003_femoral_neck"), 0.5), 2438.686, 1e-3);  // 6850 / 2^1.49 = 6850 / 2.80889
}

TEST(CtLaw, DensityOnABorderBelongsToTheUpperBand) {
  const CtLaw& matmap = Law("mandible_matmap");
  const double below = std::nextafter(1.8, 0.0);
  // 1157.1 * 1.8^1.78 and 2017.3 * 1.8^2.5 are the two ends of this law's known jump from 3.29 to 8.77 GPa.
  EXPECT_NEAR(CalcModulus(matmap, below), 3294.245, 1e-3);
  EXPECT_NEAR(CalcModulus(matmap, 1.8), 8769.034, 1e-3);
  // E is constant beyond both ends.
  EXPECT_EQ(CalcModulus(matmap, 0.1), CalcModulus(matmap, 0.8));
  EXPECT_EQ(CalcModulus(matmap, -3), CalcModulus(matmap, 0.8));
  EXPECT_EQ(CalcModulus(matmap, 7), CalcModulus(matmap, 2.8));
}

TEST(CtLaw, DensityIsLinearBetweenCalibrationPointsAndClampedBeyond) {
  const CtLaw& matmap = Law("mandible_matmap");
  EXPECT_EQ(CalcDensity(matmap, -1000), 0.001);
  EXPECT_EQ(CalcDensity(matmap, 2000), 2.14);
  EXPECT_EQ(CalcDensity(matmap, 3000), 2.8);
  EXPECT_NEAR(CalcDensity(matmap, 500), 0.5 * (0.001 + 2.14), 1e-15);
  EXPECT_NEAR(CalcDensity(matmap, 2500), 2.47, 1e-15);
  EXPECT_EQ(CalcDensity(matmap, -2000), 0.001);
  EXPECT_EQ(CalcDensity(matmap, 9000), 2.8);
  const auto [low, high] = CalcValidHu(matmap);
  EXPECT_NEAR(low, -1000 + 0.799 / 2.139 * 3000, 1e-9);
  EXPECT_EQ(high, 3000);
  EXPECT_NEAR(CalcDensity(matmap, low), 0.8, 1e-12);
}

TEST(CtLaw, EveryShippedLawRisesWithDensityAndStaysAboveZero) {
  for (const CtLaw& law : DefaultCtLaws()) {
    double before = 0;
    for (int i = 0; i <= 4000; ++i) {
      const double rho = law.lower_rho() + (law.upper_rho() - law.lower_rho()) * i / 4000;
      const double E = CalcModulus(law, rho);
      ASSERT_GT(E, before) << law.name << " at " << rho;
      before = E;
    }
    // The minimum of E is its value at the lower end.
    EXPECT_EQ(CalcModulus(law, 0), CalcModulus(law, law.lower_rho())) << law.name;
    EXPECT_GT(CalcModulus(law, 0), 100) << law.name;
  }
}

TEST(CtLaw, DoublingTheCoefficientsDoublesTheModulusEverywhere) {
  const bool passed = rc::check([] {
    const CtLaw& law = Law(*rc::gen::element("mandible_matmap", "morgan_2003_tibia"));
    CtLaw twice = law;
    for (CtLaw::Band& band : twice.bands) band.a_MPa *= 2;
    const double rho = *rc::gen::inRange(0, 3000) * 1e-3;
    RC_ASSERT(CalcModulus(twice, rho) == 2 * CalcModulus(law, rho));
  });
  EXPECT_TRUE(passed);
}

TEST(CtLaws, BuiltInLawsMatchTheFileAndNameTheirSources) {
  std::ifstream file(KERF_SOURCE_DIR "/volumes/ct_laws.csv");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(FormatCtLaws(ParseCtLaws(text.str(), "t.csv")), FormatCtLaws(DefaultCtLaws()));
  ASSERT_EQ(DefaultCtLaws().size(), 5u);
  for (const CtLaw& law : DefaultCtLaws()) {
    EXPECT_EQ(law.tag == 'R', law.source.find("recalled and not verified") != std::string::npos) << law.name;
    // No calibration of apparent density holds for every scanner.
    EXPECT_EQ(law.density == "apparent", law.calibration.empty()) << law.name;
  }
}

TEST(CtLaws, LawWithoutCalibrationRequiresAndAcceptsOne) {
  const auto message = [](const std::string& calibration) -> std::string {
    return test::MessageOf([&] { WithCalibration(Law("morgan_2003_vertebra"), calibration); }, "accepted");
  };
  EXPECT_EQ(message(""),
            "ct_law = \"morgan_2003_vertebra\" requires apparent density and has no calibration of its own, since that "
            "depends on the scanner; give ct_calibration = \"HU:density HU:density ...\" in g/cm3, from a phantom");
  EXPECT_EQ(message("0:0.1 1000:1.2"), "accepted");
  EXPECT_EQ(message("0:2 1000:3"), "the calibration covers 2 to 3 g/cm3, but the bands cover 0.09 to 0.35");
  EXPECT_EQ(message("0:0.1"), "a calibration needs at least two points");
  EXPECT_EQ(message("0:0.1 x:1.2"), "HU = \"x\" is not a number");
  EXPECT_EQ(message("0:0.1 1000"), "calibration point \"1000\" is not HU:density, such as 1000:1.2");
  EXPECT_EQ(message("1000:1.2 0:0.1"),
            "calibration point 0:0.1 is not above the previous point, 1000:1.2, in HU and density");
}

TEST(CtLaws, UnknownNameIsReportedWithTheNearestNameOrAll) {
  const auto message = [](const std::string& name) -> std::string {
    return test::MessageOf([&] { FindCtLaw(DefaultCtLaws(), name); }, "found");
  };
  EXPECT_EQ(message("mandible_matmpa"), "ct_law = \"mandible_matmpa\" is unknown; the nearest is \"mandible_matmap\"");
  EXPECT_THAT(message("wood"), StartsWith("ct_law = \"wood\" is unknown; the laws are mandible_matmap, morgan_2003_"));
}

std::string MessageOf(const std::string& row) {
  return test::MessageOf(
      [&] { ParseCtLaws("# comment\nname,tissue,density,calibration,bands,tag,source\n" + row + "\n", "laws.csv"); },
      "accepted");
}

TEST(CtLaws, EveryMistakeInAFileIsReportedWithItsLine) {
  EXPECT_EQ(MessageOf("a,bone,ash,0:0 1000:1,0.1 to 0.8: 10500 rho^2.29,S,src"), "accepted");
  EXPECT_EQ(MessageOf("a,bone,ash,none,0.1 to 0.4: -34.7 + 3230 rho^1,S,src"), "accepted");
  const std::pair<const char*, const char*> mistakes[] = {
      {"a,bone,ash,0:0 1000:1,nan to 0.8: 1 rho^2,S,src", "laws.csv:3: lower density = \"nan\" is not a number"},
      {"a,bone,ash,0:0 nan:1,0.1 to 0.8: 1 rho^2,S,src", "laws.csv:3: HU = \"nan\" is not a number"},
      {"a,bone,ash,0:-0.1 1000:1,0.1 to 0.8: 1 rho^2,S,src",
       "laws.csv:3: a: calibration point 0:-0.1 has a negative density"},
      {"a,bone,ash,0:0.1 1000:1 500:0.9,0.1 to 0.8: 1 rho^2,S,src",
       "laws.csv:3: a: calibration point 500:0.9 is not above the previous point, 1000:1, in HU and density"},
      {"a,bone,ash,0:0.1 1000:0.1,0.1 to 0.8: 1 rho^2,S,src",
       "laws.csv:3: a: calibration point 1000:0.1 is not above the previous point, 0:0.1, in HU and density"},
      {"a,bone,ash,none,-0.1 to 0.8: 1 rho^2,S,src",
       "laws.csv:3: a: band -0.1 to 0.8 g/cm3 begins at a negative density"},
      {"a,bone,ash,none,0.8 to 0.8: 1 rho^2,S,src",
       "laws.csv:3: a: band 0.8 to 0.8 g/cm3: the upper density must be above the lower one"},
      {"a,bone,ash,none,100 to 800: 1 rho^2,S,src", "laws.csv:3: a: band 100 to 800 g/cm3 reaches beyond 25 g/cm3"},
      {"a,bone,ash,none,0.1 to 0.8: 1 rho^2; 0.7 to 2: 1 rho^2,S,src",
       "laws.csv:3: a: band 0.7 to 2 g/cm3 overlaps the band 0.1 to 0.8 before it; a band must begin where the "
       "previous one ends"},
      {"a,bone,ash,none,0.1 to 0.8: 1 rho^2; 0.9 to 2: 1 rho^2,S,src",
       "laws.csv:3: a: band 0.9 to 2 g/cm3 leaves a gap to the band 0.1 to 0.8 before it; a band must begin where the "
       "previous one ends"},
      {"a,bone,ash,none,0.1 to 0.8: -5 rho^2,S,src",
       "laws.csv:3: a: band 0.1 to 0.8 g/cm3: the coefficient -5 must be above 0 and at most 1000000000 MPa"},
      {"a,bone,ash,none,0.1 to 0.8: 5 rho^0,S,src",
       "laws.csv:3: a: band 0.1 to 0.8 g/cm3: the exponent 0 must be above 0 and at most 10"},
      {"a,bone,ash,none,0 to 0.8: 5 rho^2,S,src",
       "laws.csv:3: a: band 0 to 0.8 g/cm3: E = 0 MPa at its lower end is not above 0"},
      {"a,bone,ash,none,0.1 to 20: 1e6 rho^3,S,src",
       "laws.csv:3: a: band 0.1 to 20 g/cm3: E = 8e+06 GPa at its upper end is above 10000 GPa"},
      {"a,bone,ash,none,0.1 to 0.8: 5 x^2,S,src",
       "laws.csv:3: band \"0.1 to 0.8: 5 x^2\" is not written as LOWER to UPPER: A rho^B or LOWER to UPPER: C + A "
       "rho^B, "
       "such as 0.8 to 1.8: 1157.1 rho^1.78"},
      {"a,bone,ash,none", "laws.csv:3: 4 fields instead of 7; a field with a comma must be in double quotes"},
      {"a,bone,ash,none,\"0.1 to", "laws.csv:3: a field begins with a double quote that does not end on this line"},
      {"A b,bone,ash,none,0.1 to 0.8: 5 rho^2,S,src",
       "laws.csv:3: name = \"A b\" must be 1 to 40 lower-case letters, digits and _"},
      {"a,bone,weight,none,0.1 to 0.8: 5 rho^2,S,src",
       "laws.csv:3: density = \"weight\" is not one of apparent, ash, qct, mass"},
      {"a,bone,ash,,0.1 to 0.8: 5 rho^2,S,src", "laws.csv:3: calibration is empty; write HU:density points, or none"},
      {"a,bone,ash,none,0.1 to 0.8: 5 rho^2,X,src",
       "laws.csv:3: tag = \"X\" is not one of S (read in the source), D (derived) and R (recalled, unverified)"},
      {"a,bone,ash,none,0.1 to 0.8: 5 rho^2,S,", "laws.csv:3: source is empty; state where the numbers come from"},
      {"a,bone,ash,none,0.1 to 0.8: 5 rho^2,S,s\na,bone,ash,none,0.1 to 0.8: 5 rho^2,S,s",
       "laws.csv:4: law \"a\" is given twice"},
      {"", "laws.csv: no law below the header"},
  };
  for (const auto& [row, message] : mistakes) EXPECT_EQ(MessageOf(row), message) << row;
  EXPECT_THROW(ParseCtLaws("", "laws.csv"), Error);
}

TEST(CtLaws, RoundTripIsBitIdentical) {
  const bool passed = rc::check([] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const auto draw = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    CtLaw law;
    law.name = "x_1";
    law.tissue = "a, \"b\"";
    law.density = "qct";
    law.tag = 'D';
    law.source = "s";
    double rho = draw(0.01, 0.5);
    for (int i = *rc::gen::inRange(1, 6); i > 0; --i) {
      const double next = rho + draw(0.01, 2);
      law.bands.push_back({rho, next, draw(0, 5), draw(1, 2000), draw(0.1, 2)});
      rho = next;
    }
    if (*rc::gen::arbitrary<bool>()) law.calibration = {{draw(-1000, 0), draw(0, 0.005)}, {draw(1, 3000), draw(1, 5)}};
    const std::vector<CtLaw> again = ParseCtLaws(FormatCtLaws({law}), "t.csv");
    RC_ASSERT(again.size() == 1u);
    const CtLaw& b = again.front();
    RC_ASSERT(b.tissue == law.tissue && b.density == law.density && b.tag == law.tag && b.source == law.source);
    RC_ASSERT(b.bands.size() == law.bands.size());
    for (std::size_t i = 0; i < b.bands.size(); ++i) {
      RC_ASSERT(b.bands[i].lower == law.bands[i].lower && b.bands[i].upper == law.bands[i].upper &&
                b.bands[i].E0_MPa == law.bands[i].E0_MPa && b.bands[i].a_MPa == law.bands[i].a_MPa &&
                b.bands[i].b == law.bands[i].b);
    }
    RC_ASSERT(b.calibration.size() == law.calibration.size());
    for (std::size_t i = 0; i < b.calibration.size(); ++i) {
      RC_ASSERT(b.calibration[i].HU == law.calibration[i].HU && b.calibration[i].rho == law.calibration[i].rho);
    }
  });
  EXPECT_TRUE(passed);
}

TEST(CtLaws, DamagedFilesLoadOrAreReportedInOneSentence) {
  const std::string good = FormatCtLaws(DefaultCtLaws());
  const auto check = [](const std::string& text) {
    try {
      for (const CtLaw& law : ParseCtLaws(text, "t.csv")) {
        // A law that is accepted is usable: its modulus is finite and above 0 at any density.
        for (const double rho : {-1.0, 0.0, 0.5, 1.8, 30.0, std::numeric_limits<double>::infinity()}) {
          const double E = CalcModulus(law, rho);
          RC_ASSERT(E > 0 && E <= 1e7);
        }
      }
      return true;
    } catch (const Error& e) {
      const std::string message = e.what();
      RC_ASSERT(message.rfind("t.csv:", 0) == 0u);
      RC_ASSERT(message.find('\n') == std::string::npos);
      return false;
    }
  };
  int refused = 0;
  const bool passed = rc::check([&] {
    for (int round = 0; round < 50; ++round) {
      std::string text = good;
      for (int k = *rc::gen::inRange(1, 4); k > 0; --k) {
        const auto at = static_cast<std::size_t>(*rc::gen::inRange<int>(0, static_cast<int>(text.size())));
        switch (*rc::gen::inRange(0, 4)) {
          case 0:
            text[at] = *rc::gen::arbitrary<char>();
            break;
          case 1:
            text[at] = *rc::gen::elementOf(std::string("0123456789.-+e:;^, \"\n"));
            break;
          case 2:
            text.erase(at, static_cast<std::size_t>(*rc::gen::inRange(1, 40)));
            break;
          default:
            text.resize(at);
        }
        if (text.empty()) break;
      }
      refused += check(text) ? 0 : 1;
    }
  });
  EXPECT_TRUE(passed);
  EXPECT_GT(refused, 1000);
}

TEST(UniformTable, HasTheSameConstantsInAllRegionsAndStatesThis) {
  const MaterialTable uniform = MakeUniformTable(DefaultMandibleTable(), 19300, 0.28);
  ASSERT_EQ(uniform.regions().size(), DefaultMandibleTable().regions().size());
  for (const auto& [id, region] : uniform.regions()) {
    EXPECT_EQ(region.E_MPa, 19300);
    EXPECT_EQ(region.nu, 0.28);
    EXPECT_TRUE(region.estimate);
    EXPECT_EQ(region.source, "Uniform: the same for all regions");
    EXPECT_EQ(region.tissue, DefaultMandibleTable().At(id).tissue);
  }
  EXPECT_THROW(MakeUniformTable(DefaultMandibleTable(), -1, 0.28), Error);
}

}  // namespace
}  // namespace kerf
