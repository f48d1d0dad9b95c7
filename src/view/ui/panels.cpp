#include "view/ui/panels.h"

#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "view/ui/fixed_window.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/picture_marks.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Smaller distances to the nerve canal are highlighted.
constexpr double kNerveWarn_mm = 2;

ImVec2 TopLeft(const UiBox& box) {
  return {static_cast<float>(box.left), static_cast<float>(box.top)};
}
ImVec2 SizeOf(const UiBox& box) {
  return {static_cast<float>(box.width), static_cast<float>(box.height)};
}

std::string ShowDuration(double seconds) {
  const long s = std::lround(std::max(0.0, seconds));
  return s < 60 ? fmt::format(fmt::runtime(Tr("{} s left")), s)
                : fmt::format(fmt::runtime(Tr("{}:{:02} min left")), s / 60, s % 60);
}

void DialogTitle(Ui& ui, const std::string& title) {
  ImGui::PushFont(ui.title());
  FittedText(ui, title, ImGui::GetContentRegionAvail().x);
  ImGui::PopFont();
}

void DialogFooter(Ui& ui, const std::string& footer) {
  if (footer.empty()) return;
  ImGui::Separator();
  ImGui::PushFont(ui.small());
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().faint));
  WrappedText(footer);
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

}  // namespace

UiAreas CalcUiAreas(const Ui& ui, bool left, bool right) {
  const double s = ui.scale();
  const double width = ui.width();
  const double height = ui.height();
  const double menu = ImGui::GetFrameHeight();
  const double toolbar = 36 * s;
  const double status = 32 * s;
  // In a narrow window the left column has a part of it, as long as its values can be read.
  const double full_left_width = 262 * s;
  const double left_width = std::min(full_left_width, 0.42 * width);
  const double right_width = 206 * s;
  UiAreas areas;
  areas.menu = {0, 0, width, menu};
  areas.toolbar = {0, menu, width, toolbar};
  areas.status = {0, height - status, width, status};
  const double top = menu + toolbar;
  const double middle = std::max(0.0, height - top - status);
  double from = 0;
  double to = width;
  if (left && left_width >= 150 * s && middle > 60 * s) {
    areas.left = {0, top, left_width, middle};
    from = left_width;
  }
  const double left_share = left ? 2.2 : 1.2;  // of the left column and the scene
  if (right && width >= left_share * full_left_width + 1.3 * right_width && middle > 60 * s) {
    areas.right = {width - right_width, top, right_width, middle};
    to = width - right_width;
  }
  areas.scene = {from, top, std::max(0.0, to - from), middle};
  const double cube = 96 * s;
  if (areas.scene.width > 3 * cube && middle > 3 * cube) {
    areas.cube = {to - cube - 8 * s, height - status - cube - 8 * s, cube, cube};
  }
  return areas;
}

bool BeginPanel(Ui& /*ui*/, const char* name, const UiBox& area, bool scrolls, bool by_wheel) {
  if (area.empty()) return false;
  ImGui::SetNextWindowPos(TopLeft(area));
  ImGui::SetNextWindowSize(SizeOf(area));
  // Tab goes from one field to the next. A panel that appears must not take the input away from a dialog.
  ImGuiWindowFlags flags = (kFixedWindow & ~ImGuiWindowFlags_NoNavInputs) | ImGuiWindowFlags_NoFocusOnAppearing;
  if (!scrolls) flags |= ImGuiWindowFlags_NoScrollbar;
  if (!scrolls || !by_wheel) flags |= ImGuiWindowFlags_NoScrollWithMouse;
  ImGui::Begin(name, nullptr, flags);
  return true;
}

void EndPanel() {
  ImGui::End();
}

bool BeginSection(Ui& ui, const char* title, bool open) {
  ImGui::SetNextItemOpen(open, ImGuiCond_Once);
  ImGui::PushFont(ui.bold());
  const bool shown = ImGui::CollapsingHeader(title);
  ImGui::PopFont();
  ui.Note(fmt::format("section {}", title));
  return shown;
}

