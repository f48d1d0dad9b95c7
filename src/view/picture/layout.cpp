#include "view/picture/layout.h"

#include <vtkNew.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kerf {

Layout::Layout(const PictureSpec& spec)
    : unit(std::clamp(std::min(spec.height / 720.0, spec.width / 640.0), 0.5, 8.0)) {
  constexpr int kMostSide = 4096;  // of twice as large a window, which drivers support
  supersampling = std::max(spec.width, spec.height) <= kMostSide ? 2 : 1;
  title_style = {static_cast<int>(std::round(26 * unit)), spec.dark ? Rgb8{240, 240, 240} : Rgb8{33, 37, 43}, true};
  text_size = static_cast<int>(std::round(18 * unit));
  caption_style = {text_size, spec.dark ? Rgb8{190, 194, 200} : Rgb8{85, 92, 102}};
  small_size = static_cast<int>(std::round(15 * unit));
  edge = std::round(24 * unit);
  const double cube = 130 * unit;
  const double lines = static_cast<double>(std::max<std::size_t>(spec.legend.size(), 1));
  legend_size = std::clamp(static_cast<int>((spec.height - 2 * edge - cube) / (lines * kLegendLine)), 8, text_size);

  const vtkNew<vtkRenderer> unused;
  const Overlay words(*unused, spec.height, supersampling);
  const auto measure_legend = [&] {
    double width = 0;
    for (const LegendEntry& entry : spec.legend) {
      width = std::max(width, kLegendText * legend_size + words.MeasureText(entry.text, {legend_size}).width);
    }
    return width;
  };
  legend_width = measure_legend();
  if (const double most = 0.4 * spec.width; legend_width > most) {
    legend_size = std::max(8, static_cast<int>(legend_size * most / legend_width));
    legend_width = measure_legend();
  }
  const double free_width = spec.width - 2 * edge - (spec.legend.empty() ? 0 : legend_width + text_size);
  title = words.Wrap(spec.title, free_width, title_style);
  caption = words.Wrap(spec.caption, free_width, caption_style);
  caption_top = words_bottom = edge;
  if (!title.empty()) {
    words_bottom += words.MeasureText(title, title_style).height;
    caption_top = words_bottom + 0.45 * title_style.size;
  }
  if (!caption.empty()) words_bottom = caption_top + words.MeasureText(caption, caption_style).height;

  // In small pictures, the margins leave a part of each side.
  left_margin = right_margin = 0.04 * spec.width;
  if (spec.axes) left_margin = std::min(left_margin + 75 * unit, 0.4 * spec.width);
  // A tall legend gets the right margin for itself.
  if (lines > 6 || (spec.axes && !spec.legend.empty())) {
    right_margin = std::min(edge + legend_width + legend_size, 0.45 * spec.width);
  }
  top_margin = has_words() ? words_bottom + 0.5 * text_size : 0.05 * spec.height;
  if (spec.axes) top_margin += 0.5 * text_size;
  top_margin = std::min(top_margin, 0.5 * spec.height);
  bottom_margin = spec.scale_bar ? edge + 2.2 * text_size : 0.05 * spec.height;
  if (spec.axes) bottom_margin += 60 * unit;
  bottom_margin = std::min(bottom_margin, 0.35 * spec.height);
}

}  // namespace kerf
