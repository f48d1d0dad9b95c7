// Plots of a quantity over a plane: colours with a colour bar, and contours.
#pragma once

#include <string>
#include <vector>

#include "view/plot/plot.h"

namespace kerf {

/// Values at the points of a regular grid.
struct PlotField {
  double x0 = 0;  // of the first value, in data units
  double y0 = 0;
  double step = 0;
  int columns = 0;  // along x
  int rows = 0;
  std::vector<float> values;  // by row, upwards; values that are not finite are left white

  /// Interpolates bilinearly. Returns the nearest value if one of the four values around the point is not finite, and
  /// NaN outside the grid.
  double Sample(double x, double y) const;
};

/// Contour line at a value of a field. The field may differ from the plotted one and have a separate grid.
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
  std::string x_label;  // with unit; both axes have equal scale
  std::string y_label;
  std::string bar_label;
  PlotField field;
  double lower = 0;  // at the ends of the colour bar
  double upper = 1;
  std::vector<PlotContour> contours;
};

/// Returns the colour at `fraction` (0 to 1) of the bar: from pale yellow to dark red, darkening evenly, so that it is
/// readable in greyscale.
Rgb8 BarColour(double fraction);

/// Returns the segments of the line where `field` = level. Each segment goes from one edge of a cell to another and is
/// followed by a NaN.
PlotSeries MakeContour(const PlotContour& contour);

/// Draws a plot. Throws Error if the field has fewer than 2 x 2 values or no finite value, or this machine cannot draw.
/// `frame`: as for RenderPlot(); includes the colour bar at its right end.
Image RenderFieldPlot(const FieldPlotSpec& spec, PlotFrame* frame = nullptr);
void WriteFieldPlot(const FieldPlotSpec& spec, const std::string& path);

}  // namespace kerf
