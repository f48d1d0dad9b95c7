#include "view/picture/layout.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kerf {

Layout::Layout(const PictureSpec& spec) : unit(std::clamp(spec.height / 720.0, 0.5, 8.0)) {
  title_size = static_cast<int>(std::round(26 * unit));
  text_size = static_cast<int>(std::round(18 * unit));
  small_size = static_cast<int>(std::round(15 * unit));
  edge = std::round(24 * unit);
  const double cube = 130 * unit;
  const double lines = static_cast<double>(std::max<std::size_t>(spec.legend.size(), 1));
  legend_size = std::clamp(static_cast<int>((spec.height - 2 * edge - cube) / (lines * kLegendLine)), 8, text_size);
  left_margin = right_margin = 0.04 * spec.width;
  if (lines > 6 || (spec.axes && !spec.legend.empty())) {
    // A tall legend gets the right margin for itself. A letter is about half as wide as high.
    std::size_t letters = 0;
    for (const LegendEntry& entry : spec.legend) letters = std::max(letters, entry.text.size());
    right_margin = std::min(edge + legend_size * (2.6 + 0.53 * static_cast<double>(letters)), 0.45 * spec.width);
  }
  const bool words_above = !spec.title.empty() || !spec.caption.empty();
  top_margin = words_above ? edge + 1.45 * title_size + 1.2 * text_size : 0.05 * spec.height;
  bottom_margin = spec.scale_bar ? edge + 2.2 * text_size : 0.05 * spec.height;
  if (spec.axes) {
    left_margin += 75 * unit;
    top_margin += 0.5 * text_size;
    bottom_margin += 60 * unit;
  }
}

}  // namespace kerf
