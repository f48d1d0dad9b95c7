// The picture of a wanted and a made cut, and the lines and legends that other plots use too.
#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "session/score/cut_picture.h"
#include "view/picture/colours.h"
#include "view/ui/ui.h"

namespace kerf {

/// Colours of the attempt, and of the wanted cut and the expert; distinguishable with any colour vision.
inline constexpr Rgb8 kMadeColour{213, 94, 0};
inline constexpr Rgb8 kWantedColour{0, 114, 178};
// Pictures are drawn on white in both themes, because their colours are made for it.
inline constexpr Rgb8 kPaper{255, 255, 255};
inline constexpr Rgb8 kInk{26, 29, 36};
inline constexpr Rgb8 kBoneLine{140, 140, 140};

enum class Stroke { kSolid, kDashed };
void AddStroke(ImDrawList& list, const std::vector<ImVec2>& points, Stroke stroke, const Rgb8& colour, float width);
/// Adds the entry of a legend: a piece of the line, and its name.
void LegendEntryItem(Ui& ui, Stroke stroke, const Rgb8& colour, float width, const std::string& name);

/// Draws both views of the cut beside each other, with a scale bar and a legend.
void DrawCutPicture(Ui& ui, const CutPicture& picture);

}  // namespace kerf
