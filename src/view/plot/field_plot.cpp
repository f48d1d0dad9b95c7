#include "view/plot/field_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kBarFraction = 0.035;  // of the box's width
constexpr double kGapFraction = 0.015;  // free space to the left of the bar
// ColorBrewer's YlOrRd (Harrower and Brewer 2003).
constexpr std::array<Rgb8, 9> kBar{{{255, 255, 204},
                                    {255, 237, 160},
                                    {254, 217, 118},
                                    {254, 178, 76},
                                    {253, 141, 60},
                                    {252, 78, 42},
                                    {227, 26, 28},
                                    {189, 0, 38},
                                    {128, 0, 38}}};

/// Multiplies the colours, so that lines and text remain visible.
void Tint(Rgb8& pixel, const Rgb8& colour) {
  for (std::size_t i = 0; i < 3; ++i) pixel[i] = static_cast<std::uint8_t>(pixel[i] * colour[i] / 255);
}

double Along(double from, double to, double lower, double upper, double at) {
  return lower + (at - from) / (to - from) * (upper - lower);
}

}  // namespace

double PlotField::Sample(double x, double y) const {
  const double u = (x - x0) / step, v = (y - y0) / step;
  if (!(u >= 0 && v >= 0 && u <= columns - 1 && v <= rows - 1)) return kNaN;
  const int i = std::min(static_cast<int>(u), columns - 2), k = std::min(static_cast<int>(v), rows - 2);
  const auto at = [&](int a, int b) {
    return static_cast<double>(
        values[static_cast<std::size_t>(k + b) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i + a)]);
  };
  const double s = u - i, t = v - k;
  const double between = (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
  return std::isfinite(between) ? between : at(s < 0.5 ? 0 : 1, t < 0.5 ? 0 : 1);
}

Rgb8 BarColour(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kBar.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kBar.size() - 2);
  const double t = at - static_cast<double>(low);
  Rgb8 colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    colour[i] = static_cast<std::uint8_t>(std::lround((1 - t) * kBar[low][i] + t * kBar[low + 1][i]));
  }
  return colour;
}

PlotSeries MakeContour(const PlotContour& contour) {
  PlotSeries line;
  line.label = contour.label;
  line.width = contour.width;
  line.colour = contour.colour;
  const PlotField& field = contour.field;
  const auto value = [&](int i, int k) {
    return static_cast<double>(field.values[static_cast<std::size_t>(k) * static_cast<std::size_t>(field.columns) +
                                            static_cast<std::size_t>(i)]);
  };
  for (int k = 0; k + 1 < field.rows; ++k) {
    for (int i = 0; i + 1 < field.columns; ++i) {
      // Goes around the cell; if the level lies between two corners, the line crosses the edge between them.
      constexpr int kAlong[] = {0, 1, 1, 0, 0}, kUp[] = {0, 0, 1, 1, 0};
      std::array<std::array<double, 2>, 4> crossings;
      std::size_t count = 0;
      for (int edge = 0; edge < 4; ++edge) {
        const double a = value(i + kAlong[edge], k + kUp[edge]) - contour.level;
        const double b = value(i + kAlong[edge + 1], k + kUp[edge + 1]) - contour.level;
        if (!std::isfinite(a + b)) {
          count = 0;
          break;
        }
        if ((a < 0) == (b < 0)) continue;
        const double t = a / (a - b);
        crossings[count++] = {field.x0 + field.step * (i + kAlong[edge] + t * (kAlong[edge + 1] - kAlong[edge])),
                              field.y0 + field.step * (k + kUp[edge] + t * (kUp[edge + 1] - kUp[edge]))};
      }
      for (std::size_t n = 0; n + 1 < count; n += 2) {
        for (const auto& p : {crossings[n], crossings[n + 1], std::array{kNaN, kNaN}}) {
          line.x.push_back(p[0]);
          line.y.push_back(p[1]);
        }
      }
    }
  }
  return line;
}

Image RenderFieldPlot(const FieldPlotSpec& spec, PlotFrame* frame) {
  const PlotField& field = spec.field;
  if (field.columns < 2 || field.rows < 2 || !(field.step > 0))
    throw Error("a field to plot must have at least 2 x 2 values");
  const auto finite = [](float v) { return std::isfinite(v); };
  if (!std::any_of(field.values.begin(), field.values.end(), finite)) {
    throw Error("a field to plot must have at least one finite value");
  }
  const double x1 = field.x0 + field.step * (field.columns - 1), y1 = field.y0 + field.step * (field.rows - 1);
  PlotSpec plot;
  plot.width = spec.width;
  plot.title = spec.title;
  plot.caption = spec.caption;
  plot.x.label = spec.x_label;
  plot.x.lower = field.x0;
  plot.x.upper = field.x0 + (x1 - field.x0) / (1 - kBarFraction - kGapFraction);
  plot.y.label = spec.y_label;
  plot.y.lower = field.y0;
  plot.y.upper = y1;
  plot.y_right.label = spec.bar_label;
  plot.y_right.lower = spec.lower;
  plot.y_right.upper = spec.upper;
  for (const PlotContour& contour : spec.contours) {
    plot.series.push_back(MakeContour(contour));
    if (plot.series.back().x.empty()) plot.series.pop_back();
  }
  PlotSeries bar;  // makes RenderPlot() draw the right axis
  bar.right_axis = true;
  bar.width = 0;
  bar.x = {*plot.x.lower, *plot.x.upper};
  bar.y = {spec.lower, spec.upper};
  plot.series.push_back(bar);
  PlotSeries left = bar;  // the same for the left axis
  left.right_axis = false;
  left.y = {field.y0, y1};
  plot.series.push_back(left);
  // Chooses the height at which both axes have equal scale.
  PlotFrame box;
  for (int round = 0; round < 2; ++round) {
    RenderPlot(plot, &box);
    const double wanted = (box.right - box.left) * (y1 - field.y0) / (*plot.x.upper - *plot.x.lower);
    plot.height = std::clamp(plot.height + static_cast<int>(std::lround(wanted - (box.bottom - box.top))), 300, 4096);
  }
  Image image = RenderPlot(plot, &box);
  const double bar_from = box.right - kBarFraction * (box.right - box.left);
  for (int row = static_cast<int>(std::ceil(box.top)); row < static_cast<int>(box.bottom); ++row) {
    for (int column = static_cast<int>(std::ceil(box.left)); column < static_cast<int>(box.right); ++column) {
      Rgb8& pixel = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                 static_cast<std::size_t>(column)];
      if (column >= bar_from) {
        Tint(pixel, BarColour(Along(box.bottom, box.top, 0, 1, row + 0.5)));
        continue;
      }
      const double value = field.Sample(Along(box.left, box.right, box.x_lower, box.x_upper, column + 0.5),
                                        Along(box.bottom, box.top, box.y_lower, box.y_upper, row + 0.5));
      if (std::isfinite(value)) Tint(pixel, BarColour((value - spec.lower) / (spec.upper - spec.lower)));
    }
  }
  if (frame != nullptr) *frame = box;
  return image;
}

void WriteFieldPlot(const FieldPlotSpec& spec, const std::string& path) {
  WritePng(RenderFieldPlot(spec), path);
}

}  // namespace kerf
