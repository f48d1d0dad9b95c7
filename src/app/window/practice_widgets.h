// Parts of the dialogs of `kerf practise`.
#pragma once

#include <imgui.h>

#include <initializer_list>
#include <string>

#include "session/score/review.h"
#include "view/ui/hud.h"
#include "view/ui/ui.h"
#include "view/ui/widgets.h"

namespace kerf {

inline constexpr ImGuiWindowFlags kPracticeDialog = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                                    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar |
                                                    ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoNav;

HudLevel HudLevelOf(ReviewLevel level);

/// Begins a dialog in the middle of the window, at most as large as the space between the bars. The size is in points.
void BeginLargeDialog(Ui& ui, const char* name, float width, float height);
void SmallText(Ui& ui, const std::string& text);
void MarkedText(Ui& ui, HudLevel level, const std::string& text);
/// Returns the width of a column of a table in which all texts fit, at least `least` pixels.
float WidthFor(std::initializer_list<std::string> texts, float least);

/// Adds buttons from left to right, in as many lines as they need. The first one is the default.
class ButtonRow {
 public:
  explicit ButtonRow(Ui& ui) : ui_(ui), right_(ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x) {}

  /// `note`: name for Ui::Note(); `keys`: shown behind the text. Returns true if it was clicked.
  bool Add(const char* note, const std::string& text, const std::string& keys);

 private:
  Ui& ui_;
  float right_;
  bool first_ = true;
};

}  // namespace kerf
