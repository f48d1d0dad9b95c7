#include "app/window/tour.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"

namespace kerf {

bool Tour::Take(const WindowEvent& event) {
  if (event.key != Key::kEscape) return false;
  step_ = steps_.size();
  return true;
}

void Tour::Draw(Ui& ui, const UiBox& scene) {
  const float s = ui.scale();
  const float width = std::min(380 * s, static_cast<float>(scene.width) - 20 * s);
  if (width < 150 * s) return;
  const TourStep& step = steps_[step_];
  // The buttons are at the same place in all steps, so that they can be clicked repeatedly.
  float text_height = 0;
  for (const TourStep& any : steps_) {
    text_height = std::max(text_height, ImGui::CalcTextSize(any.text.c_str(), nullptr, false, width - 28 * s).y);
  }
  ImGui::SetNextWindowPos({static_cast<float>(scene.right()) - width - 10 * s, static_cast<float>(scene.top) + 10 * s});
  ImGui::SetNextWindowSize({width, text_height + 96 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {14 * s, 12 * s});
  ImGui::PushStyleColor(ImGuiCol_Border, ToImVec4(ui.colours().accent));
  if (std::exchange(fresh_, false)) ImGui::SetNextWindowFocus();  // in front of a dialog
  ImGui::Begin("tour", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoNav |
                   ImGuiWindowFlags_NoFocusOnAppearing);
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
