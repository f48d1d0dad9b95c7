#include "app/window/tour.h"

#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {

bool Tour::Take(const WindowEvent& event) {
  if (event.key != Key::kEscape) return false;
  step_ = steps_.size();
  return true;
}

UiBox PlaceTour(const UiSize& size, const UiBox& scene, const UiBox& cube, const std::vector<UiBox>& buttons,
                const std::vector<UiBox>& others, double scale) {
  constexpr double kCardRoom = 130;  // points; the card of an exercise and a message are at the top
  const double gap = 10 * scale;
  const double left = scene.left + gap;
  const double right = scene.right() - size.width - gap;
  const double top = scene.top + gap;
  const double bottom = scene.bottom() - size.height - gap;
  const double below_card = scene.top + kCardRoom * scale;
  const double beside_cube = cube.empty() ? right : cube.left - size.width - gap;
  std::optional<UiBox> best;
  double least = 0;
  for (const UiSpot& corner : {UiSpot{right, top},
                               {right, bottom},
                               {beside_cube, bottom},
                               {left, bottom},
                               {left, top},
                               {right, below_card},
                               {left, below_card}}) {
    const UiBox box{corner.x, corner.y, size.width, size.height};
    if (best && (box.left < scene.left || box.bottom() > scene.bottom())) continue;
    double covered = 0;
    const auto add = [&](const UiBox& other, double weight) {
      covered += weight * std::max(0.0, std::min(box.right(), other.right()) - std::max(box.left, other.left)) *
                 std::max(0.0, std::min(box.bottom(), other.bottom()) - std::max(box.top, other.top));
    };
    for (const UiBox& button : buttons) add(button, 1e3);
    for (const UiBox& other : others) add(other, 1);
    if (best && covered >= least) continue;
    best = box;
    least = covered;
  }
  return *best;
}

void Tour::Draw(Ui& ui, const UiBox& scene, const UiBox& cube, std::vector<UiBox> others, bool in_front) {
  const float s = ui.scale();
  const float width = std::min(380 * s, static_cast<float>(scene.width) - 20 * s);
  if (width < 150 * s) return;
  const TourStep& step = steps_[step_];
  // The buttons are at the same place in all steps, so that they can be clicked repeatedly.
  float text_height = 0;
  for (const TourStep& any : steps_) {
    text_height = std::max(text_height, CalcWrappedHeight(any.text, width - 28 * s));
  }
  others.push_back(cube);
  std::vector<UiBox> buttons;
  for (const auto& [name, place] : ui.noted()) {
    if (name.starts_with("practise.") || name == "banner") buttons.push_back(place);
    if (name.starts_with("exercise ")) others.push_back(place);
  }
  const UiBox box = PlaceTour({width, text_height + 96 * s}, scene, cube, buttons, others, s);
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
  WrappedText(step.text);
  ImGui::SetCursorPosY(ImGui::GetWindowHeight() - ImGui::GetFrameHeight() - 12 * s);
  const bool last = step_ + 1 == steps_.size();
  if (step.has_button) {
    if (ImGui::Button(last ? Tr("Done") : Tr("Next"))) ++step_;
    ui.Note("tour.next");
    ImGui::SameLine();
  }
  if (!last && is_open()) {
    if (ImGui::Button(Tr("Skip the tour"))) step_ = steps_.size();
    ui.Note("tour.skip");
  }
  ImGui::End();
}

}  // namespace kerf
