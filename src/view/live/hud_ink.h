// Colours and marks that all panels share.
#pragma once

#include "view/live/draw_list.h"
#include "view/live/hud.h"

namespace kerf {

/// Help, menu, result or progress, whichever the state has.
void DrawModal(const HudState& state, const FlatBox& box, DrawList& list);

namespace ink {

inline constexpr FlatColour kText{{26, 29, 36}, 1};
inline constexpr FlatColour kFaint{{88, 96, 108}, 1};
inline constexpr FlatColour kGround{{250, 251, 252}, 0.97};
inline constexpr FlatColour kEdge{{176, 183, 192}, 1};

/// A shape for each level, so that no colour is needed: disc, triangle, square with a cross. (x, y): its middle.
void Mark(HudLevel level, double x, double y, double size, DrawList& list);
/// The ground of a row that is chosen.
void Selected(const FlatBox& row, DrawList& list);

}  // namespace ink
}  // namespace kerf
