// What each panel looks like. Pure: state and places in, flat things out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "view/live/ct_slices.h"
#include "view/live/draw_list.h"
#include "view/live/hud_layout.h"

namespace kerf {

/// Words beside something in the scene; not drawn where a panel is.
struct SceneLabel {
  std::string text;
  double x = 0;  // points, of the spot that it names
  double y = 0;
  Rgb8 colour{40, 44, 52};
};

/// The scale bar: so many points are so many mm at the depth of the camera's target.
struct ScaleBar {
  double mm = 10;
  double points = 100;
};
/// The largest 1, 2 or 5 times a power of ten that is at most `most_points` long.
ScaleBar CalcScaleBar(double mm_per_point, double most_points);

struct HudPictures {
  const CtSlices* slices = nullptr;  // may be null
  std::uint64_t version = 0;         // of them
};

void DrawHud(const HudState& state, const HudLayout& layout, const HudPictures& pictures,
             const std::vector<SceneLabel>& labels, const std::optional<ScaleBar>& scale, DrawList& list);

Rgb8 LevelColour(HudLevel level);
/// "1.23", "45.6", "789", "-" for none; never "-0.00".
std::string FormatHudNumber(const std::optional<double>& value, int decimals);

}  // namespace kerf
