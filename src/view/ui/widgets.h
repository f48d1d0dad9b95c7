// Elements of panels that Dear ImGui lacks: marks of a level, fields, a gauge, a force plot, indicators, labels in the
// picture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "view/ui/hud.h"
#include "view/ui/ui.h"

struct ImDrawList;
struct ImVec2;

namespace kerf {

/// Colour of a level; distinguishable with any colour vision, together with the mark.
Rgb8 LevelColour(HudLevel level);
/// Draws a distinct shape for each level, readable without colour: disc, tick, triangle, square with a cross.
void DrawLevelMark(ImDrawList& list, HudLevel level, const ImVec2& centre, float size);
/// Adds a level's mark as an item of the height of a line.
void LevelMark(Ui& ui, HudLevel level);

/// Draws text with a dark outline, which is legible on any ground. `left`: the middle of its left edge.
void AddCasedText(ImDrawList& list, const ImVec2& left, unsigned int colour, const std::string& text);
/// Adds text that ends with an ellipsis if it does not fit into `width` pixels; the full text is its tooltip.
void FittedText(Ui& ui, const std::string& text, float width);
/// Returns the text's beginning that fits into `width` pixels of the current font, with an ellipsis if it is cut.
std::string FitText(const std::string& text, float width);
/// Returns the text with line breaks, so that it is at most `width` pixels wide in the current font. A line ends at a
/// space, but never between a number and its unit; a longer word stays as it is.
std::string BreakLines(const std::string& text, float width);
/// Adds a text in as many lines as it needs. `width`: pixels; 0: up to the right edge.
void WrappedText(const std::string& text, float width = 0);
/// Returns the height of the text in the current font with that width.
float CalcWrappedHeight(const std::string& text, float width);
/// Shows a tooltip, wrapped, if the last item is hovered; nothing for an empty text.
void Tooltip(Ui& ui, const std::string& text);
/// The same, beside the last item, to its left, so that it does not hide what it explains.
void TooltipBeside(Ui& ui, const std::string& text);

/// Field for a text, as wide as the next item. Returns true, with the new `value`, if the user has changed it and has
/// left the field: with Enter or Tab, or by a click elsewhere. Escape discards what was typed.
bool TextField(Ui& ui, const char* id, std::string& value);
/// The same for a number, with the decimal separator of the language; a point is understood too.
bool NumberField(Ui& ui, const char* id, double& value, int decimals);

void Gauge(Ui& ui, const HudGauge& gauge);
/// Draws the last 10 s of the force.
void ForcePlot(Ui& ui, const std::vector<PlotPoint>& force, double now_s);
/// Returns the top of the plot's axis: 1, 2 or 5 times a power of ten, at least 1 N and not less than `max`.
double CalcAxisTop(double max);

/// Indicator of a mode that stays visible: its name, whether it is on (a filled lamp), and its key. Returns true if it
/// was clicked.
bool Indicator(Ui& ui, const char* id, const std::string& name, bool on, const std::string& key,
               const std::string& tip);
/// Returns its width, pixels.
float CalcIndicatorWidth(const Ui& ui, const std::string& name, const std::string& key);

/// Begins a dialog above the middle of the window, in pixels, at most as large as the window. ImGui::End() must follow.
void BeginDialog(Ui& ui, const char* name, float width, float height);

/// Swatch of a colour with a text.
void Swatch(Ui& ui, const Rgb8& colour, bool filled = true);

}  // namespace kerf
