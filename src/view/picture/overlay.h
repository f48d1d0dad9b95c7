// Words, swatches and lines over a picture or a plot.
#pragma once

#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "view/picture/image.h"

class vtkPolyData;
class vtkRenderer;

namespace kerf {

enum class Align { kLeft, kCentre, kRight };

struct TextStyle {
  int size = 18;  // pixels of the finished picture
  Rgb8 colour{40, 44, 52};
  bool bold = false;
  Align align = Align::kLeft;
  bool upward =
      false;  // turned by 90 degrees, read from below; `column` is then the text's left edge, and Align goes upward
};

/// In pixels of the finished picture, from its top left.
struct OverlayPoint {
  double column;
  double row;
};

/// Puts flat things over what a renderer draws, the later above the earlier. Positions and sizes in pixels of the
/// finished picture, from its top left.
class Overlay {
 public:
  /// The window shows `padding` pixels more on each side than the finished picture.
  Overlay(vtkRenderer& renderer, int height, int supersampling, int padding = 0)
      : renderer_(renderer), height_(height), supersampling_(supersampling), padding_(padding) {}

  struct Size {
    double width;
    double height;
  };
  Size MeasureText(const std::string& text, const TextStyle& style) const;
  /// `row` is the text's top.
  void AddText(const std::string& text, double column, double row, const TextStyle& style);
  void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity = 1);
  /// A line of `width` pixels with round joins.
  void AddPolyline(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double opacity = 1);
  /// Stretched over the rectangle, smoothly.
  void AddImage(const Image& image, double left, double top, double width, double height);
  void AddDiscs(const std::vector<OverlayPoint>& centres, double diameter, const Rgb8& colour);
  /// Filled; corners in order, star-shaped about their mean.
  void AddPolygon(const std::vector<OverlayPoint>& corners, const Rgb8& colour);

 private:
  void AddFlat(vtkPolyData& data, const Rgb8& colour, double opacity);

  vtkRenderer& renderer_;
  int height_;
  int supersampling_;
  int padding_;
};

}  // namespace kerf
