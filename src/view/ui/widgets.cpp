#include "view/ui/widgets.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr char kEllipsis[] = "\u2026";

ImVec2 Add(const ImVec2& a, float x, float y) {
  return {a.x + x, a.y + y};
}

}  // namespace

Rgb8 LevelColour(HudLevel level) {
  switch (level) {
    case HudLevel::kGood:
      return {0, 130, 95};
    case HudLevel::kWarn:
      return {230, 159, 0};
    case HudLevel::kBad:
      return {190, 40, 20};
    case HudLevel::kPlain:
      break;
  }
  return {70, 78, 90};
}

void DrawLevelMark(ImDrawList& list, HudLevel level, const ImVec2& centre, float size) {
  const ImU32 colour = ToImU32(LevelColour(level));
  const ImU32 white = IM_COL32(255, 255, 255, 255);
  const ImU32 dark = IM_COL32(26, 29, 36, 255);
  const float r = 0.5F * size;
  switch (level) {
    case HudLevel::kGood: {
      list.AddCircleFilled(centre, r, colour);
      const ImVec2 tick[] = {Add(centre, -0.5F * r, 0), Add(centre, -0.1F * r, 0.45F * r),
                             Add(centre, 0.55F * r, -0.4F * r)};
      list.AddPolyline(tick, 3, white, 0, 0.14F * size);
      break;
    }
    case HudLevel::kWarn:
      list.AddTriangleFilled(Add(centre, 0, -r), Add(centre, 1.1F * r, r), Add(centre, -1.1F * r, r), colour);
      list.AddRectFilled(Add(centre, -0.12F * r, -0.35F * r), Add(centre, 0.12F * r, 0.4F * r), dark);
      list.AddRectFilled(Add(centre, -0.12F * r, 0.55F * r), Add(centre, 0.12F * r, 0.78F * r), dark);
      break;
    case HudLevel::kBad:
      list.AddRectFilled(Add(centre, -r, -r), Add(centre, r, r), colour);
      list.AddLine(Add(centre, -0.55F * r, -0.55F * r), Add(centre, 0.55F * r, 0.55F * r), white, 0.15F * size);
      list.AddLine(Add(centre, -0.55F * r, 0.55F * r), Add(centre, 0.55F * r, -0.55F * r), white, 0.15F * size);
      break;
    case HudLevel::kPlain:
      list.AddCircleFilled(centre, 0.5F * r, colour);
      break;
  }
}

void LevelMark(Ui& /*ui*/, HudLevel level) {
  const float height = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  DrawLevelMark(*ImGui::GetWindowDrawList(), level, Add(at, 0.5F * height, 0.5F * height), 0.85F * height);
  ImGui::Dummy({height, height});
}

std::string FitText(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  // Each of the two sizes is rounded up to a whole pixel.
  const float room = width - ImGui::CalcTextSize(kEllipsis).x - 1;
  std::size_t end = text.size();
  while (end > 0) {
    // Removes one character of UTF-8.
    --end;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
    if (ImGui::CalcTextSize(text.c_str(), text.c_str() + end).x <= room) break;
  }
  return text.substr(0, end) + kEllipsis;
}

void AddCasedText(ImDrawList& list, const ImVec2& left, unsigned int colour, const std::string& text) {
  const ImVec2 at{left.x, left.y - 0.5F * ImGui::GetFontSize()};
  const float by = std::max(1.0F, 0.08F * ImGui::GetFontSize());
  for (const ImVec2& away : {ImVec2{-by, 0}, ImVec2{by, 0}, ImVec2{0, -by}, ImVec2{0, by}}) {
    list.AddText({at.x + away.x, at.y + away.y}, IM_COL32(0, 0, 0, 220), text.c_str());
  }
  list.AddText(at, colour, text.c_str());
}

void FittedText(Ui& ui, const std::string& text, float width) {
  const std::string shown = FitText(text, width);
  ImGui::TextUnformatted(shown.c_str());
  if (shown == text) return;
  ui.NoteCutText(text);
  Tooltip(ui, text);
}

