// What a plot is drawn with: lines, boxes, marks and words, as pixels or as SVG. The same calls give the same picture.
#pragma once

#include <string>
#include <vector>

#include "view/picture/overlay.h"

class vtkRenderer;

namespace kerf {

/// Marks that are told apart in black and white too.
enum class Marker { kDisc, kSquare, kDiamond, kTriangleUp, kTriangleDown, kCross, kPlus, kStar };

struct MarkerStyle {
  Marker shape = Marker::kDisc;
  double diameter = 8;  // pixels
  Rgb8 colour{0, 0, 0};
  bool hollow = false;
};

/// Positions and sizes in pixels of the finished picture, from its top left; the later above the earlier.
class PlotCanvas {
 public:
  virtual ~PlotCanvas() = default;
  /// The same on every canvas, so that a plot has one layout.
  Overlay::Size MeasureText(const std::string& text, const TextStyle& style) const {
    return measure_.MeasureText(text, style);
  }
  /// As Overlay::AddText.
  virtual void AddText(const std::string& text, double column, double row, const TextStyle& style) = 0;
  virtual void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) = 0;
  /// `dash`: length of a dash and of the gap after it, pixels; 0: unbroken.
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

/// Writes SVG 1.1 in which words stay words. `renderer` is for measuring; nothing is drawn with it.
class SvgCanvas : public PlotCanvas {
 public:
  SvgCanvas(vtkRenderer& renderer, int width, int height, int supersampling);
  void AddText(const std::string& text, double column, double row, const TextStyle& style) override;
  void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) override;
  void AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) override;
  void AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) override;
  /// The whole file. `title`: for programs that read it aloud.
  std::string Finish(const std::string& title) const;

 private:
  int width_;
  int height_;
  std::string body_;
};

/// The corners of a mark's strokes or outline about (0, 0), for a diameter of 2.
std::vector<OverlayPoint> OutlineOf(Marker shape);
/// Whether the mark is strokes from corner 2 k to corner 2 k + 1 and not a closed outline.
bool IsStrokes(Marker shape);

}  // namespace kerf
