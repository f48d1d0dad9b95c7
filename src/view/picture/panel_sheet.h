// Pictures side by side, each with coordinates in mm along its edges and a grid over it.
#pragma once

#include <string>
#include <vector>

#include "view/picture/image.h"

namespace kerf {

/// A place of note, shown as a disc with words beside it.
struct PanelMark {
  double across_mm;
  double down_mm;
  Rgb8 colour;
  std::string text;
};

/// A picture of which each pixel is a place. A coordinate grows from left to right or the other way round; likewise
/// from top to bottom.
struct Panel {
  std::string title;
  Image image;
  double left_mm = 0, right_mm = 0, top_mm = 0, bottom_mm = 0;  // coordinates at the picture's edges
  std::string across_name, down_name;                           // of the axes, with their unit
  std::string left_letter, right_letter;                        // at the edges: "R" and "L"; may be empty
  std::vector<double> levels_mm;  // lines from left to right, at these places of the other axis
  std::vector<PanelMark> marks;
};

struct SheetSpec {
  int width = 2400;  // 200 to 8192 pixels
  int height = 1800;
  std::string title;
  std::string caption;  // smaller, below the title
  std::vector<Panel> panels;
};

/// Where a panel's picture lies in the sheet, in pixels from the top left.
struct PanelPlace {
  double left, right, top, bottom;
};

/// All panels at one scale, the largest at which they fit; in rows, from the top left. Throws Error when there is no
/// panel, no room, or this machine can't draw.
Image RenderSheet(const SheetSpec& spec, std::vector<PanelPlace>* places = nullptr);
/// RenderSheet as a PNG.
void WriteSheet(const SheetSpec& spec, const std::string& path);

}  // namespace kerf
