// Layout of the text around a picture.
#pragma once

#include "view/picture/picture.h"

namespace kerf {

inline constexpr double kLegendLine = 1.5;  // line spacing of a legend, in letter heights

/// Sizes in pixels of the finished picture. They scale with its height, so that text stays legible when the picture is
/// scaled to a page.
struct Layout {
  explicit Layout(const PictureSpec& spec);

  double unit;  // 1 at 720 pixels of height
  int title_size;
  int text_size;
  int small_size;
  int legend_size;                                              // smaller if the legend has many lines
  double edge;                                                  // between the picture's edge and text
  double left_margin, right_margin, top_margin, bottom_margin;  // kept free of fitted shapes
};

/// Returns one of the 8 corners of a box; bit i of `corner` selects the side along axis i.
Vec3 CornerOf(const Box3& box, int corner);

}  // namespace kerf
