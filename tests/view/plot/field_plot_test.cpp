// Tests of fields with known colours and contours.
#include "view/plot/field_plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

PlotField MakeField(int columns, int rows, double step, const std::function<double(double, double)>& value) {
  PlotField field{-0.5 * step * (columns - 1), -0.5 * step * (rows - 1), step, columns, rows, {}};
  for (int k = 0; k < rows; ++k) {
    for (int i = 0; i < columns; ++i) {
      field.values.push_back(static_cast<float>(value(field.x0 + step * i, field.y0 + step * k)));
    }
  }
  return field;
}

// Draws the contour of x^2 + y^2 = 4. Each crossing is interpolated linearly between values 0.1 apart, so it is within
// 0.1^2 / (8 r) of the circle.
TEST(FieldPlot, ContourOfAConeIsACircle) {
  const PlotField field = MakeField(61, 61, 0.1, [](double x, double y) { return std::hypot(x, y); });
  const PlotSeries line = MakeContour({field, 2, "", 2, {}});
  double length = 0;
  ASSERT_GT(line.x.size(), 100u);
  for (std::size_t i = 0; i + 2 < line.x.size(); i += 3) {
    EXPECT_NEAR(std::hypot(line.x[i], line.y[i]), 2, 0.1 * 0.1 / 16 + 1e-6);
    EXPECT_TRUE(std::isnan(line.x[i + 2]));
    length += std::hypot(line.x[i + 1] - line.x[i], line.y[i + 1] - line.y[i]);
  }
  EXPECT_NEAR(length, 4 * std::numbers::pi, 0.02);
}

TEST(FieldPlot, ColoursMatchTheValuesAndNonFiniteValuesAreWhite) {
  FieldPlotSpec spec;
  spec.width = 900;
  spec.x_label = "x (mm)";
  spec.y_label = "y (mm)";
  spec.bar_label = "T";
  spec.lower = -3;
  spec.upper = 3;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  spec.field = MakeField(61, 31, 0.1, [&](double x, double y) { return std::abs(y) < 0.31 ? nan : x; });
  PlotFrame frame;
  const Image image = RenderFieldPlot(spec, &frame);
  const auto at = [&](double x, double y) {
    const double column =
        frame.left + (x - frame.x_lower) / (frame.x_upper - frame.x_lower) * (frame.right - frame.left);
    const double row =
        frame.bottom - (y - frame.y_lower) / (frame.y_upper - frame.y_lower) * (frame.bottom - frame.top);
    return image.At(static_cast<int>(column), static_cast<int>(row));
  };
  for (const double x : {-2.63, -1.37, 0.43, 1.77, 2.73}) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(at(x, 0.87)[static_cast<std::size_t>(i)], BarColour((x + 3) / 6)[static_cast<std::size_t>(i)], 4);
      EXPECT_GE(at(x, 0.07)[static_cast<std::size_t>(i)], 215);  // white, or the grid's grey
    }
  }
  // The scale is the same on both axes.
  const double x_scale = (frame.right - frame.left) / (frame.x_upper - frame.x_lower);
  const double y_scale = (frame.bottom - frame.top) / (frame.y_upper - frame.y_lower);
  EXPECT_NEAR(x_scale / y_scale, 1, 0.01);
  // The bar's ends are at the ends of the right axis.
  const int bar = static_cast<int>(frame.right) - 8;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(image.At(bar, static_cast<int>(frame.bottom) - 4)[static_cast<std::size_t>(i)],
                BarColour(0.01)[static_cast<std::size_t>(i)], 8);
    EXPECT_NEAR(image.At(bar, static_cast<int>(frame.top) + 4)[static_cast<std::size_t>(i)],
                BarColour(0.99)[static_cast<std::size_t>(i)], 8);
  }
}

// Larger values are distinguishable from smaller ones even in greyscale.
TEST(FieldPlot, BarDarkensMonotonically) {
  double before = 256;
  for (int i = 0; i <= 64; ++i) {
    const Rgb8 c = BarColour(i / 64.0);
    const double grey = 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
    EXPECT_LT(grey, before);
    before = grey;
  }
}

TEST(FieldPlot, RefusesFieldsWithoutValues) {
  FieldPlotSpec spec;
  EXPECT_THROW(RenderFieldPlot(spec), Error);
  spec.field = MakeField(4, 4, 1, [](double, double) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_THROW(RenderFieldPlot(spec), Error);
}

}  // namespace
}  // namespace kerf
