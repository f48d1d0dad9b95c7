// Panels that show the state of the saw and of the picture. Contents in, drawing out.
#pragma once

#include <optional>

#include "view/ui/hud.h"
#include "view/ui/ui.h"
#include "view/ui/widgets.h"

namespace kerf {

/// Areas of the window, pixels. In a small window the side columns are left out.
struct UiAreas {
  UiBox menu, toolbar, left, right, status;
  UiBox scene;  // free area for the bone
  UiBox cube;   // orientation cube, within the scene's lower right corner
};
/// `left`, `right`: whether the columns are wanted.
UiAreas CalcUiAreas(const Ui& ui, bool left, bool right);

/// Begins a panel that fills an area. Returns false if the area is empty; otherwise EndPanel() must follow.
/// `by_wheel`: false if the caller itself scrolls a panel that scrolls when the wheel is turned.
bool BeginPanel(Ui& ui, const char* name, const UiBox& area, bool scrolls, bool by_wheel = true);
void EndPanel();
/// Adds the heading of a section that can be folded. Returns true if it is open.
bool BeginSection(Ui& ui, const char* title, bool open = true);

/// Sections of the left column.
void ValuesSection(Ui& ui, const HudState& state);
void GaugeSection(Ui& ui, const HudState& state);
void ForceSection(Ui& ui, const HudState& state);
void LegendSection(Ui& ui, const HudState& state);
/// Returns the row that was clicked.
std::optional<int> PiecesSection(Ui& ui, const HudState& state);

/// Returns the place of DrawProgressBox(); empty: the scene is too small for it.
UiBox CalcProgressBox(const Ui& ui, const UiBox& scene);
/// Small box in the scene's lower left corner: what is in progress, how far, and the time left. Returns true if Cancel
/// was clicked.
bool DrawProgressBox(Ui& ui, const HudProgress& progress, const UiBox& scene);
/// List to choose from, as a dialog. Returns the row that was clicked.
std::optional<int> DrawMenuDialog(Ui& ui, const HudMenu& menu);
/// Dialog with groups of keys.
void DrawHelpDialog(Ui& ui, const std::vector<HudKeyGroup>& groups);

}  // namespace kerf
