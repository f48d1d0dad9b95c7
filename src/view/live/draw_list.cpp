#include "view/live/draw_list.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace kerf {
namespace {

// Letter widths of VTK's sans-serif font, from space to tilde, in thousandths of the letter size.
constexpr std::array<int, 95> kWidths{277, 295, 309, 554, 554, 775, 757, 198, 369, 369, 425, 606, 277, 332, 277, 437,
                                      554, 554, 554, 554, 554, 554, 554, 554, 554, 554, 277, 277, 606, 606, 606, 591,
                                      867, 740, 574, 813, 744, 536, 485, 872, 683, 226, 482, 591, 462, 919, 740, 869,
                                      592, 871, 607, 498, 426, 655, 702, 960, 609, 592, 480, 351, 605, 351, 606, 500,
                                      378, 683, 682, 647, 685, 650, 314, 673, 610, 200, 203, 502, 200, 938, 610, 655,
                                      682, 682, 301, 388, 339, 608, 554, 831, 480, 536, 425, 351, 672, 351, 606};
constexpr std::array<int, 95> kBoldWidths{
    280, 280, 360, 560, 560, 860, 680, 220, 380, 380, 440, 600, 280, 420, 280, 460, 560, 560, 560,
    560, 560, 560, 560, 560, 560, 560, 280, 280, 600, 600, 600, 560, 740, 740, 580, 780, 700, 520,
    480, 840, 680, 280, 480, 620, 440, 900, 740, 840, 560, 840, 580, 520, 420, 640, 700, 900, 680,
    620, 500, 320, 640, 320, 600, 500, 420, 660, 660, 640, 660, 640, 280, 660, 600, 240, 260, 580,
    240, 940, 600, 640, 660, 660, 320, 440, 300, 600, 560, 800, 560, 580, 460, 340, 600, 340, 600};

}  // namespace

bool Overlap(const FlatBox& a, const FlatBox& b) {
  constexpr double kRounding = 1e-6;
  if (a.empty() || b.empty()) return false;
  return a.left < b.right() - kRounding && b.left < a.right() - kRounding && a.top < b.bottom() - kRounding &&
         b.top < a.bottom() - kRounding;
}

void DrawList::Count(Kind kind, std::size_t so_far) {
  if (!steps_.empty() && steps_.back().kind == kind) {
    ++steps_.back().count;
  } else {
    steps_.push_back({kind, so_far, 1});
  }
}

void DrawList::Triangle(const OverlayPoint& a, const OverlayPoint& b, const OverlayPoint& c, const FlatColour& colour) {
  Count(Kind::kTriangles, triangles_.size());
  triangles_.push_back({{a, b, c}, colour});
}

void DrawList::Box(const FlatBox& box, const FlatColour& colour) {
  if (box.empty()) return;
  const OverlayPoint corners[4] = {
      {box.left, box.top}, {box.right(), box.top}, {box.right(), box.bottom()}, {box.left, box.bottom()}};
  Triangle(corners[0], corners[1], corners[2], colour);
  Triangle(corners[0], corners[2], corners[3], colour);
}

void DrawList::Frame(const FlatBox& box, double line, const FlatColour& colour) {
  Box({box.left, box.top, box.width, line}, colour);
  Box({box.left, box.bottom() - line, box.width, line}, colour);
  Box({box.left, box.top + line, line, box.height - 2 * line}, colour);
  Box({box.right() - line, box.top + line, line, box.height - 2 * line}, colour);
}

void DrawList::Panel(const FlatBox& box, const FlatColour& ground, const FlatColour& edge) {
  Box(box, ground);
  Frame(box, 1, edge);
}

void DrawList::Line(const OverlayPoint& a, const OverlayPoint& b, double width, const FlatColour& colour) {
  const double length = std::hypot(b.column - a.column, b.row - a.row);
  if (length <= 0) return;
  const double x = 0.5 * width * (b.row - a.row) / length;
  const double y = -0.5 * width * (b.column - a.column) / length;
  Triangle({a.column + x, a.row + y}, {b.column + x, b.row + y}, {b.column - x, b.row - y}, colour);
  Triangle({a.column + x, a.row + y}, {b.column - x, b.row - y}, {a.column - x, a.row - y}, colour);
}

void DrawList::Polyline(const std::vector<OverlayPoint>& points, double width, const FlatColour& colour) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i) Line(points[i], points[i + 1], width, colour);
}

void DrawList::Disc(const OverlayPoint& centre, double diameter, const FlatColour& colour) {
  constexpr int kCorners = 24;
  const auto at = [&](int i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    return OverlayPoint{centre.column + 0.5 * diameter * std::cos(angle),
                        centre.row + 0.5 * diameter * std::sin(angle)};
  };
  for (int i = 0; i < kCorners; ++i) Triangle(centre, at(i), at(i + 1), colour);
}

void DrawList::Text(FlatText text) {
  if (text.text.empty()) return;
  Count(Kind::kText, texts_.size());
  texts_.push_back(std::move(text));
}

void DrawList::Picture(const FlatBox& box, const Image& image, std::uint64_t version) {
  Count(Kind::kPicture, pictures_.size());
  pictures_.push_back({box, &image, version});
}

void DrawList::Clear() {
  steps_.clear();
  triangles_.clear();
  texts_.clear();
  pictures_.clear();
}

double CalcTextWidth(const std::string& text, double size, bool bold) {
  double sum = 0;
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (code >= 0x80 && code < 0xc0) continue;  // continuation byte of UTF-8
    sum += code >= 32 && code < 127 ? (bold ? kBoldWidths : kWidths)[code - 32u] : 750;
  }
  return size * sum / 1000;
}

std::string CutText(const std::string& text, double size, bool bold, double width) {
  if (CalcTextWidth(text, size, bold) <= width) return text;
  std::string cut = text;
  while (!cut.empty() && CalcTextWidth(cut + "...", size, bold) > width) {
    // Removes whole characters, not single bytes.
    while (cut.size() > 1 && (static_cast<unsigned char>(cut.back()) & 0xc0u) == 0x80u) cut.pop_back();
    cut.pop_back();
  }
  return cut + "...";
}

std::vector<std::string> WrapText(const std::string& text, double size, bool bold, double width) {
  std::vector<std::string> lines;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    std::size_t end = text.find(' ', at);
    if (end == std::string::npos) end = text.size();
    const std::string word = text.substr(at, end - at);
    at = end + 1;
    std::string longer = line;
    if (!longer.empty()) longer += ' ';
    longer += word;
    if (line.empty() || CalcTextWidth(longer, size, bold) <= width) {
      line = longer;
    } else {
      lines.push_back(CutText(line, size, bold, width));
      line = word;
    }
  }
  if (!line.empty()) lines.push_back(CutText(line, size, bold, width));
  return lines;
}

}  // namespace kerf
