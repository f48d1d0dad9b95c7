// Ordered list of flat primitives used to draw the panels. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/picture/image.h"
#include "view/picture/overlay.h"

namespace kerf {

/// Rectangle in points from the top left of the screen; a point is a pixel divided by the display scale.
struct FlatBox {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
  bool empty() const { return !(width > 0 && height > 0); }
  bool Contains(double x, double y) const { return x >= left && x < right() && y >= top && y < bottom(); }
};
bool Overlap(const FlatBox& a, const FlatBox& b);

struct FlatColour {
  Rgb8 rgb{0, 0, 0};
  double alpha = 1;
};

struct FlatTriangle {
  OverlayPoint corners[3];
  FlatColour colour;
};
struct FlatText {
  std::string text;
  double x = 0;  // left edge, middle or right edge, depending on `align`
  double y = 0;  // top of the line
  int size = 14;
  bool bold = false;
  bool upward = false;  // rotated to read upward; x is then its left edge and y its middle
  Align align = Align::kLeft;
  FlatColour colour;
};
struct FlatPicture {
  FlatBox box;
  const Image* image = nullptr;  // must exist until it has been drawn
  std::uint64_t version = 0;     // changes if the pixels have changed
};

/// Primitives in drawing order. Each kind has its own list; `steps` keeps the order between kinds.
class DrawList {
 public:
  void Box(const FlatBox& box, const FlatColour& colour);
  void Frame(const FlatBox& box, double line, const FlatColour& colour);
  /// Adds a panel's background with a thin edge.
  void Panel(const FlatBox& box, const FlatColour& ground, const FlatColour& edge);
  void Line(const OverlayPoint& a, const OverlayPoint& b, double width, const FlatColour& colour);
  void Polyline(const std::vector<OverlayPoint>& points, double width, const FlatColour& colour);
  void Triangle(const OverlayPoint& a, const OverlayPoint& b, const OverlayPoint& c, const FlatColour& colour);
  void Disc(const OverlayPoint& centre, double diameter, const FlatColour& colour);
  void Text(FlatText text);
  void Picture(const FlatBox& box, const Image& image, std::uint64_t version);

  enum class Kind : std::uint8_t { kTriangles, kText, kPicture };
  struct Step {
    Kind kind;
    std::size_t first;
    std::size_t count;
  };
  const std::vector<Step>& steps() const { return steps_; }
  const std::vector<FlatTriangle>& triangles() const { return triangles_; }
  const std::vector<FlatText>& texts() const { return texts_; }
  const std::vector<FlatPicture>& pictures() const { return pictures_; }
  void Clear();

 private:
  void Count(Kind kind, std::size_t so_far);

  std::vector<Step> steps_;
  std::vector<FlatTriangle> triangles_;
  std::vector<FlatText> texts_;
  std::vector<FlatPicture> pictures_;
};

/// Returns the width of a text, computed from the letter widths of VTK's sans-serif font; within 5 % of the drawn
/// width. Non-ASCII letters count as wide ones.
double CalcTextWidth(const std::string& text, double size, bool bold);
/// Returns the part of the text that fits into `width`, with "..." appended if text is left out.
std::string CutText(const std::string& text, double size, bool bold, double width);
/// Splits the text at spaces into lines that fit into `width`.
std::vector<std::string> WrapText(const std::string& text, double size, bool bold, double width);

}  // namespace kerf