void ValuesSection(Ui& ui, const HudState& state) {
  if (!state.show_values || !BeginSection(ui, Tr("Values"))) return;
  const HudValues& v = state.values;
  const auto number = [](const std::optional<double>& value, int decimals) {
    return value ? ShowNumber(*value, decimals) : std::string("\u2013");
  };
  HudLevel nerve = HudLevel::kPlain;
  if (v.nerve_mm && *v.nerve_mm < kNerveWarn_mm && !v.nerve_is_crossed) {
    nerve = *v.nerve_mm <= 0 ? HudLevel::kBad : HudLevel::kWarn;
  }
  const bool nerve_is_cut = v.nerve_mm && *v.nerve_mm < 0;
  struct Row {
    const char* name;
    std::string value;
    const char* unit;
    HudLevel level = HudLevel::kPlain;
  };
  std::vector<Row> rows = {
      {Tr("Depth"), number(v.depth_mm, 2), "mm"},
      {v.feed_is_along ? Tr("Feed along the line") : Tr("Feed rate"), number(v.feed_mm_per_s, 1), "mm/s"},
      {v.strokes ? Tr("Double strokes") : Tr("Spindle"), number(v.rpm, 0), v.strokes ? Tr("/min") : Tr("rpm")},
      {Tr("Force on your hand"), number(v.force_N, 2), "N"},
      {Tr("To the nerve"),
       !v.nerve_is_marked ? Tr("not marked")
       : nerve_is_cut     ? ShowDistance(*v.nerve_mm)
                          : number(v.nerve_mm, 1),
       v.nerve_is_marked && !nerve_is_cut ? "mm" : "", nerve},
  };
  if (v.key_feed_mm_per_s)
    rows.insert(rows.begin() + 2, {Tr("Speed of the keys"), number(v.key_feed_mm_per_s, 1), "mm/s"});
  if (v.wanted_feed_mm_per_s)
    rows.insert(rows.begin() + 2, {Tr("Feed wanted"), number(v.wanted_feed_mm_per_s, 1), "mm/s"});
  if (!v.nerve_injury.empty()) rows.push_back({Tr("Nerve"), v.nerve_injury, "", HudLevel::kBad});
  if (!v.teeth_injury.empty()) rows.push_back({Tr("Teeth"), v.teeth_injury, "", HudLevel::kBad});
  if (v.has_plan) {
    const bool known = v.plan_offset_mm.has_value();
    rows.push_back({v.plan_is_of_saw ? Tr("Angle of the saw now") : Tr("Angle to the plan"),
                    known ? number(v.plan_angle_deg, 1) : Tr("no plan"), known ? "°" : "", HudLevel::kPlain});
    rows.push_back({v.plan_is_of_saw ? Tr("Beside the plan now") : Tr("Beside the plan"),
                    !known                ? Tr("no plan")
                    : v.plan_side.empty() ? number(v.plan_offset_mm, 2)
                                          : fmt::format("{} mm {}", number(v.plan_offset_mm, 2), v.plan_side),
                    known && v.plan_side.empty() ? "mm" : "", HudLevel::kPlain});
  }
  const float width = ImGui::GetContentRegionAvail().x;
  const float left = ImGui::GetCursorPosX();
  const float unit = ImGui::CalcTextSize("mm/s").x + 4 * ui.scale();
  for (const Row& row : rows) {
    const bool marked = row.level != HudLevel::kPlain;
    if (marked) {
      const ImVec2 at = ImGui::GetCursorScreenPos();
      ImGui::GetWindowDrawList()->AddRectFilled({at.x - 4, at.y - 2},
                                                {at.x + width + 4, at.y + ImGui::GetTextLineHeight() + 2},
                                                ToImU32(LevelColour(row.level), 0.25));
    }
    ImGui::PushFont(ui.bold());
    const float value_width = ImGui::CalcTextSize(row.value.c_str()).x;
    ImGui::PopFont();
    const float value_at = left + width - (row.unit[0] == '\0' ? 0 : unit) - value_width;
    // Large text in a narrow column: in small letters rather than cut.
    const float name_width = value_at - left - (marked ? 26 * ui.scale() : 6 * ui.scale());
    const bool fits = ImGui::CalcTextSize(row.name).x <= name_width;
    if (!fits) ImGui::PushFont(ui.small());
    FittedText(ui, row.name, name_width);
    if (!fits) ImGui::PopFont();
    if (marked) {
      ImGui::SameLine();
      LevelMark(ui, row.level);
    }
    ImGui::SameLine(value_at);
    ImGui::PushFont(ui.bold());
    ImGui::TextUnformatted(row.value.c_str());
    ImGui::PopFont();
    if (row.unit[0] == '\0') continue;
    ImGui::SameLine(left + width - unit + 4 * ui.scale());
    ImGui::TextDisabled("%s", row.unit);
  }
  ImGui::Spacing();
}

