#include "view/plot/label_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "view/plot/clip.h"

namespace kerf {
namespace {

// Cost of a position: overlap with other text counts most, marks and lines less, and distance a little.
constexpr double kTextCost = 8;
constexpr double kLineCost = 5;  // per pixel of line under the label
constexpr double kDistanceCost = 1.5;

double Overlap(const LabelBox& a, const LabelBox& b) {
  const double width = std::min(a.left + a.width, b.left + b.width) - std::max(a.left, b.left);
  const double height = std::min(a.top + a.height, b.top + b.height) - std::max(a.top, b.top);
  return width > 0 && height > 0 ? width * height : 0;
}

double Outside(const LabelBox& box, const LabelBox& frame) {
  return box.width * box.height - Overlap(box, frame);
}

// Returns the length of the part of a segment inside the box.
double LengthInside(const OverlayPoint& a, const OverlayPoint& b, const LabelBox& box) {
  const auto part = ClipSegment(a, b, {box.left, box.top, box.left + box.width, box.top + box.height});
  if (!part || part->to <= part->from) return 0;
  return (part->to - part->from) * std::hypot(b.column - a.column, b.row - a.row);
}

}  // namespace

std::vector<LabelBox> PlaceLabels(const std::vector<LabelRequest>& requests, const LabelObstacles& obstacles) {
  struct Direction {
    double x, y;
  };
  // In order of preference: if all are equally free, a label is placed at the upper right.
  constexpr std::array<Direction, 8> kDirections{
      {{0.8, -0.8}, {0.8, 0.8}, {1, 0}, {-0.8, -0.8}, {-0.8, 0.8}, {0, -1}, {0, 1}, {-1, 0}}};
  constexpr std::array<double, 5> kDistances{1, 1.6, 2.6, 4, 6};
  std::vector<LabelBox> placed;
  for (const LabelRequest& request : requests) {
    LabelBox best{};
    double least = std::numeric_limits<double>::infinity();
    double order = 0;
    for (const double distance : kDistances) {
      for (const Direction& direction : kDirections) {
        const double away = request.reach * distance;
        const double x = request.at.column + direction.x * away;
        const double y = request.at.row + direction.y * away;
        const double fraction_x = direction.x > 0 ? 0 : direction.x < 0 ? 1 : 0.5;
        const double fraction_y = direction.y > 0 ? 0 : direction.y < 0 ? 1 : 0.5;
        const LabelBox box{x - fraction_x * request.size.width, y - fraction_y * request.size.height,
                           request.size.width, request.size.height};
        double cost = 1e-3 * order++ + kDistanceCost * (away - request.reach) + 100 * Outside(box, obstacles.frame);
        for (const LabelBox& other : placed) cost += kTextCost * Overlap(box, other);
        for (const LabelBox& other : obstacles.boxes) cost += kTextCost * Overlap(box, other);
        for (const auto& [a, b] : obstacles.lines) cost += kLineCost * LengthInside(a, b, box);
        if (cost < least) least = cost, best = box;
      }
    }
    placed.push_back(best);
  }
  return placed;
}

}  // namespace kerf
