// Tests of the table of saws that a window offers.
#include "session/scene/saws.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "scene_text.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const std::string kSawsHeader = "name,shape,diameter_mm,thickness_mm,teeth,flutes,rpm,source\n";

std::string WhyRefused(const std::string& rows) {
  return test::MessageOf([&] { ParseSaws(kSawsHeader + rows, "saws.csv"); });
}

TEST(Saws, EveryBuiltInSawIsValidInAScene) {
  ASSERT_FALSE(BuiltInSaws().empty());
  EXPECT_LE(BuiltInSaws().size(), kMaxSaws);
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

TEST(Saws, SceneWithoutRateHasOneOfTheTableForItsKindOfTool) {
  for (const Tool& tool : GetDefaultTools()) {
    const std::string shape(GetShape(tool));
    const Scene scene = ParseScene(test::ShortScene() + "[tool]\nshape = \"" + shape + "\"\n", "scene.toml");
    ASSERT_EQ(GetShape(scene.tool.shape), shape);
    std::vector<double> rates;
    for (const Saw& saw : BuiltInSaws()) {
      if (GetShape(saw.tool.shape) == shape) rates.push_back(saw.tool.rpm);
    }
    EXPECT_THAT(rates, Contains(scene.tool.rpm)) << shape;
  }
}

TEST(Saws, RateIsInTheTermsOfTheirDrive) {
  EXPECT_EQ(DescribeRate({.shape = DiscSaw{}, .rpm = 7500}), "7500 rpm");
  EXPECT_EQ(DescribeRate({.shape = OscillatingBlade{}, .rpm = 15000}), "15000 double strokes a minute");
  EXPECT_EQ(DescribeRate({.shape = PiezoInsert{}, .rpm = 1.68e6}), "1680000 double strokes a minute");
}

TEST(SceneTool, TurnsInTheSenseOfItsKindUnlessReversed) {
  for (const Tool& tool : GetDefaultTools()) {
    const bool clockwise = !IsBlade(tool);  // a disc turns counter-clockwise, a stroke has no sense
    SceneTool scene_tool{.shape = tool, .rpm = 900};
    EXPECT_EQ(scene_tool.CalcTickRpm(), clockwise ? -900 : 900) << GetShape(tool);
    EXPECT_FALSE(std::signbit(scene_tool.CalcTickRpm(0)));
    if (GetDrive(tool) != DriveMotion::kRotation) {
      EXPECT_EQ(DescribeSense(scene_tool), "");
      continue;
    }
    const std::string words[] = {"clockwise as seen from the handpiece",
                                 "counter-clockwise as seen from the handpiece"};
    EXPECT_EQ(DescribeSense(scene_tool), words[clockwise ? 0 : 1]);
    scene_tool.reverse = true;
    EXPECT_EQ(DescribeSense(scene_tool), words[clockwise ? 1 : 0]);
    EXPECT_EQ(scene_tool.CalcTickRpm(), clockwise ? 900 : -900);
    EXPECT_FALSE(std::signbit(scene_tool.CalcTickRpm(0)));
  }
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

std::vector<double> ListShape(Tool tool) {
  std::vector<double> values;
  const auto add = [&values](const char*, const auto& value, const auto&...) {
    values.push_back(static_cast<double>(value));
  };
  std::visit([&](auto& shape) { DescribeShape(shape, add); }, tool);
  return values;
}

TEST(Saws, EveryKeyOfEveryShapeIsAColumn) {
  for (Tool tool : GetDefaultTools()) {
    std::string header = "source,rpm,shape,name";
    std::string row = fmt::format("mine,5000,{},a", GetShape(tool));
    const auto change = [&](const char* key, auto& value, Range range, const char*) {
      value = static_cast<std::decay_t<decltype(value)>>((value + range.lower) / 2);
      header = fmt::format("{},{}", key, header);
      row = fmt::format("{},{}", value, row);
    };
    std::visit([&](auto& shape) { DescribeShape(shape, change); }, tool);
    EXPECT_EQ(ListShape(ParseSaws(fmt::format("{}\n{}\n", header, row), "saws.csv").front().tool.shape),
              ListShape(tool))
        << row;
  }
}

TEST(Saws, GripIsKeptExceptWhereTheHandpieceIsAnother) {
  Scene scene = ParseScene(DefaultSceneToml(), "default.toml");
  std::visit([](auto& shape) { shape.p_TG_mm = {1, 2, 90}; }, scene.tool.shape);
  UseSaw(scene, {.name = "ball", .tool = {.shape = BallBurr{}}, .source = "mine"});
  EXPECT_EQ(CalcGrip(scene.tool.shape), Vec3(1, 2, 90));
  UseSaw(scene, {.name = "blade", .tool = {.shape = ReciprocatingBlade{}}, .source = "mine"});
  EXPECT_EQ(CalcGrip(scene.tool.shape), ReciprocatingBlade{}.p_TG_mm);
  UseSaw(scene, {.name = "arc", .tool = {.shape = OscillatingBlade{}}, .source = "mine"});
  EXPECT_EQ(CalcGrip(scene.tool.shape), OscillatingBlade{}.p_TG_mm);
  UseSaw(scene, {.name = "disc", .tool = {.shape = DiscSaw{}}, .source = "mine"});
  EXPECT_EQ(CalcGrip(scene.tool.shape), DiscSaw{}.p_TG_mm);
}

TEST(Saws, KeyWithoutColumnHasItsDefault) {
  const std::vector<Saw> saws =
      ParseSaws("teeth,name,shape,rpm,source\n31,a,disc,5000,mine\nnone,b,ball,9000,mine\n", "saws.csv");
  DiscSaw disc;
  disc.teeth = 31;
  EXPECT_EQ(ListShape(saws[0].tool.shape), ListShape(disc));
  EXPECT_EQ(ListShape(saws[1].tool.shape), ListShape(BallBurr{}));
}

TEST(Saws, WrongColumnsAreReported) {
  const auto why = [](const std::string& header) {
    return test::MessageOf([&] { ParseSaws("# mine\n" + header + "\n", "saws.csv"); });
  };
  EXPECT_EQ(why("name,shape,rpm,source,diamter_mm"),
            "saws.csv:2: unknown column \"diamter_mm\"; did you mean \"diameter_mm\"?");
  EXPECT_THAT(why("name,shape,rpm,source,colour"), HasSubstr("saws.csv:2: unknown column \"colour\"; the columns are"));
  EXPECT_THAT(why("name,shape,source"), HasSubstr("saws.csv:2: column \"rpm\" is missing"));
  EXPECT_THAT(why("name,shape,rpm,source,teeth,teeth"), HasSubstr("column \"teeth\" is given twice"));
}

TEST(Saws, TableHasAtMost40) {
  std::string rows;
  for (std::size_t i = 0; i < kMaxSaws; ++i) rows += fmt::format("saw {},disc,20,0.3,18,none,5000,mine\n", i);
  EXPECT_EQ(ParseSaws(kSawsHeader + rows, "saws.csv").size(), 40u);
  EXPECT_EQ(WhyRefused(rows + "one more,disc,20,0.3,18,none,5000,mine\n"), "saws.csv:42: more than 40 saws");
}

TEST(Saws, EachFaultIsReportedWithItsLine) {
  EXPECT_THAT(WhyRefused("a,disc,0.5,0.3,18,none,5000,x\n"), HasSubstr("saws.csv:2: diameter_mm = 0.5 is below 1"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,1.5,none,5000,x\n"), HasSubstr("teeth = 1.5 is not an integer"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,8,5000,x\n"), HasSubstr("a disc has no flutes"));
  EXPECT_THAT(WhyRefused("a,ball,6,0.3,none,8,5000,x\n"), HasSubstr("a ball has no thickness_mm"));
  EXPECT_THAT(WhyRefused("a,square,6,0.3,none,8,5000,x\n"), HasSubstr("must be disc or ball"));
  EXPECT_THAT(WhyRefused("a,disc,nan,0.3,18,none,5000,x\n"), HasSubstr("diameter_mm"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,none,5000,\n"), HasSubstr("source is empty"));
  // An empty field is a mistake, not the default.
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,,none,5000,x\n"), HasSubstr("teeth = \"\" is not a number"));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,,5000,x\n"), HasSubstr("a disc has no flutes; write none, not \"\""));
  EXPECT_THAT(WhyRefused("a,disc,20,0.3,18,none,5000,x\na,disc,20,0.3,18,none,5000,x\n"),
              HasSubstr("saws.csv:3: saw \"a\" is given twice"));
  EXPECT_THAT(WhyRefused(""), HasSubstr("no saw below the header"));
}

}  // namespace
}  // namespace kerf
