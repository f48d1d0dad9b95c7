// Tests of the table of saws that a window offers.
#include "session/scene/saws.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

const std::string kSawsHeader = "name,shape,diameter_mm,thickness_mm,teeth,flutes,rpm,source\n";

std::string WhyRefused(const std::string& rows) {
  return test::MessageOf([&] { ParseSaws(kSawsHeader + rows, "saws.csv"); });
}

TEST(Saws, EveryBuiltInSawIsValidInAScene) {
  ASSERT_FALSE(BuiltInSaws().empty());
  EXPECT_LE(BuiltInSaws().size(), 9u);
  for (const Saw& saw : BuiltInSaws()) {
    Scene scene = ParseScene(DefaultSceneToml(), "default.toml");
    UseSaw(scene, saw);
    const Scene again = ParseScene(ResolvedToml(scene), "again.toml");
    EXPECT_NO_THROW(Validate(MakeTool(again))) << saw.name;
    EXPECT_EQ(DescribeTool(again.tool.shape), DescribeTool(saw.tool.shape));
    EXPECT_EQ(again.tool.rpm, saw.tool.rpm);
  }
  // The first is the scene's own default.
  EXPECT_EQ(DescribeTool(BuiltInSaws().front().tool.shape), DescribeTool(DiscSaw{}));
}

TEST(Saws, UserDefinedTableIsRead) {
  const std::vector<Saw> saws = ParseSaws(
      kSawsHeader + "a,disc,20,0.3,18,none,5000,mine\n\"b, long\",ball,4,none,none,6,9000,mine\n", "saws.csv");
  ASSERT_EQ(saws.size(), 2u);
  EXPECT_EQ(std::get<DiscSaw>(saws[0].tool.shape).teeth, 18);
  EXPECT_EQ(saws[1].name, "b, long");
  EXPECT_EQ(std::get<BallBurr>(saws[1].tool.shape).flutes, 6);
  EXPECT_EQ(std::get<BallBurr>(saws[1].tool.shape).diameter_mm, 4);
}

TEST(Saws, EachFaultIsReportedWithItsLine) {
  EXPECT_THAT(WhyRefused("a,disc,0.5,0.3,18,none,5000,x\n"), HasSubstr("saws.csv:2: diameter_mm = 0.5 is below 1"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,1.5,none,5000,x\n"), HasSubstr("teeth = 1.5 is not an integer"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,8,5000,x\n"), HasSubstr("a disc has no flutes"));
  EXPECT_THAT(WhyRefused("a,ball,6,0.3,none,8,5000,x\n"), HasSubstr("a ball has no thickness_mm"));
  EXPECT_THAT(WhyRefused("a,square,6,0.3,none,8,5000,x\n"), HasSubstr("must be disc or ball"));
  EXPECT_THAT(WhyRefused("a,disc,nan,0.3,18,none,5000,x\n"), HasSubstr("diameter_mm"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,none,5000,\n"), HasSubstr("source is empty"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,none,5000,x\na,disc,20,0.3,18,none,5000,x\n"),
              HasSubstr("saws.csv:3: saw \"a\" is given twice"));
  EXPECT_THAT(WhyRefused(""), HasSubstr("no saw below the header"));
}

}  // namespace
}  // namespace kerf
