#include "app/window/bone_threshold.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

// Reasons of NotHu and UnclearUnit, for the translation.
[[maybe_unused]] constexpr std::array kQuestionReasons{
    Msg("this is a CT without its offset: air lies near 0 and soft tissue near {}, but in HU they lie at -1000 and 0 "
        "to "
        "80"),
    Msg("the largest side of the surface is {}, which may be a piece of {} mm or a {} of {} cm"),
    Msg("the largest side of the surface is {}, which is unlikely for a bone in mm"),
    Msg("skull"),
    Msg("long bone"),
    Msg("long thin bone")};

/// Returns the value below which a fraction of the voxels lies.
double CalcQuantile(std::vector<std::int16_t>& values, double fraction) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

BoneThreshold::BoneThreshold(std::shared_ptr<const Volume> ct, double proposed)
    : ct_(std::move(ct)), value_(proposed), darkest_(proposed - 1000), brightest_(proposed + 1000) {
  constexpr std::size_t kSamples = 1 << 20;
  std::vector<std::int16_t> values;
  const std::size_t step = ct_->hu.size() / kSamples + 1;
  for (std::size_t v = 0; v < ct_->hu.size(); v += step) values.push_back(ct_->hu[v]);
  if (values.empty()) return;
  darkest_ = std::min(CalcQuantile(values, 0.01), proposed - 1);
  brightest_ = std::max(CalcQuantile(values, 0.999), proposed + 1);
}

void BoneThreshold::Ask(const std::string& why) {
  asks_ = true;
  if (!why.empty()) why_ = why;
  if (!why_.empty()) why_[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(why_[0])));
}

CtGreys BoneThreshold::greys() const {
  return {0.5 * (darkest_ + brightest_), brightest_ - darkest_, value_};
}

BoneThreshold::Answer BoneThreshold::Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices) {
  slices.Draw(ui, column, ct_);
  if (!BeginPanel(ui, "threshold", scene, true)) return Answer::kNone;
  const float s = ui.scale();
  Answer answer = Answer::kNone;
  ImGui::BeginChild("threshold", {std::min(330 * s, 0.42F * ImGui::GetContentRegionAvail().x), 0});
  ImGui::PushFont(ui.bold());
  WrappedText(Tr("From which value on is it bone?"));
  ImGui::PopFont();
  WrappedText(
      Tr("What counts as bone is tinted in the slices. Move the threshold until all bone is tinted, and as little else "
         "as possible. Turn the wheel over a slice to scroll. Then press Import."));
  ImGui::Spacing();
  auto value = static_cast<float>(value_);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  if (ImGui::SliderFloat("##value", &value, static_cast<float>(darkest_), static_cast<float>(brightest_), "%.0f")) {
    value_ = std::round(static_cast<double>(value));
    slices.Tint(value_);
  }
  ui.Note("threshold.value");
  if (ImGui::Button(Tr("Import"))) answer = Answer::kImport;
  ui.Note("threshold.run");
  ImGui::SameLine();
  if (ImGui::Button(Tr("Cancel"))) answer = Answer::kCancel;
  ui.Note("threshold.cancel");
  ImGui::PushTextWrapPos(0);
  ImGui::TextDisabled("%s", Tr("Enter: import   Esc: cancel"));
  ImGui::Spacing();
  ImGui::TextDisabled("%s", why_.c_str());
  for (const std::string& warning : ct_->warnings) {
    LevelMark(ui, HudLevel::kWarn);
    ImGui::SameLine();
    ImGui::TextUnformatted(TrMade(warning).c_str());
  }
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
  ImGui::SameLine();
  ImGui::BeginGroup();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  slices.DrawLarge(ui, room.x, room.y, ct_, {});
  ImGui::EndGroup();
  EndPanel();
  return answer;
}

void BoneThreshold::Describe(nlohmann::json& state) const {
  state["threshold"] = {{"asks", asks_}, {"value", value_}};
}

}  // namespace kerf