void GaugeSection(Ui& ui, const HudState& state) {
  if (state.gauge && BeginSection(ui, Tr("Depth gauge"))) Gauge(ui, *state.gauge);
}

void ForceSection(Ui& ui, const HudState& state) {
  if (!state.show_plot || !BeginSection(ui, Tr("Force (N)"))) return;
  ForcePlot(ui, state.force, state.now_s);
  if (state.force_note.empty()) return;
  ImGui::PushFont(ui.small());
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().faint));
  WrappedText(state.force_note);
  ui.Note("force note");
  ImGui::PopStyleColor();
  ImGui::PopFont();
  Tooltip(ui, state.force_details);
}

void LegendSection(Ui& ui, const HudState& state) {
  if (state.legend.empty()) return;
  const std::string title = state.legend_title.empty() ? Tr("Colours") : Tr(state.legend_title.c_str());
  if (!BeginSection(ui, (title + "###legend").c_str())) return;
  for (const LegendEntry& entry : state.legend) {
    Swatch(ui, entry.colour);
    ImGui::SameLine();
    WrappedText(Tr(entry.text.c_str()));
  }
}

std::optional<int> PiecesSection(Ui& ui, const HudState& state) {
  std::optional<int> clicked;
  if (state.pieces.empty() || !BeginSection(ui, Tr("Pieces"))) return clicked;
  const float width = ImGui::GetContentRegionAvail().x;
  for (std::size_t i = 0; i < state.pieces.size(); ++i) {
    const HudPiece& piece = state.pieces[i];
    ImGui::PushID(static_cast<int>(i));
    const float top = ImGui::GetCursorPosY();
    std::vector<std::string> lines;
    if (!piece.hidden) {
      for (const std::string& line : {piece.contact, piece.moved}) {
        if (!line.empty()) lines.push_back(line);
      }
    }
    // A text that is too long goes on in the next line.
    const float inset = ImGui::GetStyle().WindowPadding.x + ImGui::GetTextLineHeight() + 8 * ui.scale();
    ImGui::PushFont(ui.small());
    const float mark = piece.overlaps ? ImGui::GetTextLineHeight() + 4 * ui.scale() : 0;
    float below = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      below += CalcWrappedHeight(lines[k], width - inset - (k == 0 ? mark : 0));
    }
    ImGui::PopFont();
    if (ImGui::Selectable("##piece", piece.selected, ImGuiSelectableFlags_AllowItemOverlap,
                          {0, ImGui::GetTextLineHeight() + below})) {
      clicked = static_cast<int>(i);
    }
    ui.Note(fmt::format("piece {}", i));
    Tooltip(ui, piece.tip);
    ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
    Swatch(ui, piece.colour, !piece.hidden);
    ImGui::SameLine();
    const std::string detail = piece.hidden ? Tr("hidden") : piece.detail;
    const float detail_width = ImGui::CalcTextSize(detail.c_str()).x;
    const float from = ImGui::GetCursorPosX();
    FittedText(ui, ShowName(piece.name), width - detail_width - from - 2 * ui.scale());
    ImGui::SameLine(width + ImGui::GetStyle().WindowPadding.x - detail_width);
    ImGui::TextDisabled("%s", detail.c_str());
    float y = top + ImGui::GetTextLineHeight();
    ImGui::PushFont(ui.small());
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const bool warns = k == 0 && piece.overlaps;
      const float left = inset + (warns ? mark : 0);
      ImGui::SetCursorPos({inset, y});
      if (warns) {
        const ImVec2 corner = ImGui::GetCursorScreenPos();
        const float side = ImGui::GetTextLineHeight();
        DrawLevelMark(*ImGui::GetWindowDrawList(), HudLevel::kWarn, {corner.x + 0.5F * side, corner.y + 0.5F * side},
                      side);
        ImGui::SetCursorPosX(left);
      }
      ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(warns ? ui.colours().text : ui.colours().faint));
      WrappedText(lines[k], width - left);
      ImGui::PopStyleColor();
      y += CalcWrappedHeight(lines[k], width - left);
    }
    ImGui::PopFont();
    if (!lines.empty()) ImGui::SetCursorPosY(y + ImGui::GetStyle().ItemSpacing.y);
    ImGui::PopID();
  }
  return clicked;
}