namespace {

/// Returns true if a space between two words must not end a line: a number and its unit.
bool IsUnitAfterNumber(std::string_view number, std::string_view unit) {
  if (number.empty() || number.back() < '0' || number.back() > '9') return false;
  for (const std::string_view known : {"mm", "cm", "s", "ms", "min", "h", "N", "%", "\u00b0", "rpm", "U/min", "HU",
                                       "Hz", "kHz", "kB", "MB", "GB", "MPa", "GPa"}) {
    if (!unit.starts_with(known)) continue;
    const char next = unit.size() > known.size() ? unit[known.size()] : ' ';
    if (!((next >= 'a' && next <= 'z') || (next >= 'A' && next <= 'Z'))) return true;
  }
  return false;
}

}  // namespace

std::string BreakLines(const std::string& text, float width) {
  std::string broken = text;
  const char* const all = broken.c_str();
  std::size_t line = 0;                   // its beginning
  std::size_t space = std::string::npos;  // the last one at which the line may end
  std::size_t before = 0;                 // beginning of the word before the current one
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", from), text.size());
    const std::string_view word = std::string_view(text).substr(from, end - from);
    const bool begins = from == line;
    if (!begins && !IsUnitAfterNumber(std::string_view(text).substr(before, from - 1 - before), word)) space = from - 1;
    if (!word.empty() && space != std::string::npos && ImGui::CalcTextSize(all + line, all + end).x > width) {
      broken[space] = '\n';
      line = space + 1;
      space = std::string::npos;
    }
    if (end < text.size() && text[end] == '\n') {
      line = end + 1;
      space = std::string::npos;
    }
    before = from;
    from = end + 1;
  }
  return broken;
}

void WrappedText(const std::string& text, float width) {
  if (width <= 0) width = ImGui::GetContentRegionAvail().x;
  // A word that is longer than a line is broken within.
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + width + 1);
  ImGui::TextUnformatted(BreakLines(text, width).c_str());
  ImGui::PopTextWrapPos();
}

float CalcWrappedHeight(const std::string& text, float width) {
  return ImGui::CalcTextSize(BreakLines(text, width).c_str(), nullptr, false, width + 1).y;
}

void Tooltip(Ui& ui, const std::string& text) {
  if (text.empty() || !ui.tooltips() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  WrappedText(text, 360 * ui.scale());
  ImGui::EndTooltip();
}

void TooltipBeside(Ui& ui, const std::string& text) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  const ImVec2 item = ImGui::GetItemRectMin();
  ImGui::SetNextWindowPos({item.x - 16 * ui.scale(), item.y}, ImGuiCond_Always, {1, 0});
  Tooltip(ui, text);
}

bool TextField(Ui& ui, const char* id, std::string& value) {
  Ui::TypedText& typed = ui.typed();
  std::string text = value;
  const bool changed = ImGui::InputText(id, &text, ImGuiInputTextFlags_AutoSelectAll);
  const ImGuiID item = ImGui::GetItemID();
  if (changed) typed = {item, text};
  if (!ImGui::IsItemDeactivatedAfterEdit() || typed.id != item) return false;
  const Ui::TypedText left = std::exchange(typed, {});
  if (ui.discards_text() || left.text == value) return false;
  value = left.text;
  return true;
}

bool NumberField(Ui& ui, const char* id, double& value, int decimals) {
  std::string text = ShowNumber(value, decimals);
  if (!TextField(ui, id, text)) return false;
  const std::optional<double> number = ParseNumber(text);
  if (number) value = *number;
  return number.has_value();
}

