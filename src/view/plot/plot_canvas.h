// Drawing surfaces of plots: lines, boxes, marks and text, as pixels or as SVG. Equal calls give equal pictures.
#pragma once

#include <string>
#include <vector>

#include "view/picture/overlay.h"

class vtkRenderer;

namespace kerf {

/// Marks that are distinguishable without colour.
enum class Marker { kDisc, kSquare, kDiamond, kTriangleUp, kTriangleDown, kCross, kPlus, kStar };

struct MarkerStyle {
  Marker shape = Marker::kDisc;
  double diameter = 8;  // pixels
  Rgb8 colour{0, 0, 0};
  bool hollow = false;
};

/// Positions and sizes are in pixels of the finished picture, from its top left. Later primitives lie above earlier
/// ones.
class PlotCanvas {
 public:
  virtual ~PlotCanvas() = default;
  /// Returns equal sizes on all canvases, so that a plot has the same layout on each.
  Overlay::Size MeasureText(const std::string& text, const TextStyle& style) const {
    return measure_.MeasureText(text, style);
  }
  /// See Overlay::AddText().
  virtual void AddText(const std::string& text, double column, double row, const TextStyle& style) = 0;
  virtual void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) = 0;
  /// `dash`: length of a dash and of the gap after it, pixels; 0: solid.
  virtual void AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) = 0;
  virtual void AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) = 0;

 protected:
  explicit PlotCanvas(const Overlay& measure) : measure_(measure) {}

 private:
  Overlay measure_;
};

/// Draws with `renderer`.
class PixelCanvas : public PlotCanvas {
 public:
  PixelCanvas(vtkRenderer& renderer, int height, int supersampling)
      : PlotCanvas(Overlay(renderer, height, supersampling)), overlay_(renderer, height, supersampling) {}
  void AddText(const std::string& text, double column, double row, const TextStyle& style) override;
  void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) override;
  void AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) override;
  void AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) override;

 private:
  Overlay overlay_;
};

/// Writes SVG 1.1 with real text. `renderer` is used only for measuring text.
class SvgCanvas : public PlotCanvas {
 public:
  SvgCanvas(vtkRenderer& renderer, int width, int height, int supersampling);
  void AddText(const std::string& text, double column, double row, const TextStyle& style) override;
  void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) override;
  void AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) override;
  void AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) override;
  /// Returns the whole file. `title`: for screen readers.
  std::string Finish(const std::string& title) const;

 private:
  int width_;
  int height_;
  std::string body_;
};

/// Returns the corners of a mark's strokes or outline around (0, 0), for a diameter of 2.
std::vector<OverlayPoint> OutlineOf(Marker shape);
/// Returns true if the mark consists of strokes from corner 2 k to corner 2 k + 1, false if it is a closed outline.
bool IsStrokes(Marker shape);

}  // namespace kerf
