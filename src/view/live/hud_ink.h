// Colours and marks shared by all panels.
#pragma once

#include "view/live/draw_list.h"
#include "view/live/hud.h"

namespace kerf {

/// Draws help, menu, result or progress, whichever the state contains.
void DrawModal(const HudState& state, const FlatBox& box, DrawList& list);

namespace ink {

inline constexpr FlatColour kText{{26, 29, 36}, 1};
inline constexpr FlatColour kFaint{{88, 96, 108}, 1};
inline constexpr FlatColour kGround{{250, 251, 252}, 0.97};
inline constexpr FlatColour kEdge{{176, 183, 192}, 1};

/// Draws a distinct shape for each level, readable without colour: disc, triangle, square with a cross. (x, y): its
/// centre.
void Mark(HudLevel level, double x, double y, double size, DrawList& list);
/// Draws the background of a selected row.
void Selected(const FlatBox& row, DrawList& list);

}  // namespace ink
}  // namespace kerf
