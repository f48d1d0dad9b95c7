// Where the panels stand. Pure: the same contents in the same window come to stand in the same places.
#pragma once

#include <vector>

#include "view/live/draw_list.h"
#include "view/live/hud.h"

namespace kerf {

/// Sizes of letters and lines, in points.
struct HudSizes {
  static constexpr double kEdge = 8;      // between panels, and to the window's edge
  static constexpr double kInset = 10;    // between a panel's edge and its words
  static constexpr double kColumn = 236;  // width of the left column
  static constexpr double kSlices = 168;  // width of a slice's panel at most
  static constexpr double kStatus = 28;   // height of the status line
  static constexpr double kLegend = 232;
  static constexpr double kCube = 104;
  static constexpr int kText = 15;
  static constexpr int kSmall = 13;
  static constexpr int kTitle = 20;
  static constexpr double kRow = 22;  // from line to line of kText
  static constexpr double kSmallRow = 18;
};

/// What else takes room besides the state's own panels.
struct HudExtras {
  int slices = 0;  // 0 or 3
  bool orientation = true;
  bool scale_bar = true;
};

/// Empty boxes: not shown, for want of contents or of room (the less needed first).
struct HudLayout {
  double width = 0;  // of the window, points
  double height = 0;
  FlatBox values, plot, gauge, pieces;  // the left column
  FlatBox banner;                       // at the top, between the columns
  FlatBox legend;
  std::vector<FlatBox> slices;  // the right column
  FlatBox orientation, scale_bar;
  FlatBox status;               // along the bottom
  FlatBox modal;                // help, menu, result or progress, over a covered scene; others are not shown
  FlatBox scene;                // what is left for looking at the bone
  std::size_t legend_rows = 0;  // that fit
  std::size_t piece_rows = 0;

  /// All that are not empty, but the scene.
  std::vector<FlatBox> Panels() const;
};

/// `width`, `height`: of the window in points (pixels by scale).
HudLayout CalcHudLayout(double width, double height, const HudState& state, const HudExtras& extras);

/// Of the plot of the force without its note, and of a line of the note; points.
inline constexpr double kPlotHeight = 138;
inline constexpr double kNoteLine = 15;
/// The note below the plot, in lines that fit.
std::vector<std::string> WrapForceNote(const HudState& state);

/// Columns of the help's groups, in order, each as low as it gets: for a modal box this wide and high.
struct HelpPlace {
  std::size_t group = 0;
  double x = 0;
  double y = 0;
  double width = 0;
};
std::vector<HelpPlace> PlaceHelp(const std::vector<HudKeyGroup>& groups, const FlatBox& inside);

/// The first row that is shown of a list that is longer than its room.
std::size_t FirstRow(std::size_t rows, std::size_t shown, std::size_t selected);

/// Boxes of a menu's rows that are shown, from `first`.
struct MenuRows {
  std::size_t first = 0;
  std::vector<FlatBox> rows;
};
MenuRows PlaceMenuRows(const HudMenu& menu, const FlatBox& modal);
/// Of the pieces' panel likewise.
MenuRows PlacePieceRows(const std::vector<HudPiece>& pieces, const HudLayout& layout);

}  // namespace kerf
