#include "view/ui/banners.h"

#include <imgui.h>

#include <algorithm>

#include "view/ui/fixed_window.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/picture_marks.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

/// Begins a window that cannot be moved or, unless `takes_clicks`, clicked, of the given width and height.
void BeginOverlay(const char* name, float x, float y, float width, float height, const ImVec4& ground,
                  bool takes_clicks = false) {
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({width, height});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ground);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 4);
  ImGui::Begin(name, nullptr,
               kFixedWindow | ImGuiWindowFlags_NoScrollbar | (takes_clicks ? 0 : ImGuiWindowFlags_NoInputs) |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

/// Largest share of the scene's height that a banner takes: of a question, and of others, before they have one line.
constexpr float kQuestionShare = 0.38F;
constexpr float kBannerShare = 0.16F;

/// Lets a click on the current overlay show it in full, or in one line again. `text`: all of it.
void LetUnfold(Ui& ui, bool folded, const std::string& text) {
  if (!ImGui::IsWindowHovered()) return;
  if (ImGui::IsMouseClicked(0)) ui.set_shows_long_banners(folded);
  if (folded && ui.tooltips()) {
    ImGui::BeginTooltip();
    WrappedText(text, 440 * ui.scale());
    ImGui::EndTooltip();
  }
}

/// Draws a text in one line with a sign at its end that says that there is more.
void FoldedLine(const std::string& text, float width) {
  const float sign = ImGui::CalcTextSize("  [+]").x;
  ImGui::TextUnformatted(FitText(text, width - sign).c_str());
  ImGui::SameLine(0, 0);
  ImGui::TextDisabled("  [+]");
}

/// Draws a text in two lines, the second of them with that sign.
void FoldedLines(const std::string& text, float width) {
  const std::size_t end = BreakLines(text, width).find('\n');
  if (end == std::string::npos) return FoldedLine(text, width);
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ImGui::GetStyle().ItemSpacing.x, 0});
  ImGui::TextUnformatted(text.c_str(), text.c_str() + end);
  ImGui::PopStyleVar();
  FoldedLine(text.substr(end + 1), width);
}

struct BannerSize {
  float width = 0;  // too small for a banner: below 120 points
  float text_width = 0;
  float height = 0;
  bool compact = false;  // in small letters, without its sign
  bool answers = true;   // with the keys
  bool folded = false;   // two lines
  bool is_long = false;  // could be folded
};

/// Sets the height for the width of the text.
void CalcBannerHeight(const Ui& ui, const HudBanner& banner, BannerSize& size) {
  const float s = ui.scale();
  ImGui::PushFont(size.compact ? ui.small() : ui.bold());
  size.height = 20 * s + CalcWrappedHeight(banner.text, size.text_width);
  if (!size.compact) ImGui::PopFont();
  if (!banner.answers.empty() && size.answers) {
    size.height += ImGui::GetStyle().ItemSpacing.y + CalcWrappedHeight(banner.answers, size.text_width);
  }
  if (size.compact) ImGui::PopFont();
}

BannerSize CalcBannerSize(const Ui& ui, const HudBanner& banner, const UiBox& scene) {
  const float s = ui.scale();
  BannerSize size;
  size.width = std::min(static_cast<float>(scene.width) - 16 * s, 640 * s);
  size.text_width = size.width - 56 * s;
  CalcBannerHeight(ui, banner, size);
  // In a small scene it must not cover what it speaks of.
  const bool question = banner.kind == HudBanner::Kind::kQuestion;
  const float most = (question ? kQuestionShare : kBannerShare) * static_cast<float>(scene.height);
  if (size.height > most) {
    size.compact = true;
    size.text_width = size.width - 28 * s;
    CalcBannerHeight(ui, banner, size);
  }
  if (size.height > most && question) {
    size.answers = false;
    CalcBannerHeight(ui, banner, size);
  }
  if (size.height > most && !question) {
    size.is_long = true;
    size.folded = !ui.shows_long_banners();
    if (size.folded) {
      ImGui::PushFont(ui.small());
      size.height = 12 * s + std::min(2 * ImGui::GetFontSize(), CalcWrappedHeight(banner.text, size.text_width));
      ImGui::PopFont();
    }
  }
  return size;
}

}  // namespace

double CalcBannerBottom(const Ui& ui, const HudBanner& banner, const UiBox& scene) {
  return scene.top + static_cast<double>(8 * ui.scale() + CalcBannerSize(ui, banner, scene).height);
}

