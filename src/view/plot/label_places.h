// Positions of point labels with as little overlap as possible with each other, the marks and the lines.
#pragma once

#include <string>
#include <vector>

#include "view/picture/overlay.h"

namespace kerf {

struct LabelBox {
  double left, top, width, height;  // pixels
};

struct LabelRequest {
  OverlayPoint at;     // centre of its mark
  double reach = 6;    // minimum distance of the label from there, pixels
  Overlay::Size size;  // of the text
};

struct LabelObstacles {
  LabelBox frame{};             // labels stay inside
  std::vector<LabelBox> boxes;  // existing text and marks
  std::vector<std::pair<OverlayPoint, OverlayPoint>> lines;
};

/// Returns a position for each label, in the order of `requests` (greedy: eight directions around the mark, from near
/// to far; Christensen, Marks and Shieber 1995 describe this method and find it good enough for a small number of
/// labels).
std::vector<LabelBox> PlaceLabels(const std::vector<LabelRequest>& requests, const LabelObstacles& obstacles);

}  // namespace kerf
