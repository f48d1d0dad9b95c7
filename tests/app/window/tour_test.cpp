// Tests where the tour lies, and what ends its steps.
#include "app/window/tour.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(Tour, StepEndsByItsOwnActionOnly) {
  Tour tour;
  tour.Start({{"Choose", "", "choose"}, {"Cut", "", "cut"}, {"Result", "", "result"}});
  tour.EndStep("cut");
  EXPECT_EQ(tour.step(), 1);
  tour.EndStep("choose");
  EXPECT_EQ(tour.step(), 2);
  tour.EndStep("choose");
  EXPECT_EQ(tour.step(), 2);
  tour.EndStep("cut");
  EXPECT_EQ(tour.step(), 3);
  tour.EndStep("result");
  EXPECT_FALSE(tour.is_open());
  tour.EndStep("result");
  EXPECT_EQ(tour.step(), 0);
}

TEST(Tour, ChangesItsLanguageAfterTheFirstStep) {
  Tour tour;
  tour.Start({{"Choose", "", "choose"}, {"Cut", "", "cut"}});
  tour.EndStep("choose");
  tour.SetSteps({{"S\u00e4gen", "", "saw"}});  // the activity no longer has the first step
  EXPECT_EQ(tour.step(), 2);
  tour.EndStep("saw");
  EXPECT_FALSE(tour.is_open());
}

TEST(Tour, CoversNeitherListNorLineNorCube) {
  const UiSize size{380, 170};
  const auto inside = [](const UiBox& box, const UiBox& scene) {
    return box.left >= scene.left && box.top >= scene.top && box.right() <= scene.right() &&
           box.bottom() <= scene.bottom();
  };
  const auto check = [&](const UiBox& scene, const UiBox& cube, std::vector<UiBox> others) {
    others.push_back(cube);
    const UiBox box = PlaceTour(size, scene, cube, {}, others, 1);
    EXPECT_TRUE(inside(box, scene));
    for (const UiBox& other : others) EXPECT_FALSE(Overlap(box, other)) << other.left << ", " << other.top;
  };
  // At 1280 x 720, the list of exercises: its buttons, headings and rows.
  check({0, 59, 1280, 629}, {1176, 584, 96, 96}, {{138, 160, 373, 23}, {1060, 212, 80, 22}, {138, 234, 1004, 260}});
  // An exercise: its card and its line.
  check({262, 59, 1018, 629}, {1176, 584, 96, 96}, {{451, 67, 640, 85}, {625, 580, 640, 16}});
  // Without a free place, it covers rows rather than a button.
  const UiBox scene{0, 0, 400, 400}, rows{0, 150, 400, 250}, button{0, 0, 200, 40};
  EXPECT_FALSE(Overlap(PlaceTour(size, scene, {}, {button}, {rows}, 1), button));
  // It does not leave a small scene to cover less.
  const UiBox small{300, 0, 400, 200}, cube{620, 120, 80, 80};
  EXPECT_TRUE(inside(PlaceTour(size, small, cube, {}, {small}, 1), small));
  EXPECT_TRUE(inside(PlaceTour(size, small, cube, {{400, 0, 300, 120}}, {cube}, 1), small));
}

}  // namespace
}  // namespace kerf
