// Flat marks over the picture of the scene: labels, rings and the border of an alarm, the scale bar. Pure.
#pragma once

#include <string>
#include <vector>

#include "view/live/draw_list.h"
#include "view/live/hud_draw.h"
#include "view/live/overlays.h"

namespace kerf {

/// Colours of the scene that depend on the theme.
struct SceneColours {
  Rgb8 top;     // background, at the top of the window
  Rgb8 bottom;  // at its bottom
  Rgb8 text;    // of labels and the scale bar
  Rgb8 ground;  // behind this text
};
SceneColours ColoursOf(Theme theme);

/// Label of a spot in the scene; positions are in points from the top left of the window.
struct FlatLabel {
  std::string text;
  double x = 0;
  double y = 0;
  Rgb8 colour{40, 44, 52};  // of the bar at its left edge and the line to its spot
};

/// Place of a label.
struct PlacedLabel {
  std::size_t label = 0;  // index
  FlatBox box;
};

/// Finds a place near its spot for each label, in order, so that labels overlap neither each other nor `panels` and lie
/// within the window (`width` x `height` points). If possible, they also avoid `soft`, such as the saw. A label without
/// a place is omitted.
std::vector<PlacedLabel> PlaceLabels(const std::vector<FlatLabel>& labels, const std::vector<FlatBox>& panels,
                                     const std::vector<FlatBox>& soft, double width, double height);
/// Draws placed labels, with a line to the spots of those that lie apart from them.
void AddLabels(const std::vector<FlatLabel>& labels, const std::vector<PlacedLabel>& places, Theme theme,
               DrawList& list);

/// Colour of a level; distinguishable with any colour vision.
Rgb8 AlarmColour(AlarmLevel level);
/// Radius of a ring, points; grows with the level. 0: no ring.
double AlarmRadius(AlarmLevel level);
/// Draws a ring around a spot: thin and dashed, thicker with longer dashes, or thick and closed with four ticks.
void AddAlarmRing(double x, double y, AlarmLevel level, DrawList& list);
/// Thickness of the border around the picture, points; grows with the level. 0: no border.
double AlarmThickness(AlarmLevel level);
/// Draws the border within `area`: dashed for a warning, closed with hatching for danger; nothing below a warning.
void AddAlarmBorder(const FlatBox& area, AlarmLevel level, DrawList& list);

/// Draws a scale bar whose box has its lower left corner at (x, bottom).
void AddScaleBar(const ScaleBar& scale, double x, double bottom, Theme theme, DrawList& list);

/// Returns the largest rectangle in the window that overlaps none of the boxes. Its sides lie on sides of boxes or of
/// the window. Empty if there is none.
FlatBox FindFreeArea(const std::vector<FlatBox>& boxes, double width, double height);

}  // namespace kerf
