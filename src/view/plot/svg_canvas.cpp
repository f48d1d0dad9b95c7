#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "base/files/html_text.h"
#include "kerf/error.h"
#include "view/plot/plot_canvas.h"

namespace kerf {
namespace {

/// Ascent and line height of VTK's own font, as fractions of the letter size.
constexpr double kAscent = 0.93;
constexpr double kLineHeight = 1.15;

std::string Show(const Rgb8& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

// Rounds to hundredths of a pixel: more is not visible, and rounding errors in the last bit do not change the file.
std::string Show(double value) {
  const double rounded = std::round(100 * value) / 100;
  return fmt::format("{:g}", rounded == 0 ? 0.0 : rounded);
}

std::string ShowPoints(const std::vector<OverlayPoint>& points) {
  std::string text;
  for (const OverlayPoint& p : points) {
    fmt::format_to(std::back_inserter(text), "{}{},{}", text.empty() ? "" : " ", Show(p.column), Show(p.row));
  }
  return text;
}

}  // namespace

SvgCanvas::SvgCanvas(vtkRenderer& renderer, int width, int height, int supersampling)
    : PlotCanvas(Overlay(renderer, height, supersampling)), width_(width), height_(height) {}

void SvgCanvas::AddText(const std::string& text, double column, double row, const TextStyle& style) {
  if (text.empty()) return;
  const char* anchor = style.align == Align::kLeft ? "start" : style.align == Align::kCentre ? "middle" : "end";
  std::size_t begin = 0;
  for (int line = 0; begin <= text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const double down = style.size * (kAscent + kLineHeight * line);
    const double x = style.upward ? column + down : column;
    const double y = style.upward ? row : row + down;
    const std::string turn =
        style.upward ? fmt::format(" transform=\"rotate(-90 {} {})\"", Show(x), Show(y)) : std::string();
    fmt::format_to(std::back_inserter(body_),
                   "<text x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{}\"{}{}>{}</text>\n", Show(x),
                   Show(y), style.size, Show(style.colour), anchor, style.bold ? " font-weight=\"bold\"" : "", turn,
                   EscapeHtml(std::string_view(text).substr(begin, end - begin)));
    begin = end + 1;
  }
}

void SvgCanvas::AddBox(double left, double top, double width, double height, const Rgb8& colour, double opacity) {
  fmt::format_to(std::back_inserter(body_), "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"{}/>\n",
                 Show(left), Show(top), Show(width), Show(height), Show(colour),
                 opacity < 1 ? fmt::format(" fill-opacity=\"{}\"", Show(opacity)) : std::string());
}

void SvgCanvas::AddLine(const std::vector<OverlayPoint>& points, double width, const Rgb8& colour, double dash) {
  if (points.size() < 2) return;
  fmt::format_to(
      std::back_inserter(body_),
      "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{}/>\n",
      ShowPoints(points), Show(colour), Show(width),
      dash > 0 ? fmt::format(" stroke-dasharray=\"{}\"", Show(std::max(1.0, dash))) : std::string());
}

void SvgCanvas::AddMarkers(const std::vector<OverlayPoint>& centres, const MarkerStyle& style) {
  const double radius = 0.5 * style.diameter;
  const double line = std::max(1.0, 0.18 * style.diameter);
  const std::string paint =
      style.hollow ? fmt::format("fill=\"#ffffff\" stroke=\"{}\" stroke-width=\"{}\"", Show(style.colour), Show(line))
                   : fmt::format("fill=\"{}\"", Show(style.colour));
  for (const OverlayPoint& centre : centres) {
    if (style.shape == Marker::kDisc) {
      fmt::format_to(std::back_inserter(body_), "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" {}/>\n", Show(centre.column),
                     Show(centre.row), Show(radius), paint);
      continue;
    }
    std::vector<OverlayPoint> corners;
    for (const OverlayPoint& p : OutlineOf(style.shape)) {
      corners.push_back({centre.column + radius * p.column, centre.row + radius * p.row});
    }
    if (!IsStrokes(style.shape)) {
      fmt::format_to(std::back_inserter(body_), "<polygon points=\"{}\" {}/>\n", ShowPoints(corners), paint);
      continue;
    }
    for (std::size_t i = 0; i + 1 < corners.size(); i += 2) {
      AddLine({corners[i], corners[i + 1]}, line, style.colour, 0);
    }
  }
}

std::string SvgCanvas::Finish(const std::string& title) const {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Arial, 'Liberation Sans', Helvetica, sans-serif\">\n<title>{2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{3}</svg>\n",
      width_, height_, EscapeHtml(title), body_);
}

}  // namespace kerf
