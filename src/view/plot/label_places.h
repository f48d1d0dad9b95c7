// Where labels of points stand so that they cover each other, the marks and the lines as little as can be.
#pragma once

#include <string>
#include <vector>

#include "view/picture/overlay.h"

namespace kerf {

struct LabelBox {
  double left, top, width, height;  // pixels
};

struct LabelWish {
  OverlayPoint at;     // the middle of its mark
  double reach = 6;    // from there to where the label may begin, pixels
  Overlay::Size size;  // of the words
};

struct LabelObstacles {
  LabelBox frame{};             // labels stay inside
  std::vector<LabelBox> boxes;  // words and marks that are there already
  std::vector<std::pair<OverlayPoint, OverlayPoint>> lines;
};

/// A place for each wish, the first ones first (greedy: eight directions about the mark, from near to far; Christensen,
/// Marks and Shieber 1995 call it so and find it good enough for few labels).
std::vector<LabelBox> PlaceLabels(const std::vector<LabelWish>& wishes, const LabelObstacles& obstacles);

}  // namespace kerf
