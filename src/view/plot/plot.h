// Plots of curves, as PNG drawn by VTK without a display, or as SVG.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "view/picture/image.h"
#include "view/picture/overlay.h"
#include "view/plot/plot_canvas.h"

namespace kerf {

/// Curve. A point that is not finite (or not positive on a logarithmic axis) interrupts it.
struct PlotSeries {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;       // same length as x
  std::optional<Rgb8> colour;  // unset: next colour of a palette suitable for colour-blind readers
  double width = 2;            // pixels; 0: no line
  double marker = 0;           // diameter in pixels; 0: no markers
  bool right_axis = false;
  double dash = 0;  // length of a dash and of the gap after it, pixels; 0: solid line
  Marker shape = Marker::kDisc;
  std::vector<bool> at_most{};  // empty, or for each point: true if it is an upper limit; drawn as a hollow mark
  std::vector<std::string> point_labels{};  // empty, or for each point: text placed near it
};

/// Straight line across the axes' box, with a label at its end.
struct PlotLine {
  bool vertical = false;
  double at = 0;  // in data units
  std::string label;
  Rgb8 colour{85, 92, 102};
  double dash = 6;        // as in PlotSeries
  bool at_start = false;  // places the label of a horizontal line on the left
};

struct PlotAxis {
  std::string label;  // with its unit: "force (N)"
  bool log = false;
  std::optional<double> lower;  // unset: from the data
  std::optional<double> upper;
  std::vector<std::string> names;  // text for x = 0, 1, 2, ... in place of numbers; x axis only
};

/// Range of the x axis with a separate background colour and a label at its top.
struct PlotBand {
  double x0 = 0;
  double x1 = 0;
  std::string label;
  Rgb8 colour{230, 230, 230};
};

/// Text at a point in the axes' box, on a translucent white background.
struct PlotNote {
  double x = 0;  // in data units
  double y = 0;
  std::string text;            // lines are separated by '\n'
  std::optional<Rgb8> colour;  // unset: the plot's text colour
  Align align = Align::kLeft;  // edge of the text that is placed at x; its vertical centre is at y
  bool bold = false;
};

struct PlotSpec {
  int width = 1280;  // pixels
  int height = 720;
  std::string title;
  std::string caption;  // smaller, below the title; lines are separated by '\n'
  PlotAxis x;
  PlotAxis y;
  PlotAxis y_right;  // drawn if a series uses it
  std::vector<PlotSeries> series;
  std::vector<PlotBand> bands;
  std::vector<PlotNote> notes;
  std::vector<PlotLine> lines;  // only those within the range of the axes are drawn
  double text_scale = 1;        // 0.5 to 3; larger text for slides and posters
};

/// Position of the axes in the plot's image, in pixels from the top left; for tests and for overlays.
struct PlotFrame {
  double left, right, top, bottom;            // box of the axes, pixels
  double x_lower, x_upper, y_lower, y_upper;  // data values at its edges
};

/// Throws Error if there is no finite point, x and y differ in length, or this machine cannot draw.
Image RenderPlot(const PlotSpec& spec, PlotFrame* frame = nullptr);
void WritePlot(const PlotSpec& spec, const std::string& path);
/// Returns the same picture as SVG with real text. Throws Error as RenderPlot() does, but works on any machine.
std::string FormatPlotSvg(const PlotSpec& spec, PlotFrame* frame = nullptr);

}  // namespace kerf
