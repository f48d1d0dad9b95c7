#include "view/plot/plot_canvas.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

// Returns the corners of a regular polygon or, with two radii, of a star; the first points upwards.
std::vector<OverlayPoint> MakeCorners(int count, double radius, double other_radius, double turn) {
  std::vector<OverlayPoint> corners;
  for (int i = 0; i < count; ++i) {
    const double angle = turn + 2 * std::numbers::pi * i / count - 0.5 * std::numbers::pi;
    const double r = i % 2 == 0 ? radius : other_radius;
    corners.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return corners;
}

}  // namespace

bool IsStrokes(Marker shape) {
  return shape == Marker::kCross || shape == Marker::kPlus;
}

std::vector<OverlayPoint> OutlineOf(Marker shape) {
  // Factors that make the marks look equally large.
  switch (shape) {
    case Marker::kSquare:
      return MakeCorners(4, 1.2, 1.2, 0.25 * std::numbers::pi);
    case Marker::kDiamond:
      return MakeCorners(4, 1.25, 1.25, 0);
    case Marker::kTriangleUp:
      return MakeCorners(3, 1.3, 1.3, 0);
    case Marker::kTriangleDown:
      return MakeCorners(3, 1.3, 1.3, std::numbers::pi);
    case Marker::kCross:
      return {{-0.85, -0.85}, {0.85, 0.85}, {-0.85, 0.85}, {0.85, -0.85}};
    case Marker::kPlus:
      return {{-1.1, 0}, {1.1, 0}, {0, -1.1}, {0, 1.1}};
    case Marker::kStar:
      return MakeCorners(10, 1.4, 0.6, 0);
    case Marker::kDisc:
      break;
  }
  return MakeCorners(24, 1, 1, 0);
}

void PixelCanvas::AddText(const std::string& text, double column, double row, const TextStyle& style) {
  overlay_.AddText(text, column, row, style);
}

void PixelCanvas::AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) {
  overlay_.AddBox(left, top, width, height, colour, opacity);
}

void PixelCanvas::AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) {
  if (points.size() < 2) return;
  if (dash <= 0) return overlay_.AddPolyline(points, width, colour);
  dash = std::max(1.0, dash);
  double walked = 0;  // in the current dash or gap
  bool on = true;
  std::vector<OverlayPoint> stroke{points.front()};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const OverlayPoint& a = points[i];
    const OverlayPoint& b = points[i + 1];
    const double length = std::hypot(b.column - a.column, b.row - a.row);
    double at = 0;
    while (length - at >= dash - walked) {
      at += dash - walked;
      walked = 0;
      const double t = at / length;
      const OverlayPoint p{a.column + t * (b.column - a.column), a.row + t * (b.row - a.row)};
      if (on) {
        stroke.push_back(p);
        overlay_.AddPolyline(stroke, width, colour);
      }
      on = !on;
      stroke = {p};
    }
    walked += length - at;
    if (on) stroke.push_back(b);
  }
  if (on && stroke.size() > 1) overlay_.AddPolyline(stroke, width, colour);
}

void PixelCanvas::AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) {
  if (centres.empty()) return;
  if (style.shape == Marker::kDisc && !style.hollow) {
    return overlay_.AddDiscs(centres, style.diameter, style.colour);
  }
  const std::vector<OverlayPoint> outline = OutlineOf(style.shape);
  const double radius = 0.5 * style.diameter;
  const double line = std::max(1.0, 0.18 * style.diameter);
  for (const OverlayPoint& centre : centres) {
    std::vector<OverlayPoint> corners;
    for (const OverlayPoint& p : outline) {
      corners.push_back({centre.column + radius * p.column, centre.row + radius * p.row});
    }
    if (IsStrokes(style.shape)) {
      for (std::size_t i = 0; i + 1 < corners.size(); i += 2) {
        overlay_.AddPolyline({corners[i], corners[i + 1]}, line, style.colour);
      }
      continue;
    }
    overlay_.AddPolygon(corners, style.hollow ? Rgb8{255, 255, 255} : style.colour);
    if (!style.hollow) continue;
    corners.push_back(corners[0]);
    corners.push_back(corners[1]);  // for the join at the first corner
    overlay_.AddPolyline(corners, line, style.colour);
  }
}

}  // namespace kerf
