#include "app/window/cut_panel.h"

#include <algorithm>
#include <cmath>

#include "app/window/practice_widgets.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

/// Width of the line to follow; a thinner one would be as pale as that of the bone.
constexpr float kLineWidth = 2;

/// Draws a line through the points with dashes and gaps of equal lengths.
void AddDashes(ImDrawList& list, const std::vector<ImVec2>& points, ImU32 colour, float width, float dash) {
  float at = 0;  // length of the line so far, within a dash and the following gap
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const ImVec2 a = points[i];
    const ImVec2 b = points[i + 1];
    const float length = std::hypot(b.x - a.x, b.y - a.y);
    float from = 0;
    while (from < length) {
      const bool drawn = at < dash;
      const float step = std::min((drawn ? dash : 2 * dash) - at, length - from);
      const auto point = [&](float l) {
        return ImVec2{a.x + (b.x - a.x) * l / length, a.y + (b.y - a.y) * l / length};
      };
      if (drawn) list.AddLine(point(from), point(from + step), colour, width);
      from += step;
      at += step;
      if (at >= 2 * dash - 1e-3F) at = 0;
      // Rounding must not leave a step without length.
      if (step < 1e-3F) from += 1e-3F;
    }
  }
}

}  // namespace

void AddStroke(ImDrawList& list, const std::vector<ImVec2>& points, Stroke stroke, const Rgb8& colour, float width) {
  if (points.size() < 2) return;
  if (stroke == Stroke::kDashed) return AddDashes(list, points, ToImU32(colour), width, 3.5F * width);
  list.AddPolyline(points.data(), static_cast<int>(points.size()), ToImU32(colour), 0, width);
}

void LegendEntryItem(Ui& ui, Stroke stroke, const Rgb8& colour, float width, const std::string& name) {
  const float s = ui.scale();
  const float height = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  // On white, as in the picture.
  list.AddRectFilled(at, {at.x + 34 * s, at.y + height}, ToImU32(kPaper));
  AddStroke(list, {{at.x + 3 * s, at.y + 0.5F * height}, {at.x + 31 * s, at.y + 0.5F * height}}, stroke, colour, width);
  ImGui::Dummy({34 * s, height});
  ImGui::SameLine();
  ImGui::TextUnformatted(name.c_str());
}

namespace {

/// Draws one view of the cut, of the given size in pixels, with a scale bar.
void DrawCutView(Ui& ui, const CutView& view, const std::string& title, double scale_bar_mm, float width,
                 float height) {
  const float s = ui.scale();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  ImGui::BeginGroup();
  FittedText(ui, title, width);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 end{corner.x + width, corner.y + height};
  list.AddRectFilled(corner, end, ToImU32(kPaper));
  list.AddRect(corner, end, ToImU32(ui.colours().edge));
  const float bar_room = 24 * s;
  const double scale =
      std::min(static_cast<double>(width - 12 * s) / std::max(1e-6, view.right_mm - view.left_mm),
               static_cast<double>(height - bar_room - 6 * s) / std::max(1e-6, view.top_mm - view.bottom_mm));
  const double middle_x = 0.5 * (view.left_mm + view.right_mm);
  const double middle_y = 0.5 * (view.bottom_mm + view.top_mm);
  const auto draw = [&](const PictureLine& line, Stroke stroke, const Rgb8& colour, float thickness) {
    std::vector<ImVec2> points;
    points.reserve(line.size());
    for (const PicturePoint& p : line) {
      points.push_back({corner.x + 0.5F * width + static_cast<float>(scale * (p.x_mm - middle_x)),
                        corner.y + 0.5F * (height - bar_room) - static_cast<float>(scale * (p.y_mm - middle_y))});
    }
    AddStroke(list, points, stroke, colour, thickness * s);
  };
  list.PushClipRect(corner, end, true);
  for (const PictureLine& line : view.bone) draw(line, Stroke::kSolid, kBoneLine, 1.5F);
  for (const PictureLine& line : view.made) draw(line, Stroke::kSolid, kMadeColour, 2);
  for (const PictureLine& line : view.wanted) draw(line, Stroke::kDashed, kWantedColour, 2);
  draw(view.line, Stroke::kSolid, kInk, kLineWidth);
  const auto bar = static_cast<float>(scale * scale_bar_mm);
  const float y = end.y - 9 * s;
  const float left = corner.x + 8 * s;
  list.AddLine({left, y}, {left + bar, y}, ToImU32(kInk), 2 * s);
  for (const float x : {left, left + bar}) list.AddLine({x, y - 4 * s}, {x, y + 4 * s}, ToImU32(kInk), 2 * s);
  const std::string length = FormatQuantity({scale_bar_mm, scale_bar_mm < 1 ? 1 : 0, "mm"}, PointOfLanguage());
  list.AddText({left + bar + 6 * s, y - 0.5F * ImGui::GetTextLineHeight()}, ToImU32(kInk), length.c_str());
  list.PopClipRect();
  ImGui::Dummy({width, height});
  ImGui::EndGroup();
}

}  // namespace

void DrawCutPicture(Ui& ui, const CutPicture& picture) {
  const float s = ui.scale();
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const float width = std::floor(0.5F * (ImGui::GetContentRegionAvail().x - gap));
  const float height = 150 * s;
  DrawCutView(ui, picture.above, Tr("From above"), picture.scale_bar_mm, width, height);
  ui.Note("practise.above");
  ImGui::SameLine();
  DrawCutView(ui, picture.side, Tr("From the side"), picture.scale_bar_mm, width, height);
  ui.Note("practise.side");
  LegendEntryItem(ui, Stroke::kDashed, kWantedColour, 2 * s, Tr("wanted"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kMadeColour, 2 * s, Tr("made"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kBoneLine, 1.5F * s, Tr("bone"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kInk, kLineWidth * s, Tr("line to follow"));
}

}  // namespace kerf
