// Sheet of images side by side, each with coordinates in mm along its edges and a grid over it.
#pragma once

#include <string>
#include <vector>

#include "view/picture/image.h"

namespace kerf {

/// Marked position, drawn as a disc with text next to it.
struct PanelMark {
  double across_mm;
  double down_mm;
  Rgb8 colour;
  std::string text;
};

/// Image whose pixels are positions in a plane. Coordinates may increase from left to right or from right to left, and
/// from top to bottom or from bottom to top.
struct Panel {
  std::string title;
  Image image;
  double left_mm = 0, right_mm = 0, top_mm = 0, bottom_mm = 0;  // coordinates at the image's edges
  std::string across_name, down_name;                           // names of the axes, with unit
  std::string left_letter, right_letter;                        // labels at the edges: "R" and "L"; optional
  std::vector<double> levels_mm;  // positions of horizontal lines, on the axis that runs down
  std::vector<PanelMark> marks;
};

struct SheetSpec {
  int width = 2400;  // pixels
  int height = 1800;
  std::string title;
  std::string caption;  // smaller, below the title
  std::vector<Panel> panels;
};

/// Position of a panel's image in the sheet, in pixels from the top left.
struct PanelPlace {
  double left, right, top, bottom;
};

/// Draws all panels in rows from the top left, at the largest common scale at which they fit. Throws Error if there is
/// no panel, no space, or this machine cannot draw.
Image RenderSheet(const SheetSpec& spec, std::vector<PanelPlace>* places = nullptr);
/// Writes RenderSheet() as a PNG.
void WriteSheet(const SheetSpec& spec, const std::string& path);

}  // namespace kerf
