#include "app/window/jaw_separation.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <optional>

#include "bone/import/isolate.h"
#include "session/marks/structures.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

// Distinguishable with any colour vision, and by shape.
constexpr Rgb8 kKeepColour{90, 200, 255};
constexpr Rgb8 kDropColour{255, 170, 40};

// Reasons of NotIsolated, for the translation.
[[maybe_unused]] constexpr std::array kWhys{
    Msg("the mandible can't be distinguished from the other bone: no piece between {} and {} HU has the size and shape "
        "of one; it is joined to something else, incomplete, or not in the scan"),
    Msg("the isolated bone ({}) does not look like a mandible: {}"),
    Msg("the bone goes on for more than {} mm beside the part that was recognised"),
    Msg("the keep points lie in separate pieces of bone: {} is not joined to the others")};

/// Draws the symbol of a kind of points in a line of this height, and stays in the line.
void DrawSymbol(const Ui& ui, bool keep, float height) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 middle{at.x + 0.5F * height, at.y + 0.5F * height};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float r = 5 * ui.scale();
  if (keep) {
    list.AddCircleFilled(middle, r, ToImU32(kKeepColour));
  } else {
    list.AddRectFilled({middle.x - r, middle.y - r}, {middle.x + r, middle.y + r}, ToImU32(kDropColour));
  }
  ImGui::Dummy({height, height});
  ImGui::SameLine();
}

}  // namespace

void JawSeparation::Ask(const std::string& why) {
  asks_ = true;
  refusal_.clear();
  why_ = why;
}

bool JawSeparation::Separate() {
  if (!can_separate()) return false;
  asks_ = false;
  return true;
}

void JawSeparation::Take(const Vec3& p_W) {
  if (!IsNearBone(*ct_, iso_hu_, p_W)) {
    refusal_ = Tr("There is no bone at this point: click on something bright.");
    return;
  }
  refusal_.clear();
  (keeps_ ? keep_W_ : drop_W_).push_back(p_W);
  order_.push_back(keeps_);
}

void JawSeparation::TakeBack() {
  if (order_.empty()) return;
  (order_.back() ? keep_W_ : drop_W_).pop_back();
  order_.pop_back();
}

void JawSeparation::Remove(bool keep, std::size_t i) {
  std::vector<Vec3>& points = keep ? keep_W_ : drop_W_;
  points.erase(points.begin() + static_cast<std::ptrdiff_t>(i));
  std::size_t n = 0;
  const auto at = std::find_if(order_.begin(), order_.end(), [&](bool kept) { return kept == keep && n++ == i; });
  order_.erase(at);
}

std::vector<CtMark> JawSeparation::ListMarks() const {
  std::vector<CtMark> marks;
  for (const bool keep : {true, false}) {
    const std::vector<Vec3>& points = keep ? keep_W_ : drop_W_;
    for (std::size_t i = 0; i < points.size(); ++i) {
      marks.push_back({points[i], keep ? kKeepColour : kDropColour, !keep, fmt::format("{}", i + 1)});
    }
  }
  return marks;
}

void JawSeparation::DrawChoice(Ui& ui, bool keep) {
  ImGui::PushID(keep ? "keep" : "drop");
  DrawSymbol(ui, keep, ImGui::GetFrameHeight());
  if (ImGui::RadioButton(keep ? Tr("in the mandible") : Tr("in the upper jaw or skull"), keeps_ == keep)) keeps_ = keep;
  ui.Note(keep ? "separate.keep" : "separate.drop");
  ImGui::PopID();
}

void JawSeparation::DrawList(Ui& ui, bool keep, CtPreview& slices) {
  ImGui::PushID(keep ? "keep points" : "drop points");
  const std::vector<Vec3>& points = keep ? keep_W_ : drop_W_;
  std::optional<std::size_t> removed;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::SmallButton(Tr("Remove"))) removed = i;
    ui.Note(fmt::format("separate.remove {} {}", keep ? "keep" : "drop", i + 1));
    ImGui::SameLine();
    const Vec3& p = points[i];
    const std::string place = Translate(DescribePlace(p));
    // The points of the two lists differ in colour and shape, as in the slices.
    DrawSymbol(ui, keep, ImGui::GetTextLineHeight());
    const float width = ImGui::GetContentRegionAvail().x;
    const std::string text = BreakLines(fmt::format("{}: {}", i + 1, place), width);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    if (ImGui::Selectable("##point", false, 0, {width, ImGui::CalcTextSize(text.c_str()).y})) slices.Show(p);
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
    Tooltip(ui, fmt::format("{}\n{}. {}", Tr("Click to show this point in the slices."), place, Tr(ExplainPlaces())));
    ImGui::PopID();
  }
  if (removed) Remove(keep, *removed);
  ImGui::PopID();
}

JawSeparation::Answer JawSeparation::Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices) {
  const std::vector<CtMark> marks = ListMarks();
  slices.Draw(ui, column, ct_, marks);
  if (!BeginPanel(ui, "separation", scene, true)) return Answer::kNone;
  const float s = ui.scale();
  Answer answer = Answer::kNone;
  const float width = std::min(330 * s, 0.42F * ImGui::GetContentRegionAvail().x);
  ImGui::BeginChild("points", {width, 0});
  ImGui::PushFont(ui.bold());
  WrappedText(Tr("The mandible could not be separated from other bone"));
  ImGui::PopFont();
  WrappedText(Tr(
      "Click a few points in the mandible, also in its teeth, and a few in the bone that touches it, such as the "
      "upper teeth. Turn the wheel over a slice to scroll; drag with the right button to change its grey levels. Then "
      "press Separate."));
  ImGui::Spacing();
  DrawChoice(ui, true);
  DrawChoice(ui, false);
  ImGui::Spacing();
  ImGui::BeginDisabled(!can_separate());
  if (ImGui::Button(Tr("Separate"))) answer = Answer::kSeparate;
  ui.Note("separate.run");
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button(Tr("Cancel"))) answer = Answer::kCancel;
  ui.Note("separate.cancel");
  ImGui::PushTextWrapPos(0);
  if (!refusal_.empty()) {
    LevelMark(ui, HudLevel::kWarn);
    ImGui::SameLine();
    ImGui::TextUnformatted(refusal_.c_str());
  } else if (!can_separate()) {
    ImGui::TextUnformatted(Tr("Each list needs at least one point."));
  }
  ImGui::TextDisabled("%s", Tr("Enter: separate   Backspace: remove the last point   Esc: cancel"));
  ImGui::Spacing();
  ImGui::TextDisabled("%s", why_.c_str());
  ImGui::PopTextWrapPos();
  // Below everything that is clicked meanwhile, because they grow.
  ImGui::Spacing();
  DrawList(ui, true, slices);
  DrawList(ui, false, slices);
  ImGui::EndChild();
  ImGui::SameLine();
  ImGui::BeginGroup();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (const std::optional<Vec3> p_W = slices.DrawLarge(ui, room.x, room.y, ct_, marks)) Take(*p_W);
  ImGui::EndGroup();
  EndPanel();
  return answer;
}

void JawSeparation::Describe(nlohmann::json& state) const {
  state["separation"] = {{"asks", asks_}, {"keep", keep_W_.size()}, {"drop", drop_W_.size()}, {"refusal", refusal_}};
}

}  // namespace kerf
