#include "app/window/ct_preview.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "app/window/slices_panel.h"
#include "session/marks/structures.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr std::array kCtAxes{CtAxis::kZ, CtAxis::kY, CtAxis::kX};
constexpr std::array kCtKinds{SliceKind::kAxial, SliceKind::kCoronal, SliceKind::kSagittal};
constexpr double kCtWheel_mm = 1;
constexpr double kCtNear_mm = 3;  // points that are farther from the slice are drawn as outlines

int CtAxisOf(std::size_t i) {
  return static_cast<int>(2 - i);
}

void DrawCtMark(ImDrawList& list, const CtMark& mark, const ImVec2& at, bool near, float s) {
  const float r = 4.5F * s;
  const ImU32 colour = ToImU32(mark.colour, near ? 1 : 0.55);
  const ImU32 casing = IM_COL32(0, 0, 0, 200);
  const ImVec2 low{at.x - r, at.y - r}, high{at.x + r, at.y + r};
  if (mark.square) {
    list.AddRect({low.x - s, low.y - s}, {high.x + s, high.y + s}, casing, 0, 0, 3 * s);
    near ? list.AddRectFilled(low, high, colour) : list.AddRect(low, high, colour, 0, 0, 1.5F * s);
  } else {
    list.AddCircle(at, r + s, casing, 0, 3 * s);
    near ? list.AddCircleFilled(at, r, colour) : list.AddCircle(at, r, colour, 0, 1.5F * s);
  }
  if (near) AddCasedText(list, {at.x + r + 3 * s, at.y}, colour, mark.label);
}

}  // namespace

void CtPreview::Follow(const std::shared_ptr<const Volume>& volume) {
  if (volume == volume_) return;
  volume_ = volume;
  const Box3 scan_W = CalcScanBox(*volume);
  // A scan that is read again stays as it was.
  const bool same = scan_W.lower == scan_W_.lower && scan_W.upper == scan_W_.upper;
  scan_W_ = scan_W;
  if (!same) box_W_ = scan_W;
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    if (!same) slices_[i].at_mm = scan_W.centre()[CtAxisOf(i)];
    Update(i);
  }
}

void CtPreview::set_box(const Box3& box_W) {
  box_W_.lower = glm::max(box_W.lower, scan_W_.lower);
  box_W_.upper = glm::min(box_W.upper, scan_W_.upper);
}

void CtPreview::Update(std::size_t i) {
  Slice& slice = slices_[i];
  slice.view = SliceVolume(*volume_, kCtAxes[i], slice.at_mm, greys_);
  slice.image = Image{slice.view.columns, slice.view.rows, slice.view.pixels};
  ++slice.version;
}

CtPreview::Edges CtPreview::CalcEdges(std::size_t i) const {
  const int axis = CtAxisOf(i), across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
  // In an axial slice the front is up, in the others the head.
  const double lower_mm = box_W_.lower[down], upper_mm = box_W_.upper[down];
  return {box_W_.lower[across], box_W_.upper[across], down == 1 ? lower_mm : upper_mm, down == 1 ? upper_mm : lower_mm};
}

/// Returns the height of what is shown of a slice, in units of its width.
float CtPreview::CalcShape(std::size_t i) const {
  const Edges part = CalcEdges(i);
  return static_cast<float>(std::abs(part.bottom_mm - part.top_mm) / (part.right_mm - part.left_mm));
}

void CtPreview::Show(const Vec3& p_W) {
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    slices_[i].at_mm = p_W[CtAxisOf(i)];
    if (volume_) Update(i);
  }
}

void CtPreview::Tint(double from) {
  greys_.tinted_from = from;
  for (std::size_t i = 0; i < slices_.size(); ++i) Update(i);
}

