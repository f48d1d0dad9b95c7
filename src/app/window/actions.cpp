#include "app/window/actions.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr const char* kMenus[] = {Msg("File"), Msg("Edit"),   Msg("View"),     Msg("Saw"),
                                  Msg("Plan"), Msg("Pieces"), Msg("Exercise"), Msg("Help")};

constexpr const char* kMore = ">>";  // button of a menu with what does not fit

std::string KeyName(Key key) {
  const auto code = static_cast<int>(key);
  if (key >= Key::kF1 && key <= Key::kF12) return fmt::format("F{}", code - static_cast<int>(Key::kF1) + 1);
  switch (key) {
    case Key::kSpace:
      return Tr("Space");
    case Key::kEscape:
      return Tr("Esc");
    case Key::kEnter:
      return Tr("Enter");
    case Key::kTab:
      return Tr("Tab");
    case Key::kBackspace:
      return Tr("Backspace");
    case Key::kDelete:
      return Tr("Del");
    case Key::kHome:
      return Tr("Home");
    case Key::kEnd:
      return Tr("End");
    default:
      return code < 256 && code > ' ' ? std::string(1, static_cast<char>(code)) : std::string();
  }
}

}  // namespace

std::string ShowShortcut(const Shortcut& shortcut) {
  if (shortcut.key == Key::kNone) return {};
  return fmt::format("{}{}{}", shortcut.control ? fmt::format("{}+", Tr("Ctrl")) : "",
                     shortcut.shift ? fmt::format("{}+", Tr("Shift")) : "", KeyName(shortcut.key));
}

std::string ShowKeyGroup(const char* menu, const char* when) {
  return when[0] == '\0' ? Tr(menu) : fmt::format("{}: {}", Tr(menu), Tr(when));
}

void ActionList::Add(Action action) {
  actions_.push_back(std::move(action));
}

const Action* ActionList::Find(const std::string& id) const {
  const auto at = std::find_if(actions_.begin(), actions_.end(), [&](const Action& a) { return a.id == id; });
  return at != actions_.end() ? &*at : nullptr;
}

bool ActionList::IsDisabled(const WindowEvent& event) const {
  if (event.kind != WindowEvent::Kind::kKeyDown || event.alt || event.key == Key::kNone) return false;
  bool known = false;
  for (const Action& action : actions_) {
    if (action.shortcut != Shortcut{event.key, event.control, event.shift}) continue;
    if (action.is_enabled()) return false;
    known = true;
  }
  return known;
}

bool ActionList::Take(const WindowEvent& event) {
  if (event.kind != WindowEvent::Kind::kKeyDown || event.alt || event.key == Key::kNone) return false;
  bool known = false;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (action.shortcut != Shortcut{event.key, event.control, event.shift}) continue;
    known = true;
    if (!action.is_enabled()) continue;
    if (!event.repeat || action.repeats) action.run();
    return true;
  }
  return known;
}

std::vector<std::string> ActionList::ForgetChosen() {
  std::vector<std::string> names;
  for (const std::size_t i : std::exchange(chosen_, {})) names.emplace_back(Tr(actions_[i].label));
  return names;
}

std::vector<HudKeyGroup> ActionList::ListKeys() const {
  std::vector<HudKeyGroup> groups;
  for (const Action& action : actions_) {
    if (action.shortcut.key == Key::kNone || action.menu[0] == '\0') continue;
    const std::string title = ShowKeyGroup(action.menu, action.when);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const HudKeyGroup& g) { return g.title == title; });
    if (group == groups.end()) group = groups.insert(groups.end(), HudKeyGroup{title, {}});
    group->keys.push_back({ShowShortcut(action.shortcut), Tr(action.label)});
  }
  return groups;
}

/// Draws the picture before the label, on the same line. It is made only once for each size.
void ActionList::DrawEntryPicture(Ui& ui, const std::string& id, const EntryDetails& details) {
  const float text = ImGui::GetTextLineHeight();
  const ImVec2 size{std::round(3.4F * text), std::round(1.3F * text)};
  Image& picture = pictures_[id];
  if (picture.width != static_cast<int>(size.x)) {
    picture = details.picture(static_cast<int>(size.x), static_cast<int>(size.y));
  }
  ImGui::Image(ui.Texture("entry " + id, picture, static_cast<std::uint64_t>(picture.width)), size);
  ImGui::SameLine();
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 0.5F * (size.y - text));
}

void ActionList::DrawEntries(Ui& ui, const char* menu) {
  bool first = true;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (std::string_view(action.menu) != menu || action.label[0] == '\0') continue;
    if (action.begins_group && !first) ImGui::Separator();
    first = false;
    std::string keys = ShowShortcut(action.shortcut);
    std::string tip = action.tip[0] == '\0' ? "" : Tr(action.tip);
    if (action.details) {
      const EntryDetails details = action.details();
      DrawEntryPicture(ui, action.id, details);
      keys = keys.empty() ? details.numbers : fmt::format("{}   [{}]", details.numbers, keys);
      tip = details.tip;
    }
    const std::string label = fmt::format("{}##{}", Tr(action.label), action.id);
    if (ImGui::MenuItem(label.c_str(), keys.empty() ? nullptr : keys.c_str(), action.on && action.on(),
                        CanBeChosen(action))) {
      chosen_.push_back(i);
    }
    ui.Note(fmt::format("entry {}", action.id));
    Tooltip(ui, tip);
  }
}

