// Tests of plots as SVG, of horizontal and vertical lines, and of labels of points.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>

#include "support/xml_check.h"
#include "view/plot/label_places.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Rgb8 kBlue{0, 114, 178};

bool IsBlue(const Rgb8& p) {
  return p[2] > 120 && p[0] < 100 && p[1] < 170;
}

PlotSpec MakeSpec() {
  PlotSpec spec;
  spec.width = 800;
  spec.height = 720;  // at this height a width of 1 is one pixel
  spec.title = "Force & <depth> \"here\"";
  spec.x = {"time (us)", true, 10, 1000, {}};
  spec.y = {"error (%)", true, 0.1, 100, {}};
  PlotSeries series;
  series.label = "voxel";
  series.colour = Rgb8{213, 94, 0};
  series.marker = 12;
  series.x = {20, 100, 500};
  series.y = {30, 5, 1};
  series.point_labels = {"0.4", "", "0.1 & less"};
  spec.series = {series};
  return spec;
}

class PlotSvg : public ::testing::Test {
 protected:
  void SetUp() override { unsetenv("DISPLAY"); }
};

TEST_F(PlotSvg, IsReproducibleXmlWithRealText) {
  PlotSpec spec = MakeSpec();
  spec.lines = {{true, 250, "0.25 ms"}, {false, 7, "7 %"}, {false, 3.5, "beside", {1, 2, 3}, 6, true}};
  spec.bands = {{10, 50, "band"}};
  const std::string svg = FormatPlotSvg(spec);
  EXPECT_EQ(test::FindXmlFault(svg), "");
  for (const char* words : {"Force &amp; &lt;depth&gt; &quot;here&quot;", ">time (us)<", ">error (%)<", ">voxel<",
                            ">0.4<", ">0.1 &amp; less<", ">0.25 ms<", ">7 %<", ">beside<", ">band<"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
  EXPECT_EQ(FormatPlotSvg(spec), svg);
}

TEST_F(PlotSvg, FrameMatchesThePng) {
  const PlotSpec spec = MakeSpec();
  PlotFrame svg{};
  PlotFrame pixels{};
  FormatPlotSvg(spec, &svg);
  RenderPlot(spec, &pixels);
  EXPECT_EQ(svg.left, pixels.left);
  EXPECT_EQ(svg.right, pixels.right);
  EXPECT_EQ(svg.top, pixels.top);
  EXPECT_EQ(svg.bottom, pixels.bottom);
}

TEST_F(PlotSvg, AnUpperLimitIsAHollowMark) {
  PlotSpec spec = MakeSpec();
  const auto circles = [](const std::string& svg, const std::string& what) {
    int count = 0;
    for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) {
      count += svg.substr(at, svg.find("/>", at) - at).find(what) != std::string::npos ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(circles(FormatPlotSvg(spec), "fill=\"#ffffff\""), 0);
  spec.series[0].at_most = {false, false, true};
  const std::string svg = FormatPlotSvg(spec);
  EXPECT_EQ(circles(svg, "fill=\"#ffffff\""), 1);
  EXPECT_EQ(circles(svg, "fill=\"#d55e00\""), 3);  // two points and the legend's
  // In pixels, the circle is white in the middle, with the colour around it.
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  const double column = frame.left + std::log(500.0 / 10) / std::log(100.0) * (frame.right - frame.left);
  const double row = frame.bottom - std::log(1 / 0.1) / std::log(1000.0) * (frame.bottom - frame.top);
  EXPECT_GT(image.At(static_cast<int>(column), static_cast<int>(row))[2], 200);
  EXPECT_LT(image.At(static_cast<int>(column + 6), static_cast<int>(row))[2], 120);
}

TEST_F(PlotSvg, StraightLinesAreAtTheirDataWithinTheAxes) {
  PlotSpec spec = MakeSpec();
  spec.lines = {{true, 250, "", kBlue, 0}, {false, 7, "", kBlue, 0}, {true, 5000, "beyond", kBlue, 0}};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  const double column = frame.left + std::log(25.0) / std::log(100.0) * (frame.right - frame.left);
  const double row = frame.bottom - std::log(70.0) / std::log(1000.0) * (frame.bottom - frame.top);
  for (const double fraction : {0.1, 0.6, 0.9}) {
    const int at_row = static_cast<int>(frame.top + fraction * (frame.bottom - frame.top));
    const int at_column = static_cast<int>(frame.left + fraction * (frame.right - frame.left));
    double sum = 0;
    int count = 0;
    for (int c = static_cast<int>(frame.left); c < static_cast<int>(frame.right); ++c) {
      if (IsBlue(image.At(c, at_row))) sum += c + 0.5, ++count;
    }
    ASSERT_GT(count, 0) << fraction;
    EXPECT_NEAR(sum / count, column, 1) << fraction;
    sum = 0, count = 0;
    for (int r = static_cast<int>(frame.top); r < static_cast<int>(frame.bottom); ++r) {
      if (IsBlue(image.At(at_column, r))) sum += r + 0.5, ++count;
    }
    ASSERT_GT(count, 0) << fraction;
    EXPECT_NEAR(sum / count, row, 1) << fraction;
  }
  EXPECT_THAT(FormatPlotSvg(spec), Not(HasSubstr("beyond")));
}

TEST_F(PlotSvg, MarksOfEveryShapeHaveTheirColourInTheMiddle) {
  for (const Marker shape : {Marker::kDisc, Marker::kSquare, Marker::kDiamond, Marker::kTriangleUp,
                             Marker::kTriangleDown, Marker::kCross, Marker::kPlus, Marker::kStar}) {
    PlotSpec spec = MakeSpec();
    spec.series[0].shape = shape;
    spec.series[0].width = 0;
    spec.series[0].colour = kBlue;
    spec.series[0].point_labels.clear();
    PlotFrame frame{};
    const Image image = RenderPlot(spec, &frame);
    const double column = frame.left + 0.5 * (frame.right - frame.left);
    const double row = frame.bottom - std::log(50.0) / std::log(1000.0) * (frame.bottom - frame.top);
    EXPECT_TRUE(IsBlue(image.At(static_cast<int>(column), static_cast<int>(row)))) << static_cast<int>(shape);
    EXPECT_FALSE(IsBlue(image.At(static_cast<int>(column) + 14, static_cast<int>(row)))) << static_cast<int>(shape);
    EXPECT_EQ(test::FindXmlFault(FormatPlotSvg(spec)), "");
  }
}

bool Overlap(const LabelBox& a, const LabelBox& b) {
  return a.left < b.left + b.width && b.left < a.left + a.width && a.top < b.top + b.height && b.top < a.top + a.height;
}

TEST(LabelPlaces, DoNotOverlapEachOtherOrMarksIfThereIsSpace) {
  EXPECT_TRUE(rc::check([] {
    // The marks are on a grid of 60 pixels, and labels are 30 x 12 pixels, so there is a free position for each.
    std::vector<LabelRequest> requests;
    LabelObstacles obstacles;
    obstacles.frame = {0, 0, 400, 400};
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) {
        if (*rc::gen::inRange(0, 3) == 0) continue;
        const OverlayPoint at{60.0 + 60 * i, 60.0 + 60 * j};
        requests.push_back({at, 8, {30, 12}});
        obstacles.boxes.push_back({at.column - 5, at.row - 5, 10, 10});
      }
    }
    const std::vector<LabelBox> places = PlaceLabels(requests, obstacles);
    RC_ASSERT(places.size() == requests.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) RC_ASSERT(!Overlap(places[i], places[j]));
      for (const LabelBox& box : obstacles.boxes) RC_ASSERT(!Overlap(places[i], box));
    }
  }));
}

TEST(LabelPlaces, StayInTheFrameAndAvoidLines) {
  LabelObstacles obstacles;
  obstacles.frame = {0, 0, 100, 100};
  obstacles.lines = {{{50, 50}, {100, 0}}};  // to the upper right, the preferred position of a label
  const LabelBox free_box = PlaceLabels({{{50, 50}, 8, {30, 12}}}, obstacles)[0];
  EXPECT_FALSE(free_box.left > 50 && free_box.top + free_box.height < 50);
  obstacles.lines.clear();
  const LabelBox corner = PlaceLabels({{{97, 3}, 8, {30, 12}}}, obstacles)[0];
  EXPECT_LE(corner.left + corner.width, 100);
  EXPECT_GE(corner.top, 0);
}

}  // namespace
}  // namespace kerf
