// Layout of the text around a picture.
#pragma once

#include <string>

#include "view/picture/overlay.h"
#include "view/picture/picture.h"

namespace kerf {

inline constexpr double kLegendLine = 1.5;  // line spacing of a legend, in letter heights
inline constexpr double kLegendText = 1.6;  // from the left edge of its swatches to its text

/// Sizes in pixels of the finished picture. They scale with its height, so that text stays legible when the picture is
/// scaled to a page; in a narrow picture, with its width.
struct Layout {
  explicit Layout(const PictureSpec& spec);

  bool has_words() const { return !title.empty() || !caption.empty(); }

  int supersampling;  // pixels drawn for one of the picture, along each side, for smooth edges and letters
  double unit;        // 1 at 1280 x 720 pixels
  TextStyle title_style;
  TextStyle caption_style;
  int text_size;
  int small_size;
  int legend_size;      // smaller if the legend has many lines
  double legend_width;  // 0 if there is none
  double edge;          // between the picture's edge and text
  // Title and caption, with line breaks where a line would reach the legend or the picture's edge.
  std::string title;
  std::string caption;
  double caption_top;
  double words_bottom;  // of both

  double left_margin, right_margin, top_margin, bottom_margin;  // kept free of fitted shapes
};

/// Throws Error if there is nothing to fit or a value is out of range.
ViewFrame CalcViewFrame(const PictureSpec& spec, const Layout& layout);

/// Returns one of the 8 corners of a box; bit i of `corner` selects the side along axis i.
Vec3 CornerOf(const Box3& box, int corner);

}  // namespace kerf
