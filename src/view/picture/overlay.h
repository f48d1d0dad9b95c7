// Text, boxes and lines over a picture or a plot.
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
  bool upward = false;  // rotated by 90 degrees, reads upwards; `column` is then the text's left edge, and `align`
                        // applies upwards
};

/// Position in pixels of the finished picture, from its top left.
struct OverlayPoint {
  double column;
  double row;
};

/// Draws flat primitives over the contents of a renderer, later ones above earlier ones. Positions and sizes are in
/// pixels of the finished picture, from its top left.
class Overlay {
 public:
  Overlay(vtkRenderer& renderer, int height, int supersampling)
      : renderer_(renderer), height_(height), supersampling_(supersampling) {}

  struct Size {
    double width;
    double height;
  };
  Size MeasureText(const std::string& text, const TextStyle& style) const;
  /// Returns the text with line breaks in place of spaces, and within words that are too long, so that no line is wider
  /// than `width` unless a letter is.
  std::string Wrap(const std::string& text, double width, const TextStyle& style) const;
  /// `row`: top of the text.
  void AddText(const std::string& text, double column, double row, const TextStyle& style);
  void AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity = 1);
  /// Draws a line of `width` pixels with round joins.
  void AddPolyline(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double opacity = 1);
  /// Draws an image stretched over the rectangle, with interpolation; at its own size, with its own pixels.
  void AddImage(const Image& image, double left, double top, double width, double height);
  void AddDiscs(const std::vector<OverlayPoint>& centres, double diameter, const Rgb8& colour);
  /// Draws a filled polygon. The corners must be in order, and the polygon star-shaped about their mean.
  void AddPolygon(const std::vector<OverlayPoint>& corners, const Rgb8& colour);

 private:
  /// Returns the length of the longest beginning of a word that fits, at least one letter; 0 if all of it fits.
  std::size_t FindFitting(const std::string& word, double width, const TextStyle& style) const;
  void AddFlat(vtkPolyData& data, const Rgb8& colour, double opacity);

  vtkRenderer& renderer_;
  int height_;
  int supersampling_;
};

}  // namespace kerf