void ActionList::DrawMenus(Ui& ui) {
  for (const char* menu : kMenus) {
    const bool any = std::any_of(actions_.begin(), actions_.end(),
                                 [&](const Action& action) { return std::string_view(action.menu) == menu; });
    if (!any) continue;
    const bool open = ImGui::BeginMenu(Tr(menu));
    ui.Note(fmt::format("menu {}", menu));
    if (!open) continue;
    DrawEntries(ui, menu);
    ImGui::EndMenu();
  }
}

void ActionList::DrawToolbar(Ui& ui) {
  const auto width_of = [](const char* label) {
    return ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
  };
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  std::vector<std::size_t> shown;
  float width = -gap;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    if (actions_[i].button[0] == '\0' || !actions_[i].is_relevant()) continue;
    shown.push_back(i);
    width += gap + width_of(Tr(actions_[i].button));
  }
  // Buttons that do not fit are in a menu at the end.
  const float room = ImGui::GetContentRegionAvail().x;
  std::size_t fit = shown.size();
  while (fit > 0 && width > room) {
    if (fit == shown.size()) width += gap + width_of(kMore);
    width -= gap + width_of(Tr(actions_[shown[--fit]].button));
  }
  bool first = true;
  for (std::size_t k = 0; k < fit; ++k) {
    const std::size_t i = shown[k];
    const Action& action = actions_[i];
    const char* label = Tr(action.button);
    if (!first) ImGui::SameLine();
    first = false;
    const bool on = action.on && action.on();
    if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_Header));
    ImGui::BeginDisabled(!CanBeChosen(action));
    if (ImGui::Button(fmt::format("{}##{}", label, action.id).c_str())) chosen_.push_back(i);
    ImGui::EndDisabled();
    if (on) ImGui::PopStyleColor();
    ui.Note(fmt::format("button {}", action.id));
    const std::string keys = ShowShortcut(action.shortcut);
    const std::string tip = action.tip[0] == '\0' ? Tr(action.label) : Tr(action.tip);
    Tooltip(ui, keys.empty() ? tip : fmt::format("{} ({})", tip, keys));
  }
  if (fit == shown.size()) return;
  if (!first) ImGui::SameLine();
  if (ImGui::Button(kMore)) ImGui::OpenPopup("more buttons");
  ui.Note("button more");
  Tooltip(ui, Tr("More buttons: a wider window or smaller text (F10) shows them here"));
  if (!ImGui::BeginPopup("more buttons")) return;
  for (std::size_t k = fit; k < shown.size(); ++k) {
    const Action& action = actions_[shown[k]];
    if (ImGui::MenuItem(fmt::format("{}##{}", Tr(action.button), action.id).c_str(),
                        ShowShortcut(action.shortcut).c_str(), action.on && action.on(), CanBeChosen(action))) {
      chosen_.push_back(shown[k]);
    }
    ui.Note(fmt::format("button {}", action.id));
  }
  ImGui::EndPopup();
}

float ActionList::DrawIndicators(Ui& ui, float reserved) {
  struct Shown {
    std::size_t action;
    std::string text;
    bool on;
  };
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (action.indicator[0] == '\0' || !action.is_relevant()) continue;
    const bool on = action.on && action.on();
    const char* const state = action.state ? action.state() : nullptr;
    shown.push_back({i, fmt::format("{}: {}", Tr(action.indicator), state ? state : on ? Tr("on") : Tr("off")), on});
  }
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const float room = ImGui::GetWindowWidth() - reserved - ImGui::GetCursorPosX();
  const float more_width = ImGui::CalcTextSize(kMore).x + 2 * ImGui::GetStyle().FramePadding.x;
  const auto width_of = [&](const Shown& one) {
    return CalcIndicatorWidth(ui, one.text, ShowShortcut(actions_[one.action].shortcut));
  };
  // Those that do not fit are in a menu at the end.
  float width = -gap;
  for (const Shown& one : shown) width += gap + width_of(one);
  std::size_t fit = shown.size();
  while (fit > 0 && width > room) {
    if (fit == shown.size()) width += gap + more_width;
    width -= gap + width_of(shown[--fit]);
  }
  for (std::size_t k = 0; k < fit; ++k) {
    const Action& action = actions_[shown[k].action];
    if (k > 0) ImGui::SameLine();
    if (Indicator(ui, action.id.c_str(), shown[k].text, shown[k].on, ShowShortcut(action.shortcut),
                  action.tip[0] == '\0' ? Tr(action.label) : Tr(action.tip))) {
      chosen_.push_back(shown[k].action);
    }
    ui.Note(fmt::format("indicator {}", action.id));
  }
  if (fit == shown.size()) return ImGui::GetItemRectMax().x;
  if (fit > 0) ImGui::SameLine();
  if (ImGui::Button(fmt::format("{}##indicators", kMore).c_str())) ImGui::OpenPopup("more indicators");
  ui.Note("indicators more");
  const float right = ImGui::GetItemRectMax().x;
  Tooltip(ui, Tr("More modes: a wider window or smaller text (F10) shows them here"));
  if (!ImGui::BeginPopup("more indicators")) return right;
  for (std::size_t k = fit; k < shown.size(); ++k) {
    const Action& action = actions_[shown[k].action];
    if (ImGui::MenuItem(fmt::format("{}##{}", Tr(action.indicator), action.id).c_str(),
                        ShowShortcut(action.shortcut).c_str(), shown[k].on, CanBeChosen(action))) {
      chosen_.push_back(shown[k].action);
    }
    ui.Note(fmt::format("indicator {}", action.id));
  }
  ImGui::EndPopup();
  return right;
}

void ActionList::RunChosen() {
  for (const std::size_t i : std::exchange(chosen_, {})) {
    if (actions_[i].is_enabled()) {
      actions_[i].run();
    } else if (waits_) {
      chosen_.push_back(i);
    }
  }
}

}  // namespace kerf
