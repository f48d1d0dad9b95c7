// Plots of curves: as PNG, drawn by VTK without a display, or as SVG.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "view/picture/image.h"
#include "view/picture/overlay.h"
#include "view/plot/plot_canvas.h"

namespace kerf {

/// A curve. Points that are not finite (or not positive on a logarithmic axis) break it.
struct PlotSeries {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;       // as many
  std::optional<Rgb8> colour;  // none: the next of a palette that colour-blind people can tell apart
  double width = 2;            // pixels; 0: no line
  double marker = 0;           // diameter in pixels; 0: no markers
  bool right_axis = false;
  double dash = 0;  // pixels of a dash, and of the gap after it; 0: an unbroken line
  Marker shape = Marker::kDisc;
  std::vector<bool> at_most{};              // empty, or for each point: the truth is there or below; a hollow mark
  std::vector<std::string> point_labels{};  // empty, or for each point: words beside it, where there is room
};

/// A line across the axes' box, with words at its end.
struct PlotLine {
  bool vertical = false;
  double at = 0;  // data
  std::string label;
  Rgb8 colour{85, 92, 102};
  double dash = 6;        // as of PlotSeries
  bool at_start = false;  // the words of a level line stand on the left
};

struct PlotAxis {
  std::string label;  // with its unit: "force (N)"
  bool log = false;
  std::optional<double> lower;  // none: from the data
  std::optional<double> upper;
  std::vector<std::string> names;  // of 0, 1, 2, ..., in place of numbers; x axis only
};

/// A stretch of the x axis with a background colour of its own and a label at its top.
struct PlotBand {
  double x0 = 0;
  double x1 = 0;
  std::string label;
  Rgb8 colour{230, 230, 230};
};

/// Words at a point of the axes' box, on a veil of white.
struct PlotNote {
  double x = 0;  // data
  double y = 0;
  std::string text;            // lines end in '\n'
  std::optional<Rgb8> colour;  // none: the plot's ink
  Align align = Align::kLeft;  // which edge stands at x; the middle of its height stands at y
  bool bold = false;
};

struct PlotSpec {
  int width = 1280;  // 200 to 8192 pixels
  int height = 720;
  std::string title;
  std::string caption;  // smaller, below the title; lines end in '\n'
  PlotAxis x;
  PlotAxis y;
  PlotAxis y_right;  // drawn when a series asks for it
  std::vector<PlotSeries> series;
  std::vector<PlotBand> bands;
  std::vector<PlotNote> notes;
  std::vector<PlotLine> lines;  // those that the axes show
  double text_scale = 1;        // 0.5 to 3: for words that are read from afar
};

/// Where data lie in the plot's picture, in pixels from the top left; for tests and for what is drawn over it.
struct PlotFrame {
  double left, right, top, bottom;            // the box of the axes, pixels
  double x_lower, x_upper, y_lower, y_upper;  // the data at its edges
};

/// Throws Error when there is no finite point, x and y differ in length, or this machine can't draw.
Image RenderPlot(const PlotSpec& spec, PlotFrame* frame = nullptr);
void WritePlot(const PlotSpec& spec, const std::string& path);
/// The same picture as SVG, in which words are words. Throws Error as RenderPlot, but needs nothing of the machine.
std::string FormatPlotSvg(const PlotSpec& spec, PlotFrame* frame = nullptr);
void WritePlotSvg(const PlotSpec& spec, const std::string& path);

}  // namespace kerf
