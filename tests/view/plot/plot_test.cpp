// Tests of plots with known pixels.
#include "view/plot/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include "kerf/error.h"
#include "support/message_of.h"
#include "view/plot/ticks.h"

namespace kerf {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr Rgb8 kPlotBlue{0, 114, 178};

bool IsPlotBlue(const Rgb8& p) {
  return p[2] > 120 && p[0] < 100 && p[1] < 170;
}

// Returns the mean row (pixel centres) of the curve in a column; NaN if there is none inside the axes.
double CurveRow(const Image& image, const PlotFrame& frame, int column) {
  double sum = 0;
  int count = 0;
  for (int row = static_cast<int>(frame.top); row <= static_cast<int>(frame.bottom); ++row) {
    if (!IsPlotBlue(image.At(column, row))) continue;
    sum += row + 0.5;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

PlotSpec MakePlotSpec() {
  PlotSpec spec;
  spec.width = 800;
  spec.height = 500;
  spec.x.label = "depth (mm)";
  spec.y.label = "force (N)";
  return spec;
}

class Plot : public ::testing::Test {
 protected:
  void SetUp() override { unsetenv("DISPLAY"); }
};

TEST_F(Plot, LinearCurveLiesAtItsData) {
  PlotSpec spec = MakePlotSpec();
  spec.x.lower = 0, spec.x.upper = 10, spec.y.lower = 0, spec.y.upper = 50;
  PlotSeries series;
  series.colour = kPlotBlue;
  for (int i = 0; i <= 1000; ++i) series.x.push_back(0.01 * i), series.y.push_back(3 + 4.2 * 0.01 * i);
  spec.series = {series};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  EXPECT_EQ(frame.x_lower, 0);
  EXPECT_EQ(frame.x_upper, 10);
  EXPECT_EQ(frame.y_upper, 50);
  for (const double x : {0.5, 2.0, 5.0, 9.5}) {
    const int column = static_cast<int>(frame.left + x / 10 * (frame.right - frame.left));
    const double x_of_column = (column + 0.5 - frame.left) / (frame.right - frame.left) * 10;
    const double expected = frame.bottom - (3 + 4.2 * x_of_column) / 50 * (frame.bottom - frame.top);
    EXPECT_NEAR(CurveRow(image, frame, column), expected, 1) << x;
  }
}

TEST_F(Plot, NamesOfAnAxisAreAtWholeNumbersWithinIt) {
  PlotSpec spec = MakePlotSpec();
  spec.x.lower = -0.5, spec.x.upper = 1.5;
  spec.series = {{"", {0, 1}, {1, 2}, kPlotBlue, 0, 10, false}};
  const auto count_ink = [&](const std::vector<std::string>& names, double at) {
    spec.x.names = names;
    PlotFrame frame{};
    const Image image = RenderPlot(spec, &frame);
    const int middle = static_cast<int>(frame.left + (at + 0.5) / 2 * (frame.right - frame.left));
    int ink = 0;
    for (int row = static_cast<int>(frame.bottom) + 10; row < static_cast<int>(frame.bottom) + 28; ++row) {
      for (int column = middle - 30; column < middle + 30; ++column) ink += image.At(column, row)[0] < 128 ? 1 : 0;
    }
    return ink;
  };
  EXPECT_GT(count_ink({"XXXX", "", "beyond"}, 0), 20);
  EXPECT_EQ(count_ink({"XXXX", "", "beyond"}, 1), 0);
  EXPECT_GT(count_ink({"", "XXXX"}, 1), 20);
}

TEST_F(Plot, PowerLawIsStraightOnLogarithmicAxes) {
  PlotSpec spec = MakePlotSpec();
  spec.x.log = spec.y.log = true;
  PlotSeries series;
  series.colour = kPlotBlue;
  for (int i = 0; i <= 200; ++i) {
    const double x = std::pow(10.0, -2 + 0.02 * i);
    series.x.push_back(x), series.y.push_back(7 * x * x);
  }
  spec.series = {series};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  EXPECT_NEAR(frame.x_lower, 0.01, 1e-12);
  EXPECT_NEAR(frame.x_upper, 100, 1e-9);
  for (const double fraction : {0.1, 0.4, 0.7, 0.95}) {
    const int column = static_cast<int>(frame.left + fraction * (frame.right - frame.left));
    const double s = (column + 0.5 - frame.left) / (frame.right - frame.left);
    const double y = 7 * std::pow(10.0, 2 * (-2 + 4 * s));
    const double expected = frame.bottom - std::log(y / frame.y_lower) / std::log(frame.y_upper / frame.y_lower) *
                                               (frame.bottom - frame.top);
    EXPECT_NEAR(CurveRow(image, frame, column), expected, 1) << fraction;
  }
}

TEST_F(Plot, BandsFillExactlyTheirRange) {
  PlotSpec spec = MakePlotSpec();
  spec.x.lower = 0, spec.x.upper = 8;
  spec.series = {{"", {0, 8}, {0, 0}, kPlotBlue, 2, 0, false}};
  spec.bands = {{2, 5, "", {255, 0, 0}}};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  const int row = static_cast<int>(0.5 * (frame.top + frame.bottom)) + 5;
  const auto is_red = [&](int column) { return image.At(column, row)[0] > image.At(column, row)[1] + 30; };
  int first = -1;
  int last = -1;
  for (int column = 0; column < image.width; ++column) {
    if (!is_red(column)) continue;
    if (first < 0) first = column;
    last = column;
  }
  EXPECT_NEAR(first, frame.left + 2.0 / 8 * (frame.right - frame.left), 1.5);
  EXPECT_NEAR(last + 1, frame.left + 5.0 / 8 * (frame.right - frame.left), 1.5);
}

TEST_F(Plot, CurveIsClippedAtTheAxesAndInterruptedAtMissingValues) {
  PlotSpec spec = MakePlotSpec();
  spec.x.lower = 0, spec.x.upper = 10, spec.y.lower = 0, spec.y.upper = 10;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  spec.series = {{"", {-5, 3, 4, 5, 30}, {5, 5, nan, 5, 5}, kPlotBlue, 3, 0, false}};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  const auto column_of = [&](double x) { return static_cast<int>(frame.left + x / 10 * (frame.right - frame.left)); };
  EXPECT_FALSE(std::isnan(CurveRow(image, frame, column_of(1))));
  EXPECT_TRUE(std::isnan(CurveRow(image, frame, column_of(4))));
  EXPECT_FALSE(std::isnan(CurveRow(image, frame, column_of(9))));
  EXPECT_TRUE(std::isnan(CurveRow(image, frame, static_cast<int>(frame.right) + 8)));
  EXPECT_TRUE(std::isnan(CurveRow(image, frame, static_cast<int>(frame.left) - 8)));
}

TEST_F(Plot, RightAxisHasASeparateScale) {
  PlotSpec spec = MakePlotSpec();
  spec.y.lower = 0, spec.y.upper = 100;
  spec.y_right.lower = 0, spec.y_right.upper = 2;
  spec.y_right.label = "engaged teeth";
  spec.series = {{"force", {0, 1}, {10, 10}, Rgb8{213, 94, 0}, 2, 0, false},
                 {"teeth", {0, 1}, {1, 1}, kPlotBlue, 2, 0, true}};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  const double row = CurveRow(image, frame, static_cast<int>(0.4 * frame.left + 0.6 * frame.right));
  EXPECT_NEAR(row, 0.5 * (frame.top + frame.bottom), 1);
}

TEST_F(Plot, DashesHaveTheRequestedLengthAndCoverHalfTheLine) {
  PlotSpec spec = MakePlotSpec();
  spec.height = 720;  // at this height a width of 1 is one pixel
  spec.x.lower = 0, spec.x.upper = 10, spec.y.lower = 0, spec.y.upper = 10;
  PlotSeries series;
  series.x = {0, 3.3, 10};  // the corner in the middle does not restart the dashes
  series.y = {5, 5, 5};
  series.colour = kPlotBlue;
  series.dash = 10;
  spec.series = {series};
  PlotFrame frame{};
  const Image image = RenderPlot(spec, &frame);
  int drawn = 0;
  int dashes = 0;
  bool last = false;
  for (int column = static_cast<int>(frame.left) + 5; column < static_cast<int>(frame.right); ++column) {
    const bool on = !std::isnan(CurveRow(image, frame, column));
    drawn += on ? 1 : 0;
    dashes += on && !last ? 1 : 0;
    last = on;
  }
  const double length = frame.right - frame.left - 5;
  EXPECT_NEAR(dashes, length / 20, 1);
  // A pixel that is partly covered by the end of a dash may count or not.
  EXPECT_NEAR(drawn, length / 2, 1.0 * dashes + 10);
}

TEST_F(Plot, NoteIsAtItsPointWithItsAlignment) {
  PlotSpec spec = MakePlotSpec();
  spec.x.lower = 0, spec.x.upper = 10, spec.y.lower = 0, spec.y.upper = 10;
  spec.series = {{"", {0, 10}, {0, 0}, Rgb8{213, 94, 0}, 2, 0, false}};
  for (const Align align : {Align::kLeft, Align::kCentre, Align::kRight}) {
    spec.notes = {{4, 6, "nnnnnnnn", kPlotBlue, align, true}};
    PlotFrame frame{};
    const Image image = RenderPlot(spec, &frame);
    double first = image.width;
    double last = -1;
    double top = image.height;
    double bottom = -1;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < image.width; ++column) {
        if (!IsPlotBlue(image.At(column, row))) continue;
        first = std::min(first, 1.0 * column), last = std::max(last, column + 1.0);
        top = std::min(top, 1.0 * row), bottom = std::max(bottom, row + 1.0);
      }
    }
    const double x = frame.left + 0.4 * (frame.right - frame.left);
    const double y = frame.bottom - 0.6 * (frame.bottom - frame.top);
    const double anchor = align == Align::kLeft ? first : align == Align::kRight ? last : 0.5 * (first + last);
    EXPECT_GT(last - first, 60);
    EXPECT_NEAR(anchor, x, 3);
    // The centre of small letters lies slightly below the centre of the line.
    EXPECT_NEAR(0.5 * (top + bottom), y, 6);
  }
}

TEST_F(Plot, LargerTextShrinksTheAxes) {
  PlotSpec spec = MakePlotSpec();
  spec.series = {{"", {0, 1}, {0, 1}, kPlotBlue, 2, 0, false}};
  PlotFrame normal{};
  RenderPlot(spec, &normal);
  spec.text_scale = 1.6;
  PlotFrame larger{};
  RenderPlot(spec, &larger);
  EXPECT_GT(larger.left, normal.left + 5);
  EXPECT_LT(larger.bottom, normal.bottom - 5);
}

TEST_F(Plot, BadSpecsAreRefusedWithOneSentence) {
  PlotSpec spec = MakePlotSpec();
  EXPECT_THAT(test::MessageOf([&] { RenderPlot(spec); }), HasSubstr("at least one finite value along x"));
  spec.series = {{"a", {1, 2}, {1}, {}, 2, 0, false}};
  EXPECT_THAT(test::MessageOf([&] { RenderPlot(spec); }), HasSubstr("series 'a' has 2 x and 1 y"));
  spec.series = {{"a", {1, 2}, {-1, -2}, {}, 2, 0, false}};
  spec.y.log = true;
  EXPECT_THAT(test::MessageOf([&] { RenderPlot(spec); }), HasSubstr("finite"));
  spec.y.log = false;
  spec.width = 20;
  EXPECT_THAT(test::MessageOf([&] { RenderPlot(spec); }), HasSubstr("a plot of 20 x 500 pixels can't be drawn"));
}

std::vector<std::string> Texts(const std::vector<Tick>& ticks) {
  std::vector<std::string> texts;
  for (const Tick& tick : ticks) {
    if (!tick.text.empty()) texts.push_back(tick.text);
  }
  return texts;
}

TEST(Ticks, AreRoundNumbersWithMinimalDecimals) {
  EXPECT_THAT(Texts(CalcLinearTicks(0, 6.6, 8)), ElementsAre("0", "1", "2", "3", "4", "5", "6"));
  EXPECT_THAT(Texts(CalcLinearTicks(0, 1, 5)), ElementsAre("0", "0.2", "0.4", "0.6", "0.8", "1.0"));
  EXPECT_THAT(Texts(CalcLinearTicks(-30, 25, 4)), ElementsAre("-20", "0", "20"));
  EXPECT_THAT(Texts(CalcLinearTicks(0.1, 0.3, 4)), ElementsAre("0.10", "0.15", "0.20", "0.25", "0.30"));
  EXPECT_THAT(Texts(CalcLogTicks(0.01, 1000)), ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  EXPECT_THAT(Texts(CalcLogTicks(0.05, 0.4)), ElementsAre("0.05", "0.07", "0.1", "0.2", "0.3", "0.4"));
  for (int count = 2; count < 20; ++count) {
    EXPECT_LE(CalcLinearTicks(0, 7.3, count).size(), static_cast<std::size_t>(count) + 1) << count;
  }
}

}  // namespace
}  // namespace kerf
