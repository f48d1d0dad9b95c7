#include "app/window/tour.h"

#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"

namespace kerf {

bool Tour::Take(const WindowEvent& event) {
  if (event.key != Key::kEscape) return false;
  step_ = steps_.size();
  return true;
}

namespace {

/// Returns the first corner of the scene, beginning at the upper right, in which the card covers no button and no card
/// of an exercise; the upper right if there is none.
UiBox FindPlace(const Ui& ui, const UiBox& scene, const ImVec2& size) {
  const double gap = 10 * ui.scale();
  const double right = scene.right() - static_cast<double>(size.x) - gap;
  const double bottom = scene.bottom() - static_cast<double>(size.y) - gap;
  const std::array<ImVec2, 4> corners{
      ImVec2(static_cast<float>(right), static_cast<float>(scene.top + gap)),
      ImVec2(static_cast<float>(right), static_cast<float>(bottom)),
      ImVec2(static_cast<float>(scene.left + gap), static_cast<float>(bottom)),
      ImVec2(static_cast<float>(scene.left + gap), static_cast<float>(scene.top + gap))};
  const auto place = [&](const ImVec2& at) { return UiBox{at.x, at.y, size.x, size.y}; };
  for (const ImVec2& corner : corners) {
    const UiBox box = place(corner);
    const bool covers = std::any_of(ui.noted().begin(), ui.noted().end(), [&](const auto& item) {
      const std::string& name = item.first;
      return (name.starts_with("practise.") || name == "banner") && Overlap(box, item.second);
    });
    if (!covers) return box;
  }
  return place(corners.front());
}

}  // namespace

void Tour::Draw(Ui& ui, const UiBox& scene, bool in_front) {
  const float s = ui.scale();
  const float width = std::min(380 * s, static_cast<float>(scene.width) - 20 * s);
  if (width < 150 * s) return;
  const TourStep& step = steps_[step_];
  // The buttons are at the same place in all steps, so that they can be clicked repeatedly.
  float text_height = 0;
  for (const TourStep& any : steps_) {
    text_height = std::max(text_height, ImGui::CalcTextSize(any.text.c_str(), nullptr, false, width - 28 * s).y);
  }
  const UiBox box = FindPlace(ui, scene, {width, text_height + 96 * s});
  ImGui::SetNextWindowPos({static_cast<float>(box.left), static_cast<float>(box.top)});
  ImGui::SetNextWindowSize({width, text_height + 96 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {14 * s, 12 * s});
  ImGui::PushStyleColor(ImGuiCol_Border, ToImVec4(ui.colours().accent));
  ImGui::Begin("tour", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoNav |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  if (in_front) ImGui::BringWindowToDisplayFront(ImGui::GetCurrentWindow());
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  ImGui::PushFont(ui.bold());
  ImGui::TextUnformatted(fmt::format("{} / {}   {}", step_ + 1, steps_.size(), step.title).c_str());
  ImGui::PopFont();
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(step.text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::SetCursorPosY(ImGui::GetWindowHeight() - ImGui::GetFrameHeight() - 12 * s);
  const bool last = step_ + 1 == steps_.size();
  if (ImGui::Button(last ? Tr("Done") : Tr("Next"))) {
    ++step_;
  }
  ui.Note("tour.next");
  if (!last && is_open()) {
    ImGui::SameLine();
    if (ImGui::Button(Tr("Skip the tour"))) step_ = steps_.size();
    ui.Note("tour.skip");
  }
  ImGui::End();
}

}  // namespace kerf
