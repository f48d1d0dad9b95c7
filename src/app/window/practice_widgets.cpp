#include "app/window/practice_widgets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/ui/imgui_colours.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {

HudLevel HudLevelOf(ReviewLevel level) {
  return level == ReviewLevel::kGood   ? HudLevel::kGood
         : level == ReviewLevel::kWarn ? HudLevel::kWarn
         : level == ReviewLevel::kBad  ? HudLevel::kBad
                                       : HudLevel::kPlain;
}

void BeginLargeDialog(Ui& ui, const char* name, float width, float height) {
  const float s = ui.scale();
  const UiBox scene = CalcUiAreas(ui, false, false).scene;
  const ImVec2 size{std::min(width * s, static_cast<float>(scene.width) - 12 * s),
                    std::min(height * s, static_cast<float>(scene.height) - 8 * s)};
  ImGui::SetNextWindowPos(
      {std::floor(static_cast<float>(scene.left) + 0.5F * (static_cast<float>(scene.width) - size.x)),
       std::floor(static_cast<float>(scene.top) + 0.5F * (static_cast<float>(scene.height) - size.y))});
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {18 * s, 12 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 4 * s);
  ImGui::Begin(name, nullptr, kPracticeDialog);
  ImGui::PopStyleVar(2);
}

void SmallText(Ui& ui, const std::string& text) {
  ImGui::PushFont(ui.small());
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().faint));
  WrappedText(text);
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

void MarkedText(Ui& ui, HudLevel level, const std::string& text) {
  LevelMark(ui, level);
  ImGui::SameLine();
  WrappedText(text);
}

float WidthFor(std::initializer_list<std::string> texts, float least) {
  for (const std::string& text : texts) least = std::max(least, ImGui::CalcTextSize(text.c_str()).x + 1);
  return least;
}

bool ButtonRow::Add(const char* note, const std::string& text, const std::string& keys) {
  const std::string label = keys.empty() ? text : fmt::format("{} ({})", text, keys);
  const bool first = std::exchange(first_, false);
  const float width = ImGui::CalcTextSize(label.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
  if (!first && ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + width <= right_) ImGui::SameLine();
  if (first) {
    ImGui::PushStyleColor(ImGuiCol_Button, ToImVec4(ui_.colours().accent));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ToImVec4(ui_.colours().accent, 0.85));
    ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui_.colours().panel));
  }
  const bool clicked = ImGui::Button(fmt::format("{}##{}", label, note).c_str());
  if (first) ImGui::PopStyleColor(3);
  ui_.Note(note);
  return clicked;
}

}  // namespace kerf