void Gauge(Ui& ui, const HudGauge& gauge) {
  const float s = ui.scale();
  const UiColours& c = ui.colours();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float width = ImGui::GetContentRegionAvail().x;
  const std::string value =
      gauge.value ? fmt::format("{} {}", ShowNumber(*gauge.value, 2), gauge.unit) : std::string("\u2013");
  ImGui::PushFont(ui.bold());
  ImGui::TextUnformatted(gauge.title.c_str());
  ImGui::SameLine(width - ImGui::CalcTextSize(value.c_str()).x + ImGui::GetStyle().WindowPadding.x);
  ImGui::TextUnformatted(value.c_str());
  ImGui::PopFont();

  const ImVec2 from = Add(ImGui::GetCursorScreenPos(), 0, 8 * s);
  const ImVec2 to = Add(from, width, 22 * s);
  const double span = std::max(1e-9, gauge.upper - gauge.lower);
  const auto at = [&](double x) {
    return from.x + width * static_cast<float>(std::clamp((x - gauge.lower) / span, 0.0, 1.0));
  };
  list.AddRectFilled(from, to, ToImU32(c.button));
  if (gauge.goal) {
    const auto zone = [&](double begin, double end, HudLevel level, double alpha) {
      list.AddRectFilled({at(begin), from.y}, {at(end), to.y}, ToImU32(LevelColour(level), alpha));
    };
    zone(*gauge.goal - gauge.warn, *gauge.goal - gauge.good, HudLevel::kWarn, 0.45);
    zone(*gauge.goal - gauge.good, *gauge.goal + gauge.good, HudLevel::kGood, 0.5);
    zone(*gauge.goal + gauge.good, *gauge.goal + gauge.bad, HudLevel::kWarn, 0.45);
    zone(*gauge.goal + gauge.bad, gauge.upper, HudLevel::kBad, 0.45);
    list.AddRectFilled({at(*gauge.goal) - s, from.y - 4 * s}, {at(*gauge.goal) + s, to.y + 4 * s}, ToImU32(c.text));
  }
  if (gauge.value) {
    const float x = at(*gauge.value);
    list.AddRectFilled(Add(from, 0, 7 * s), {x, from.y + 15 * s}, ToImU32(c.text, 0.85));
    list.AddTriangleFilled({x - 7 * s, from.y - 7 * s}, {x + 7 * s, from.y - 7 * s}, {x, from.y + 5 * s},
                           ToImU32(c.text));
  }
  ImGui::Dummy({width, 34 * s});
  if (gauge.goal) {
    ImGui::PushFont(ui.small());
    const std::string goal = fmt::format(fmt::runtime(Tr("goal {} {}")), ShowNumber(*gauge.goal, 1), gauge.unit);
    const float goal_width = ImGui::CalcTextSize(goal.c_str()).x;
    const float x = std::clamp(at(*gauge.goal) - 0.5F * goal_width, from.x, to.x - goal_width);
    ImGui::SetCursorScreenPos({x, ImGui::GetCursorScreenPos().y});
    ImGui::TextDisabled("%s", goal.c_str());
    ImGui::PopFont();
  }
  if (gauge.word.empty()) return;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float height = ImGui::GetTextLineHeight() + 10 * s;
  list.AddRectFilled(corner, Add(corner, width, height), ToImU32(LevelColour(gauge.level), 0.22));
  DrawLevelMark(list, gauge.level, Add(corner, 14 * s, 0.5F * height), 17 * s);
  ImGui::SetCursorScreenPos(Add(corner, 30 * s, 5 * s));
  // Large text in a narrow column: in small letters rather than cut.
  ImGui::PushFont(ui.bold());
  const bool fits = ImGui::CalcTextSize(gauge.word.c_str()).x <= width - 34 * s;
  ImGui::PopFont();
  ImGui::PushFont(fits ? ui.bold() : ui.small());
  FittedText(ui, gauge.word, width - 34 * s);
  ImGui::PopFont();
  ImGui::SetCursorScreenPos(Add(corner, 0, height + 3 * s));
}

double CalcAxisTop(double max) {
  double top = 1;
  for (int i = 0; top < max && i < 30; ++i) top *= i % 3 == 1 ? 2.5 : 2;
  return top;
}