void DrawBanner(Ui& ui, const HudBanner& banner, const UiBox& scene) {
  const float s = ui.scale();
  const bool warning = banner.kind == HudBanner::Kind::kWarning;
  const auto [width, text_width, height, compact, answers, folded, is_long] = CalcBannerSize(ui, banner, scene);
  if (width < 120 * s) return;
  const UiColours& c = ui.colours();
  BeginOverlay("banner", static_cast<float>(scene.left + 0.5 * (scene.width - static_cast<double>(width))),
               static_cast<float>(scene.top) + 8 * s, width, height, ToImVec4(c.panel, 0.97), is_long);
  const ImVec2 at = ImGui::GetWindowPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + 6 * s, at.y + ImGui::GetWindowHeight()},
                     ToImU32(warning ? LevelColour(HudLevel::kWarn) : c.accent));
  const ImVec2 sign{at.x + 26 * s, at.y + 0.5F * ImGui::GetWindowHeight()};
  if (compact) {
    // The bar at its left edge has the colour.
  } else if (warning) {
    DrawLevelMark(list, HudLevel::kWarn, sign, 20 * s);
  } else {
    list.AddCircleFilled(sign, 10 * s, ToImU32(c.accent));
    const char* letter = banner.kind == HudBanner::Kind::kQuestion ? "?" : "i";
    const ImVec2 size = ImGui::CalcTextSize(letter);
    list.AddText({sign.x - 0.5F * size.x, sign.y - 0.5F * size.y}, ToImU32(c.panel), letter);
  }
  const float text_left = compact ? 18 * s : 46 * s;
  ImGui::SetCursorPos({text_left, (folded ? 6 : 10) * s});
  ImGui::BeginGroup();
  ImGui::PushFont(compact ? ui.small() : ui.bold());
  if (folded) {
    FoldedLines(banner.text, text_width);
    ImGui::PopFont();
  } else {
    WrappedText(banner.text, text_width);
    if (!compact) ImGui::PopFont();
    if (!banner.answers.empty() && answers) WrappedText(banner.answers, text_width);
    if (compact) ImGui::PopFont();
  }
  ImGui::EndGroup();
  ui.Note("banner");
  if (is_long) LetUnfold(ui, folded, banner.text + (banner.answers.empty() ? "" : "\n" + banner.answers));
  ImGui::End();
}

void DrawInjuries(Ui& ui, const std::vector<std::string>& injuries, const UiBox& scene) {
  const float s = ui.scale();
  const float width = std::min(static_cast<float>(scene.width) - 16 * s, 640 * s);
  if (injuries.empty() || width < 120 * s) return;
  const float text_width = width - 56 * s;
  std::string all;
  for (const std::string& line : injuries) all += (all.empty() ? "" : "\n") + line;
  ImGui::PushFont(ui.bold());
  float height = 12 * s + CalcWrappedHeight(all, text_width);
  const bool is_long = height > kBannerShare * static_cast<float>(scene.height);
  const bool folded = is_long && !ui.shows_long_banners();
  if (folded) height = 12 * s + ImGui::GetTextLineHeight();
  BeginOverlay("injuries", static_cast<float>(scene.left + 0.5 * (scene.width - static_cast<double>(width))),
               static_cast<float>(scene.top) + 8 * s, width, height, ToImVec4(ui.colours().panel, 0.97), is_long);
  const ImVec2 at = ImGui::GetWindowPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + 6 * s, at.y + height}, ToImU32(LevelColour(HudLevel::kBad)));
  DrawLevelMark(list, HudLevel::kBad, {at.x + 26 * s, at.y + 0.5F * height}, (folded ? 14 : 20) * s);
  ImGui::SetCursorPos({46 * s, 6 * s});
  ImGui::BeginGroup();
  if (folded) {
    FoldedLine(injuries.front(), text_width);
  } else {
    WrappedText(all, text_width);
  }
  ImGui::EndGroup();
  ui.Note("injuries");
  if (is_long) LetUnfold(ui, folded, all);
  const bool hovered = ImGui::IsMouseHoveringRect(at, {at.x + width, at.y + height}, false);
  ImGui::End();
  ImGui::PopFont();
  if (is_long || !hovered || !ui.tooltips()) return;
  ImGui::BeginTooltip();
  WrappedText(
      Tr("Places are measured from the origin of the CT's coordinates, which the scanner has set; without a CT, "
         "from that of the bone's model or file."),
      440 * s);
  ImGui::EndTooltip();
}

void DrawMessages(Ui& ui, const HudMessages& messages, const UiBox& scene, const UiBox& below, const UiBox& tool,
                  double top) {
  const float s = ui.scale();
  float bottom = static_cast<float>(below.empty() ? scene.bottom() - kScaleBarRoom * static_cast<double>(s)
                                                  : below.top - 8 * static_cast<double>(s));
  const auto draw = [&](const char* name, const std::string& text, HudLevel level, bool stays = false) {
    if (text.empty()) return;
    // Beside the cube, if there is room for one.
    const float max_width =
        static_cast<float>(scene.width) - (scene.width > 400 * static_cast<double>(s) ? 260 : 60) * s;
    if (max_width < 80 * s) return;
    const ImVec2 size = ImGui::CalcTextSize(BreakLines(text, max_width).c_str(), nullptr, false, max_width + 1);
    const float left = level == HudLevel::kPlain ? 12 * s : 34 * s;
    const float height = size.y + 14 * s;
    const float width = size.x + left + 14 * s;
    const auto x = static_cast<float>(scene.left + 0.5 * (scene.width - static_cast<double>(size.x + left)));
    bottom -= height;
    const bool at_top = stays && Overlap(tool, {x, bottom, width, height});
    const float y = at_top ? static_cast<float>(top) + 8 * s : bottom;
    if (at_top) bottom += height + 6 * s;
    BeginOverlay(name, x, y, width, height, ToImVec4(ui.colours().panel, 0.96));
    const ImVec2 at = ImGui::GetWindowPos();
    if (level != HudLevel::kPlain) {
      DrawLevelMark(*ImGui::GetWindowDrawList(), level, {at.x + 18 * s, at.y + 0.5F * height}, 16 * s);
    }
    ImGui::SetCursorPos({left, 7 * s});
    WrappedText(text, max_width);
    ui.Note(name);
    ImGui::End();
    bottom -= 6 * s;
  };
  draw("message", messages.message, HudLevel::kPlain);
  draw("warning", messages.warning, HudLevel::kWarn);
  draw("staying message", messages.staying, HudLevel::kWarn, true);
}

}  // namespace kerf