UiBox CalcProgressBox(const Ui& ui, const UiBox& scene) {
  const double s = ui.scale();
  const double width = std::min(330 * s, scene.width - 16 * s);
  const double height = 92 * s;
  if (width < 120 * s || scene.height < height + (kScaleBarRoom + 12) * s) return {};
  return {scene.left + 8 * s, scene.bottom() - height - kScaleBarRoom * s, width, height};
}

bool DrawProgressBox(Ui& ui, const HudProgress& progress, const UiBox& scene) {
  const float s = ui.scale();
  const UiBox box = CalcProgressBox(ui, scene);
  if (box.empty()) return false;
  ImGui::SetNextWindowPos(TopLeft(box));
  ImGui::SetNextWindowSize(SizeOf(box));
  ImGui::Begin("progress", nullptr,
               (kFixedWindow & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_NoScrollbar |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PushFont(ui.bold());
  FittedText(ui, progress.title, ImGui::GetContentRegionAvail().x);
  ui.Note(fmt::format("progress {}", progress.title));
  ImGui::PopFont();
  FittedText(ui, progress.stage, ImGui::GetContentRegionAvail().x);
  const float cancel_width = progress.can_cancel ? ImGui::CalcTextSize(Tr("Cancel")).x + 24 * s : 0;
  const float bar_width = ImGui::GetContentRegionAvail().x - cancel_width;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float bar_height = ImGui::GetFrameHeight();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + bar_width, at.y + bar_height}, ToImU32(ui.colours().button));
  std::string text;
  if (progress.fraction) {
    const double fraction = std::clamp(*progress.fraction, 0.0, 1.0);
    list.AddRectFilled(at, {at.x + bar_width * static_cast<float>(fraction), at.y + bar_height},
                       ToImU32(ui.colours().accent, 0.45));
    text = fmt::format("{:.0f} %", std::floor(100 * fraction));
  }
  if (progress.left_s) text += (text.empty() ? "" : ", ") + ShowDuration(*progress.left_s);
  list.AddText({at.x + 6 * s, at.y + 4 * s}, ToImU32(ui.colours().text), text.c_str());
  ImGui::Dummy({bar_width, bar_height});
  bool cancelled = false;
  if (progress.can_cancel) {
    ImGui::SameLine();
    cancelled = ImGui::Button(Tr("Cancel"));
    ui.Note("progress.cancel");
  }
  ImGui::End();
  return cancelled;
}

