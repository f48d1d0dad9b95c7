// Where the words around a picture stand.
#pragma once

#include "view/picture/picture.h"

namespace kerf {

inline constexpr double kLegendLine = 1.5;  // distance of its lines, in letter heights

/// Sizes in pixels of the finished picture. They follow its height, so that words stay legible when a picture is scaled
/// to a page.
struct Layout {
  explicit Layout(const PictureSpec& spec);

  double unit;  // 1 at 720 pixels of height
  int title_size;
  int text_size;
  int small_size;
  int legend_size;                                              // smaller when there are many lines
  double edge;                                                  // between the picture's edge and words
  double left_margin, right_margin, top_margin, bottom_margin;  // kept free of fitted shapes
};

/// One of the 8 corners of a box, by a bit for each axis.
Vec3 CornerOf(const Box3& box, int corner);

}  // namespace kerf