std::optional<Vec3> CtPreview::DrawSlice(Ui& ui, std::size_t i, float width, float height,
                                         const std::vector<CtMark>& marks) {
  Slice& slice = slices_[i];
  const CtView& view = slice.view;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const int axis = CtAxisOf(i), across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
  const Edges part = CalcEdges(i);
  const auto u = [&](double mm) { return static_cast<float>((mm - view.left_mm) / (view.right_mm - view.left_mm)); };
  const auto v = [&](double mm) { return static_cast<float>((mm - view.top_mm) / (view.bottom_mm - view.top_mm)); };
  ImGui::Image(ui.Texture(fmt::format("ct {}", i), slice.image, slice.version), {width, height},
               {u(part.left_mm), v(part.top_mm)}, {u(part.right_mm), v(part.bottom_mm)});
  const bool hovered = ImGui::IsItemHovered();
  const double wide_mm = part.right_mm - part.left_mm, high_mm = part.bottom_mm - part.top_mm;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRect(at, {at.x + width, at.y + height}, true);
  for (const CtMark& mark : marks) {
    DrawCtMark(list, mark,
               {at.x + static_cast<float>((mark.p_W[across] - part.left_mm) / wide_mm) * width,
                at.y + static_cast<float>((mark.p_W[down] - part.top_mm) / high_mm) * height},
               std::abs(mark.p_W[axis] - slice.at_mm) < kCtNear_mm, ui.scale());
  }
  // The patient's sides.
  const auto letter = [&](const char* text, float x, float y) {
    const ImVec2 size = ImGui::CalcTextSize(text);
    const ImVec2 corner{at.x + x - 0.5F * size.x, at.y + y - 0.5F * size.y};
    list.AddRectFilled({corner.x - 3, corner.y}, {corner.x + size.x + 3, corner.y + size.y}, IM_COL32(0, 0, 0, 140));
    list.AddText(corner, IM_COL32_WHITE, text);
  };
  const float rim = 10 * ui.scale();
  letter(axis == 0 ? "A" : "R", rim, 0.5F * height);
  letter(axis == 0 ? "P" : "L", width - rim, 0.5F * height);
  letter(axis == 2 ? "A" : "S", 0.5F * width, rim);
  letter(axis == 2 ? "P" : "I", 0.5F * width, height - rim);
  list.PopClipRect();
  if (!hovered) return std::nullopt;
  uses_wheel_ = true;
  const ImGuiIO& io = ImGui::GetIO();
  if (io.MouseWheel != 0) {
    slice.at_mm = std::clamp(slice.at_mm + kCtWheel_mm * static_cast<double>(io.MouseWheel), scan_W_.lower[axis],
                             scan_W_.upper[axis]);
    Update(i);
  }
  if (const ImVec2 by = io.MouseDelta; ImGui::IsMouseDragging(1, 0) && (by.x != 0 || by.y != 0)) {
    DragGreys(by.x / ui.scale(), by.y / ui.scale(), greys_.level_HU, greys_.width_HU);
    for (std::size_t k = 0; k < slices_.size(); ++k) Update(k);
  }
  if (!ImGui::IsMouseClicked(0)) return std::nullopt;
  Vec3 p_W(slice.at_mm);
  p_W[across] = part.left_mm + wide_mm * static_cast<double>((io.MousePos.x - at.x) / width);
  p_W[down] = part.top_mm + high_mm * static_cast<double>((io.MousePos.y - at.y) / height);
  return p_W;
}

/// Adds the slider with which the slice is moved.
void CtPreview::DrawPosition(Ui& ui, std::size_t i, float width) {
  Slice& slice = slices_[i];
  const int axis = CtAxisOf(i);
  ImGui::SetNextItemWidth(width);
  auto value = static_cast<float>(slice.at_mm);
  if (ImGui::SliderFloat("##at", &value, static_cast<float>(scan_W_.lower[axis]),
                         static_cast<float>(scan_W_.upper[axis]), "")) {
    slice.at_mm = static_cast<double>(value);
    Update(i);
  }
  ui.Note(fmt::format("ct.at {}", i + 1));
}

void CtPreview::Draw(Ui& ui, const UiBox& area, const std::shared_ptr<const Volume>& volume,
                     const std::vector<CtMark>& marks) {
  if (!volume || !BeginPanel(ui, "ct", area, true, false)) return;
  Follow(volume);
  uses_wheel_ = false;
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    const Slice& slice = slices_[i];
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::PushID(static_cast<int>(i));
    // The number is not in the slider, whose knob would hide it.
    FittedText(ui, DescribeSliceAt(kCtKinds[i], CtAxisOf(i), slice.at_mm), width);
    Tooltip(ui, Tr(ExplainPlaces()));
    const float height = width * CalcShape(i);
    if (DrawSlice(ui, i, width, height, marks)) large_ = i;
    ui.Note(fmt::format("ct {}", i + 1));
    DrawPosition(ui, i, width);
    ImGui::PopID();
  }
  ScrollColumn(uses_wheel_);
  EndPanel();
}

std::optional<Vec3> CtPreview::DrawLarge(Ui& ui, float width, float height, const std::shared_ptr<const Volume>& volume,
                                         const std::vector<CtMark>& marks) {
  Follow(volume);
  ImGui::PushID("large");
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(NameOf(kCtKinds[i]), large_ == i)) large_ = i;
    ui.Note(fmt::format("ct.large {}", i + 1));
  }
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(Translate(DescribePlaceAlong(CtAxisOf(large_), slices_[large_].at_mm)).c_str());
  Tooltip(ui, Tr(ExplainPlaces()));
  const float rows = 2 * ImGui::GetFrameHeightWithSpacing();
  const float shape = CalcShape(large_);
  const float wide = std::max(1.0F, std::min(width, (height - rows) / shape));
  const std::optional<Vec3> clicked = DrawSlice(ui, large_, wide, wide * shape, marks);
  ui.Note("ct.large");
  DrawPosition(ui, large_, wide);
  ImGui::PopID();
  return clicked;
}

}  // namespace kerf
