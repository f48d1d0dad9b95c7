#include "app/window/settings_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

namespace kerf {

bool DrawSettings(Ui& ui, const UiBox& scene, const std::vector<Language>& languages, WindowSettings& settings,
                  bool& shown) {
  const float s = ui.scale();
  ImGui::SetNextWindowPos({static_cast<float>(scene.left) + 30 * s, static_cast<float>(scene.top) + 30 * s});
  ImGui::SetNextWindowSize({360 * s, 262 * s});
  ImGui::Begin(
      fmt::format("{}###settings", Tr("Settings")).c_str(), &shown,
      ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
  bool changed = false;
  ImGui::TextUnformatted(Tr("Colours of the window"));
  for (const auto& [theme, name] : {std::pair{Theme::kLight, Tr("light")}, std::pair{Theme::kDark, Tr("dark")}}) {
    if (ImGui::RadioButton(name, settings.theme == theme)) {
      settings.theme = theme;
      changed = true;
    }
    ui.Note(theme == Theme::kLight ? "setting light" : "setting dark");
    if (theme == Theme::kLight) ImGui::SameLine();
  }
  ImGui::TextUnformatted(Tr("Size of text"));
  for (const double size : {0.85, 1.0, 1.2, 1.5}) {
    if (ImGui::RadioButton(fmt::format("{:.0f} %", 100 * size).c_str(), settings.text_size == size)) {
      settings.text_size = size;
      changed = true;
    }
    ui.Note(fmt::format("setting text {:.0f}", 100 * size));
    if (size < 1.5) ImGui::SameLine();
  }
  ImGui::TextUnformatted(Tr("Language"));
  for (const Language& language : languages) {
    if (ImGui::RadioButton(language.name.c_str(), CurrentLanguage() == language.code)) {
      settings.language = language.code;
      changed = true;
    }
    ui.Note(fmt::format("setting language {}", language.code));
    ImGui::SameLine();
  }
  ImGui::NewLine();
  ImGui::TextUnformatted(Tr("Sound"));
  auto volume = static_cast<float>(100 * settings.volume);
  ImGui::SetNextItemWidth(180 * s);
  if (ImGui::SliderFloat("##volume", &volume, 0, 100, "")) {
    settings.volume = std::clamp(0.01 * static_cast<double>(volume), 0.0, 1.0);
    changed = true;
  }
  ui.Note("setting volume");
  ImGui::SameLine();
  ImGui::TextUnformatted(fmt::format("{:.0f} %", 100 * settings.volume).c_str());
  ImGui::SameLine();
  changed = ImGui::Checkbox(Tr("mute"), &settings.mute) || changed;
  ui.Note("setting mute");
  ImGui::End();
  return changed;
}

}  // namespace kerf