void ForcePlot(Ui& ui, const std::vector<PlotPoint>& force, double now_s) {
  constexpr double kSpan_s = 10;
  constexpr double kNone_N = 0.005;  // the values show two decimals
  const float s = ui.scale();
  const UiColours& c = ui.colours();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  ImGui::PushFont(ui.small());
  const float line_height = ImGui::GetTextLineHeight();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float margin = ImGui::CalcTextSize("1000").x + 4 * s;
  const ImVec2 from = Add(corner, margin, 0.5F * line_height);
  const float width = ImGui::GetContentRegionAvail().x - margin;
  const float height = 76 * s;
  const ImVec2 to = Add(from, width, height);
  double max_N = 0;
  for (const PlotPoint& p : force) {
    if (p.time_s >= now_s - kSpan_s && std::isfinite(p.force_N)) max_N = std::max(max_N, p.force_N);
  }
  const double top_N = CalcAxisTop(max_N);
  for (int i = 0; i <= 2; ++i) {
    const float y = to.y - 0.5F * static_cast<float>(i) * height;
    list.AddLine({from.x, y}, {to.x, y}, ToImU32(c.edge));
    const double value_N = 0.5 * i * top_N;
    int decimals = 0;
    for (double scaled = value_N; decimals < 3 && std::abs(scaled - std::round(scaled)) > 1e-6; scaled *= 10)
      ++decimals;
    const std::string number = ShowNumber(value_N, decimals);
    list.AddText({from.x - 5 * s - ImGui::CalcTextSize(number.c_str()).x, y - 0.5F * line_height}, ToImU32(c.faint),
                 number.c_str());
  }
  // Reduces many points to the largest and the smallest value for each pixel.
  std::vector<ImVec2> line;
  long column = -1;
  double low = 0;
  double high = 0;
  const auto flush = [&] {
    if (column < 0) return;
    for (const double f : {low, high}) {
      line.push_back(
          {from.x + static_cast<float>(column), to.y - height * static_cast<float>(std::clamp(f / top_N, 0.0, 1.0))});
    }
  };
  for (const PlotPoint& p : force) {
    const double fraction = 1 - (now_s - p.time_s) / kSpan_s;
    if (fraction < 0 || fraction > 1 || !std::isfinite(p.force_N)) continue;
    const long here = std::lround(fraction * static_cast<double>(width));
    if (here != column) {
      flush();
      column = here;
      low = high = p.force_N;
    }
    low = std::min(low, p.force_N);
    high = std::max(high, p.force_N);
  }
  flush();
  // A curve without a force is the same line at all times.
  if (max_N < kNone_N && line.size() > 2) line = {{line.front().x, to.y}, {to.x, to.y}};
  list.AddPolyline(line.data(), static_cast<int>(line.size()), ToImU32(c.accent), 0, 1.6F * s);
  const char* now = Tr("now");
  list.AddText({from.x, to.y + 3 * s}, ToImU32(c.faint), Tr("10 s ago"));
  list.AddText({to.x - ImGui::CalcTextSize(now).x, to.y + 3 * s}, ToImU32(c.faint), now);
  ImGui::Dummy({margin + width, height + 2 * line_height});
  ImGui::PopFont();
}

float CalcIndicatorWidth(const Ui& ui, const std::string& name, const std::string& key) {
  const float s = ui.scale();
  const float key_width = key.empty() ? 0 : 8 * s + ImGui::CalcTextSize(key.c_str()).x;
  return 28 * s + ImGui::CalcTextSize(name.c_str()).x + key_width;
}

bool Indicator(Ui& ui, const char* id, const std::string& name, bool on, const std::string& key,
               const std::string& tip) {
  const float s = ui.scale();
  const UiColours& c = ui.colours();
  const float name_width = ImGui::CalcTextSize(name.c_str()).x;
  const float height = ImGui::GetFrameHeight();
  const ImVec2 size{CalcIndicatorWidth(ui, name, key), height};
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::InvisibleButton(id, size);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const bool hot = ImGui::IsItemHovered();
  list.AddRectFilled(at, Add(at, size.x, size.y), ToImU32(on || hot ? c.selected : c.button), 3 * s);
  const ImVec2 lamp = Add(at, 12 * s, 0.5F * height);
  if (on) {
    list.AddCircleFilled(lamp, 5 * s, ToImU32(c.accent));
  } else {
    list.AddCircle(lamp, 4.5F * s, ToImU32(c.faint), 0, 1.5F * s);
  }
  const float y = at.y + ImGui::GetStyle().FramePadding.y;
  list.AddText({at.x + 21 * s, y}, ToImU32(c.text), name.c_str());
  list.AddText({at.x + 28 * s + name_width, y}, ToImU32(c.faint), key.c_str());
  Tooltip(ui, tip);
  return clicked;
}

void BeginDialog(Ui& ui, const char* name, float width, float height) {
  const float s = ui.scale();
  const ImVec2 size{std::min(width, static_cast<float>(ui.width()) - 20 * s),
                    std::min(height, static_cast<float>(ui.height()) - 20 * s)};
  ImGui::SetNextWindowPos({std::floor(0.5F * (static_cast<float>(ui.width()) - size.x)),
                           std::floor(0.4F * (static_cast<float>(ui.height()) - size.y))});
  ImGui::SetNextWindowSize(size);
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {16 * s, 14 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 4 * s);
  ImGui::Begin(name, nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                   ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar(2);
}

void Swatch(Ui& ui, const Rgb8& colour, bool filled) {
  const float size = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (filled) list.AddRectFilled(at, Add(at, size, size), ToImU32(colour));
  list.AddRect(at, Add(at, size, size), ToImU32(ui.colours().faint));
  ImGui::Dummy({size, size});
}

}  // namespace kerf
