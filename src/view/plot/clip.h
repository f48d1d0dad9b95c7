// Clipping of segments to boxes.
#pragma once

#include <algorithm>
#include <optional>

#include "view/picture/overlay.h"

namespace kerf {

/// Edges of a box, pixels.
struct ClipBox {
  double left, top, right, bottom;
};

/// A part of a segment, as fractions of the way from its first point to its second.
struct SegmentPart {
  double from = 0;
  double to = 1;
};

/// Returns the part of the segment a-b inside the box (after Liang and Barsky, 1984); none if the segment is parallel
/// to an edge and beyond it. `from` exceeds `to` if no part lies inside.
inline std::optional<SegmentPart> ClipSegment(const OverlayPoint& a, const OverlayPoint& b, const ClipBox& box) {
  SegmentPart part;
  const double dx = b.column - a.column;
  const double dy = b.row - a.row;
  const double p[4] = {-dx, dx, -dy, dy};
  const double q[4] = {a.column - box.left, box.right - a.column, a.row - box.top, box.bottom - a.row};
  for (int i = 0; i < 4; ++i) {
    if (p[i] == 0) {
      if (q[i] < 0) return std::nullopt;
      continue;
    }
    const double t = q[i] / p[i];
    if (p[i] < 0) {
      part.from = std::max(part.from, t);
    } else {
      part.to = std::min(part.to, t);
    }
  }
  return part;
}

}  // namespace kerf
