// Plots of a quantity over a plane, as colours with a bar and contours.
#pragma once

#include <string>
#include <vector>

#include "view/plot/plot.h"

namespace kerf {

/// Values at the points of a regular grid.
struct PlotField {
  double x0 = 0;  // of the first value, data
  double y0 = 0;
  double step = 0;
  int columns = 0;  // along x
  int rows = 0;
  std::vector<float> values;  // by row, upwards; what is not finite is left white

  /// Linear between four values; of the nearest where one of them is not finite. NaN outside.
  double Sample(double x, double y) const;
};

/// A line where a field (which may be another than the one that is shown, on a grid of its own) has a value.
struct PlotContour {
  PlotField field;
  double level = 0;
  std::string label;
  double width = 2;
  Rgb8 colour{20, 20, 30};
};

struct FieldPlotSpec {
  int width = 1280;
  std::string title;
  std::string caption;
  std::string x_label;  // with unit; a data unit is as long along y as along x
  std::string y_label;
  std::string bar_label;
  PlotField field;
  double lower = 0;  // at the ends of the bar
  double upper = 1;
  std::vector<PlotContour> contours;
};

/// Colour of a share of the bar, 0 to 1: pale yellow to dark red, evenly darker, so that greys tell it too.
Rgb8 BarColour(double share);

/// The pieces of the line where `field` = level, each from one edge of a cell to another, with a NaN after it.
PlotSeries MakeContour(const PlotContour& contour);

/// Throws Error when the field has less than 2 x 2 values, none of them finite, or this machine can't draw. `frame`: as
/// RenderPlot; the bar is at the right end of it.
Image RenderFieldPlot(const FieldPlotSpec& spec, PlotFrame* frame = nullptr);
void WriteFieldPlot(const FieldPlotSpec& spec, const std::string& path);

}  // namespace kerf
