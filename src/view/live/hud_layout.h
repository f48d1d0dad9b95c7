// Layout of the panels. Pure: equal contents in an equal window give equal positions.
#pragma once

#include <vector>

#include "view/live/draw_list.h"
#include "view/live/hud.h"

namespace kerf {

/// Sizes of text, lines and panels, points.
struct HudSizes {
  static constexpr double kEdge = 8;      // between panels, and between panels and the window's edge
  static constexpr double kInset = 10;    // between a panel's edge and its text
  static constexpr double kColumn = 236;  // width of the left column
  static constexpr double kSlices = 168;  // maximum width of a slice's panel
  static constexpr double kStatus = 28;   // height of the status line
  static constexpr double kLegend = 232;
  static constexpr double kCube = 104;
  static constexpr int kText = 15;
  static constexpr int kSmall = 13;
  static constexpr int kTitle = 20;
  static constexpr double kRow = 22;  // line spacing of kText
  static constexpr double kSmallRow = 18;
};

/// Elements that need space besides the panels of the state.
struct HudExtras {
  int slices = 0;  // 0 or 3
  bool orientation = true;
  bool scale_bar = true;
};

/// Positions of all panels. A box is empty if its panel is not shown, because it has no contents or there is no space
/// for it. Less important panels are dropped first.
struct HudLayout {
  double width = 0;  // width of the window, points
  double height = 0;
  FlatBox values, plot, gauge, pieces;  // the left column
  FlatBox banner;                       // at the top, between the columns
  FlatBox legend;
  std::vector<FlatBox> slices;  // the right column
  FlatBox orientation, scale_bar;
  FlatBox status;               // along the bottom
  FlatBox modal;                // help, menu, result or progress over a covered scene; other panels are hidden
  FlatBox scene;                // free area for the view of the bone
  std::size_t legend_rows = 0;  // number of rows that fit
  std::size_t piece_rows = 0;

  /// Returns all boxes that are not empty, except `scene`.
  std::vector<FlatBox> Panels() const;
};

/// Computes the layout. `width`, `height`: size of the window in points (pixels divided by scale).
HudLayout CalcHudLayout(double width, double height, const HudState& state, const HudExtras& extras);

/// Height of the force plot without its note, and of a line of the note; points.
inline constexpr double kPlotHeight = 138;
inline constexpr double kNoteLine = 15;
/// Splits the note below the plot into lines that fit.
std::vector<std::string> WrapForceNote(const HudState& state);

/// Position of one group of the help's entries. Groups are placed in order, each in the column that is least full.
struct HelpPlace {
  std::size_t group = 0;
  double x = 0;
  double y = 0;
  double width = 0;
};
std::vector<HelpPlace> PlaceHelp(const std::vector<HudKeyGroup>& groups, const FlatBox& inside);

/// Returns the first visible row of a list that is longer than its space.
std::size_t FirstRow(std::size_t rows, std::size_t shown, std::size_t selected);

/// Boxes of the visible rows of a menu, starting with row `first`.
struct MenuRows {
  std::size_t first = 0;
  std::vector<FlatBox> rows;
};
MenuRows PlaceMenuRows(const HudMenu& menu, const FlatBox& modal);
/// Returns the boxes of the visible rows of the pieces panel.
MenuRows PlacePieceRows(const std::vector<HudPiece>& pieces, const HudLayout& layout);

}  // namespace kerf
