// Tests of what the menu of saws says of a saw.
#include "app/window/saw_details.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(SawDetails, NumbersHaveUnits) {
  const auto show = [](const Tool& tool, double rpm) {
    return ShowSawNumbers({.name = "", .tool = {.shape = tool, .rpm = rpm}, .source = "mine"});
  };
  EXPECT_EQ(show(DiscSaw{}, 900), "22 x 0.25 mm, 24 teeth, 900 rpm");
  EXPECT_EQ(show(BallBurr{.diameter_mm = 3.1}, 900), "3.1 mm, 8 flutes, 900 rpm");
  EXPECT_EQ(show(FissureBur{.diameter_mm = 1.6, .length_mm = 9}, 900), "1.6 x 9 mm, 6 flutes, 900 rpm");
  EXPECT_EQ(show(TwistDrill{.diameter_mm = 2, .length_mm = 20}, 900), "2 x 20 mm, 900 rpm");
  EXPECT_EQ(show(ReciprocatingBlade{}, 900), "30 x 6 mm, stroke 3 mm, 21 teeth, 900 double strokes a minute");
  EXPECT_EQ(show(OscillatingBlade{}, 900), "25 x 9 mm, swing 5 degrees, 9 teeth, 900 double strokes a minute");
  EXPECT_EQ(show(PiezoInsert{}, 1740000), "10 x 4 mm, stroke 0.12 mm, 5 teeth, 29 kHz");
}

TEST(SawDetails, SourceSaysWhatIsAssumed) {
  EXPECT_EQ(ShowSawSource({.name = "", .tool = {}, .source = "assumed"}), "Its numbers are assumed; they are typical.");
  EXPECT_EQ(ShowSawSource({.name = "", .tool = {}, .source = "a book"}), "Source of its numbers: a book");
}

}  // namespace
}  // namespace kerf
