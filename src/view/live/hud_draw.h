// Draws each panel. Pure: turns state and layout into flat primitives.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "view/live/ct_slices.h"
#include "view/live/draw_list.h"
#include "view/live/hud_layout.h"

namespace kerf {

/// Text label in the scene; not drawn where a panel is.
struct SceneLabel {
  std::string text;
  double x = 0;  // position of the labelled spot, points
  double y = 0;
  Rgb8 colour{40, 44, 52};
};

/// Scale bar: `points` on the screen correspond to `mm` at the depth of the camera's target.
struct ScaleBar {
  double mm = 10;
  double points = 100;
};
/// Returns the longest bar that is at most `max_points` long and represents 1, 2 or 5 times a power of ten mm.
ScaleBar CalcScaleBar(double mm_per_point, double max_points);

struct HudPictures {
  const CtSlices* slices = nullptr;  // optional
  std::uint64_t version = 0;         // of the slices; changes when they do
};

void DrawHud(const HudState& state, const HudLayout& layout, const HudPictures& pictures,
             const std::vector<SceneLabel>& labels, const std::optional<ScaleBar>& scale, DrawList& list);

Rgb8 LevelColour(HudLevel level);
/// Formats a number: "1.23", "45.6", "789", "-" if unset; never "-0.00".
std::string FormatHudNumber(const std::optional<double>& value, int decimals);

}  // namespace kerf