std::optional<int> DrawMenuDialog(Ui& ui, const HudMenu& menu) {
  const float s = ui.scale();
  std::optional<int> clicked;
  float width = 560 * s;
  for (const HudMenuRow& row : menu.rows) {
    width =
        std::max(width, ImGui::CalcTextSize(row.name.c_str()).x + ImGui::CalcTextSize(row.detail.c_str()).x + 120 * s);
  }
  const float row_height = ImGui::GetTextLineHeightWithSpacing() + 6 * s;
  BeginDialog(ui, "menu", width, 110 * s + row_height * static_cast<float>(menu.rows.size()));
  DialogTitle(ui, menu.title);
  ImGui::Spacing();
  ImGui::BeginChild("rows", {0, -30 * s});
  for (std::size_t i = 0; i < menu.rows.size(); ++i) {
    const HudMenuRow& row = menu.rows[i];
    ImGui::PushID(static_cast<int>(i));
    const bool selected = static_cast<int>(i) == menu.selected;
    ImGui::BeginDisabled(!row.enabled);
    const float left = ImGui::GetCursorPosX();
    const float available = ImGui::GetContentRegionAvail().x;
    // Only the row that Enter chooses is filled; the mouse outlines its own.
    if (!selected) ImGui::PushStyleColor(ImGuiCol_HeaderHovered, ImVec4{0, 0, 0, 0});
    if (ImGui::Selectable("##row", selected, ImGuiSelectableFlags_AllowItemOverlap, {0, row_height - 5 * s})) {
      clicked = static_cast<int>(i);
    }
    if (!selected) ImGui::PopStyleColor();
    if (!selected && ImGui::IsItemHovered()) {
      ImGui::GetWindowDrawList()->AddRect(ImGui::GetItemRectMin(), ImGui::GetItemRectMax(),
                                          ToImU32(ui.colours().faint));
    }
    ui.Note(fmt::format("menu {}", i + 1));
    if (selected) ImGui::SetScrollHereY();
    const float next_row = ImGui::GetCursorPosY();
    const float detail_width = std::min(ImGui::CalcTextSize(row.detail.c_str()).x, 0.72F * available);
    ImGui::SameLine(left + 4 * s);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 3 * s);
    if (i < 9) {
      ImGui::TextDisabled("%d", static_cast<int>(i) + 1);
      ImGui::SameLine(left + 26 * s);
    } else {
      ImGui::SameLine(left + 26 * s);
    }
    FittedText(ui, row.name, available - detail_width - 44 * s);
    ImGui::SameLine(left + available - detail_width - 8 * s);
    ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().faint));
    FittedText(ui, row.detail, detail_width + 1);
    ImGui::PopStyleColor();
    ImGui::SetCursorPosY(next_row);
    ImGui::EndDisabled();
    ImGui::PopID();
  }
  ImGui::EndChild();
  DialogFooter(ui, menu.footer);
  ImGui::End();
  return clicked;
}

void DrawHelpDialog(Ui& ui, const std::vector<HudKeyGroup>& groups) {
  const float s = ui.scale();
  BeginDialog(ui, "help", 1180 * s, 660 * s);
  DialogTitle(ui, Tr("Keys and mouse"));
  ImGui::BeginChild("groups", {0, -34 * s});
  const float available = ImGui::GetContentRegionAvail().x;
  const int columns = std::max(1, static_cast<int>(available / (330 * s)));
  std::vector<float> heights(static_cast<std::size_t>(columns), 0);
  const float column_width = available / static_cast<float>(columns);
  const ImVec2 origin = ImGui::GetCursorPos();
  float bottom = 0;
  for (const HudKeyGroup& group : groups) {
    const auto least = std::min_element(heights.begin(), heights.end());
    const float x = origin.x + column_width * static_cast<float>(least - heights.begin());
    const float width = column_width - 24 * s;
    ImGui::SetCursorPos({x, origin.y + *least});
    ImGui::BeginGroup();
    ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().accent));
    ImGui::PushFont(ui.bold());
    ImGui::TextUnformatted(group.title.c_str());
    ImGui::PopFont();
    ImGui::PopStyleColor();
    float key_width = 0;
    for (const HudKey& key : group.keys) key_width = std::max(key_width, ImGui::CalcTextSize(key.keys.c_str()).x);
    key_width = std::min(key_width + 12 * s, 0.5F * width);
    for (const HudKey& key : group.keys) {
      ImGui::PushFont(ui.small());
      FittedText(ui, key.keys, key_width);
      ImGui::SameLine(key_width);
      WrappedText(key.meaning, x + width - ImGui::GetCursorPosX());
      ImGui::PopFont();
    }
    ImGui::EndGroup();
    *least += ImGui::GetItemRectSize().y + 14 * s;
    bottom = std::max(bottom, *least);
  }
  ImGui::SetCursorPos({origin.x, origin.y + bottom});
  ImGui::Dummy({1, 1});
  ImGui::EndChild();
  DialogFooter(ui, Tr("F1 or Esc: close"));
  ImGui::End();
}

}  // namespace kerf
