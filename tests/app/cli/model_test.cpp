// Tests of `kerf model` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using test::ProgramTest;
using testing::HasSubstr;

class ModelCommand : public ProgramTest {};

TEST_F(ModelCommand, BlockHasItsVolumeAndLayers) {
  const ProgramResult r = Kerf(
      "model block -o b.vdb --size 12,10,8 --layer 2:24 --layer 6:32 --rotate 10,20,30 --at 1,2,3 --voxel 0.25 --json");
  ASSERT_EQ(r.code, 0) << r.err;
  const auto json = nlohmann::json::parse(r.out);
  EXPECT_NEAR(json["volume_mm3"].get<double>(), 12 * 10 * 8, 0.01 * 12 * 10 * 8);
  ASSERT_EQ(json["regions"].size(), 2u);
  // The volume is accurate to half a voxel at the border of the regions.
  EXPECT_NEAR(json["regions"][0]["volume_mm3"].get<double>(), 12 * 10 * 2, 12 * 10 * 0.25);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "b.vdb"));
  EXPECT_EQ(Kerf("info b.vdb").code, 0);
}

TEST_F(ModelCommand, MandibleAndPlateAreWritten) {
  const ProgramResult mandible = Kerf("model mandible -o m.vdb --voxel 0.8 --teeth 0 --ramus-height 46");
  ASSERT_EQ(mandible.code, 0) << mandible.err;
  EXPECT_THAT(mandible.out, HasSubstr("written    m.vdb"));
  EXPECT_EQ(mandible.err, "");
  EXPECT_THAT(Kerf("info m.vdb").out, HasSubstr("1 piece"));
  EXPECT_EQ(Kerf("model plate -o p.vdb --voxel 0.5").code, 0);
}

TEST_F(ModelCommand, BadInputIsReportedInOneSentence) {
  std::ofstream(folder_ / "t.csv") << "id,name,tissue,E_GPa,nu,estimate,source\n24,a,bone,19,0.3,yes,s\n";
  const struct {
    const char* arguments;
    int code;
    const char* message;
  } cases[] = {
      {"model block", 2, "-o"},
      {"model block -o b.txt", 2, "'b.txt' must end in .vdb"},
      {"model block -o b.vdb --size 1,2", 2, "'1,2' must be x,y,z in mm"},
      {"model block -o b.vdb --size 1,2,nan", 2, "'1,2,nan' must be x,y,z in mm"},
      {"model block -o b.vdb --layer 2", 2, "'2' must be thickness:region"},
      {"model block -o b.vdb --layer 2:300", 2, "'2:300' does not specify a region"},
      {"model block -o b.vdb --layer=-2:24", 1,
       "kerf: block: layer 1: thickness_mm = -2 is below 0.001; valid range 0.001 to 1000 mm\n"},
      {"model block -o b.vdb --layer 2:77", 1,
       "kerf: block: layer 1 has region 77, which is not in the region table\n"},
      {"model block -o b.vdb --materials t.csv", 1,
       "kerf: t.csv:2: tissue = \"bone\" is not one of cortical, cancellous, tooth, canal, other, metal, lesion\n"},
      {"model mandible -o m.vdb --ramus-width 99", 2, "--ramus-width: 99 is above 38; valid range 24 to 38 mm"},
      // Decimal, not octal.
      {"model mandible -o m.vdb --teeth 08", 1, "kerf: mandible: teeth = 8 is not 0, 14 or 16\n"},
      {"model mandible -o m.vdb --teeth 015", 1, "kerf: mandible: teeth = 15 is not 0, 14 or 16\n"},
      {"model mandible -o m.vdb --teeth 7.5", 2, "'7.5' is not a whole number"},
      {"model mandible -o m.vdb --teeth 7", 1, "kerf: mandible: teeth = 7 is not 0, 14 or 16\n"},
      {"model mandible -o missing/m.vdb --voxel 1", 1, "missing"},
      {"model skull -o m.vdb", 2, "subcommand"},
  };
  for (const auto& c : cases) {
    const ProgramResult r = Kerf(c.arguments);
    EXPECT_EQ(r.code, c.code) << c.arguments << "\n" << r.err;
    EXPECT_THAT(r.err, HasSubstr(c.message)) << c.arguments;
    EXPECT_EQ(r.out, "") << c.arguments;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.vdb"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "m.vdb"));
}

}  // namespace
}  // namespace kerf
