#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/live/hud_draw.h"
#include "view/live/hud_ink.h"

namespace kerf {

using S = HudSizes;

namespace ink {

void Mark(HudLevel level, double x, double y, double size, DrawList& list) {
  const FlatColour colour{LevelColour(level), 1};
  const double r = 0.5 * size;
  const FlatColour white{{255, 255, 255}, 1};
  switch (level) {
    case HudLevel::kGood:
      list.Disc({x, y}, size, colour);
      list.Polyline({{x - 0.5 * r, y}, {x - 0.1 * r, y + 0.45 * r}, {x + 0.55 * r, y - 0.4 * r}}, 0.14 * size, white);
      break;
    case HudLevel::kWarn:
      list.Triangle({x, y - r}, {x + 1.1 * r, y + r}, {x - 1.1 * r, y + r}, colour);
      list.Box({x - 0.06 * size, y - 0.35 * r, 0.12 * size, 0.75 * r}, kText);
      list.Box({x - 0.06 * size, y + 0.55 * r, 0.12 * size, 0.2 * r}, kText);
      break;
    case HudLevel::kBad:
      list.Box({x - r, y - r, size, size}, colour);
      list.Line({x - 0.55 * r, y - 0.55 * r}, {x + 0.55 * r, y + 0.55 * r}, 0.15 * size, white);
      list.Line({x - 0.55 * r, y + 0.55 * r}, {x + 0.55 * r, y - 0.55 * r}, 0.15 * size, white);
      break;
    case HudLevel::kPlain:
      list.Disc({x, y}, 0.5 * size, kFaint);
      break;
  }
}

void Selected(const FlatBox& row, DrawList& list) {
  list.Box(row, {{204, 224, 246}, 1});
  list.Box({row.left, row.top, 4, row.height}, {kForceColour, 1});
}

}  // namespace ink

namespace {

void DrawTitle(const std::string& title, const FlatBox& box, DrawList& list) {
  // The right end is reserved for the note about rows that are not shown.
  list.Text({CutText(title, S::kTitle, true, box.width - 4 * S::kInset - 130), box.left + 2 * S::kInset, box.top + 14,
             S::kTitle, true, false, Align::kLeft, ink::kText});
}

void DrawFooter(const std::string& footer, const FlatBox& box, DrawList& list) {
  if (footer.empty()) return;
  list.Box({box.left + 1, box.bottom() - 33, box.width - 2, 1}, ink::kEdge);
  list.Text({CutText(footer, S::kSmall, false, box.width - 4 * S::kInset), box.left + 2 * S::kInset, box.bottom() - 25,
             S::kSmall, false, false, Align::kLeft, ink::kFaint});
}

void DrawProgress(const HudProgress& progress, const FlatBox& box, DrawList& list) {
  DrawTitle(progress.title, box, list);
  const FlatBox bar{box.left + 2 * S::kInset, box.top + 62, box.width - 4 * S::kInset, 22};
  list.Box(bar, {{222, 226, 231}, 1});
  if (progress.fraction) {
    const double fraction = std::clamp(*progress.fraction, 0.0, 1.0);
    list.Box({bar.left, bar.top, fraction * bar.width, bar.height}, {kForceColour, 1});
    list.Text({fmt::format("{:.0f} %", std::floor(100 * fraction)), bar.right(), bar.bottom() + 12, S::kText, true,
               false, Align::kRight, ink::kText});
  }
  list.Frame(bar, 1, ink::kFaint);
  list.Text({CutText(progress.stage, S::kText, false, bar.width - 70), bar.left, bar.bottom() + 12, S::kText, false,
             false, Align::kLeft, ink::kText});
}

void DrawHelp(const std::vector<HudKeyGroup>& groups, const FlatBox& box, DrawList& list) {
  DrawTitle("Keys and mouse", box, list);
  const FlatBox inside{box.left + 2 * S::kInset, box.top + 50, box.width - 4 * S::kInset, box.height - 60};
  for (const HelpPlace& place : PlaceHelp(groups, inside)) {
    const HudKeyGroup& group = groups[place.group];
    double y = place.y;
    if (y + 26 > box.bottom() - 4) continue;
    list.Text({CutText(group.title, S::kText, true, place.width),
               place.x,
               y,
               S::kText,
               true,
               false,
               Align::kLeft,
               {kForceColour, 1}});
    list.Box({place.x, y + 20, place.width, 1}, ink::kEdge);
    y += 26;
    // All keys of a group are in one column, as wide as the widest, but at most half of the width.
    double widest = 0;
    for (const HudKey& key : group.keys) widest = std::max(widest, 1.05 * CalcTextWidth(key.keys, S::kSmall, true));
    widest = std::min(widest + 12, 0.55 * place.width);
    for (const HudKey& key : group.keys) {
      if (y + 18 > box.bottom() - 4) break;
      list.Text({CutText(key.keys, S::kSmall, true, widest - 6), place.x, y, S::kSmall, true, false, Align::kLeft,
                 ink::kText});
      list.Text({CutText(key.meaning, S::kSmall, false, place.width - widest), place.x + widest, y, S::kSmall, false,
                 false, Align::kLeft, ink::kText});
      y += 21;
    }
  }
}

void DrawMenu(const HudMenu& menu, const FlatBox& box, DrawList& list) {
  DrawTitle(menu.title, box, list);
  const MenuRows rows = PlaceMenuRows(menu, box);
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const HudMenuRow& row = menu.rows[rows.first + i];
    const FlatBox& at = rows.rows[i];
    const bool selected = static_cast<int>(rows.first + i) == menu.selected;
    if (selected) ink::Selected(at, list);
    const FlatColour& colour = row.enabled ? ink::kText : ink::kFaint;
    const double room = at.width - 2 * S::kInset;
    const std::string detail = CutText(row.detail, S::kSmall, false, 0.72 * room);
    const double taken = 1.05 * CalcTextWidth(detail, S::kSmall, false);
    list.Text({CutText(row.name, S::kText, selected, room - taken - 12), at.left + S::kInset, at.top + 6, S::kText,
               selected, false, Align::kLeft, colour});
    list.Text({detail, at.right() - S::kInset, at.top + 7, S::kSmall, false, false, Align::kRight, ink::kFaint});
  }
  if (rows.rows.size() < menu.rows.size()) {
    list.Text({fmt::format("{} to {} of {}", rows.first + 1, rows.first + rows.rows.size(), menu.rows.size()),
               box.right() - 2 * S::kInset, box.top + 20, S::kSmall, false, false, Align::kRight, ink::kFaint});
  }
  DrawFooter(menu.footer, box, list);
}

void DrawResult(const HudResult& result, const FlatBox& box, DrawList& list) {
  DrawTitle(result.title, box, list);
  list.Text({CutText(result.headline, S::kTitle, true, box.width - 4 * S::kInset),
             box.left + 2 * S::kInset,
             box.top + 46,
             S::kTitle,
             true,
             false,
             Align::kLeft,
             {kForceColour, 1}});
  double y = box.top + 84;
  const double name_x = box.left + 2 * S::kInset + 24;
  const double value_right = box.left + 0.6 * box.width;
  const double note_x = value_right + 16;
  list.Box({box.left + 2 * S::kInset, y - 4, box.width - 4 * S::kInset, 1}, ink::kEdge);
  std::size_t shown = 0;
  for (const HudResultRow& row : result.rows) {
    if (y + S::kRow > box.bottom() - 40) break;
    ++shown;
    ink::Mark(row.level, box.left + 2 * S::kInset + 8, y + 10, 14, list);
    const double value_width = 1.05 * CalcTextWidth(row.value, S::kText, true);
    list.Text({CutText(row.name, S::kText, false, value_right - value_width - name_x - 10), name_x, y + 1, S::kText,
               false, false, Align::kLeft, ink::kText});
    list.Text({row.value, value_right, y + 1, S::kText, true, false, Align::kRight, ink::kText});
    list.Text({CutText(row.note, S::kSmall, false, box.right() - S::kInset - note_x), note_x, y + 3, S::kSmall, false,
               false, Align::kLeft, ink::kFaint});
    y += S::kRow;
  }
  if (shown < result.rows.size()) {
    list.Text({fmt::format("{} more in the report", result.rows.size() - shown), box.right() - 2 * S::kInset,
               box.top + 20, S::kSmall, false, false, Align::kRight, ink::kFaint});
  }
  DrawFooter(result.footer, box, list);
}

}  // namespace

void DrawModal(const HudState& state, const FlatBox& box, DrawList& list) {
  list.Panel(box, {{252, 253, 254}, 0.98}, {{120, 128, 140}, 1});
  if (state.progress) {
    DrawProgress(*state.progress, box, list);
  } else if (state.show_help) {
    DrawHelp(state.help, box, list);
  } else if (state.menu) {
    DrawMenu(*state.menu, box, list);
  } else if (state.result) {
    DrawResult(*state.result, box, list);
  }
}

}  // namespace kerf
