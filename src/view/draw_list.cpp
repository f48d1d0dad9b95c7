#include "view/draw_list.h"

#include <array>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

// Of Helvetica, from the space to the tilde, thousandths of the letter's size.
constexpr std::array<int, 95> kWidths{278,  278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
                                      556,  556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
                                      1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
                                      667,  778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
                                      333,  556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
                                      556,  556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584};

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
    const double angle = 2 * 3.14159265358979323846 * i / kCorners;
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
    if (code >= 0x80 && code < 0xc0) continue;  // goes on from the byte before
    sum += code >= 32 && code < 127 ? kWidths[code - 32u] : 700;
  }
  return (bold ? 1.07 : 1.0) * size * sum / 1000;
}

std::string CutText(const std::string& text, double size, bool bold, double width) {
  if (CalcTextWidth(text, size, bold) <= width) return text;
  std::string cut = text;
  while (!cut.empty() && CalcTextWidth(cut + "...", size, bold) > width) {
    // Whole letters, not bytes of them.
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
