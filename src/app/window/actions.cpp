#include "app/window/actions.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

constexpr const char* kMenus[] = {Msg("File"), Msg("Edit"),   Msg("View"),     Msg("Saw"),
                                  Msg("Plan"), Msg("Pieces"), Msg("Exercise"), Msg("Help")};

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

std::vector<HudKeyGroup> ActionList::ListKeys(bool all) const {
  std::vector<HudKeyGroup> groups;
  for (const Action& action : actions_) {
    if (action.shortcut.key == Key::kNone || action.menu[0] == '\0' || (!all && !action.is_enabled())) continue;
    const std::string title = Tr(action.menu);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const HudKeyGroup& g) { return g.title == title; });
    if (group == groups.end()) group = groups.insert(groups.end(), HudKeyGroup{title, {}});
    group->keys.push_back({ShowShortcut(action.shortcut), Tr(action.label)});
  }
  return groups;
}

void ActionList::DrawEntries(Ui& ui, const char* menu) {
  bool first = true;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (std::string_view(action.menu) != menu || action.label[0] == '\0') continue;
    if (action.begins_group && !first) ImGui::Separator();
    first = false;
    const std::string keys = ShowShortcut(action.shortcut);
    const std::string label = fmt::format("{}##{}", Tr(action.label), action.id);
    if (ImGui::MenuItem(label.c_str(), keys.empty() ? nullptr : keys.c_str(), action.on && action.on(),
                        action.is_enabled())) {
      chosen_.push_back(i);
    }
    ui.Note(fmt::format("entry {}", action.id));
    Tooltip(ui, action.tip[0] == '\0' ? "" : Tr(action.tip));
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
  const float right = ImGui::GetWindowPos().x + ImGui::GetWindowWidth() - ImGui::GetStyle().WindowPadding.x;
  bool first = true;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (action.button[0] == '\0' || !action.is_relevant()) continue;
    const char* label = Tr(action.button);
    const float width = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
    // Buttons that do not fit are left out; the menus contain all actions.
    const float next =
        first ? ImGui::GetCursorScreenPos().x : ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x;
    if (next + width > right) return;
    if (!first) ImGui::SameLine();
    first = false;
    const bool on = action.on && action.on();
    if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_Header));
    ImGui::BeginDisabled(!action.is_enabled());
    if (ImGui::Button(fmt::format("{}##{}", label, action.id).c_str())) chosen_.push_back(i);
    ImGui::EndDisabled();
    if (on) ImGui::PopStyleColor();
    ui.Note(fmt::format("button {}", action.id));
    const std::string keys = ShowShortcut(action.shortcut);
    const std::string tip = action.tip[0] == '\0' ? Tr(action.label) : Tr(action.tip);
    Tooltip(ui, keys.empty() ? tip : fmt::format("{} ({})", tip, keys));
  }
}

void ActionList::DrawIndicators(Ui& ui) {
  bool first = true;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    const Action& action = actions_[i];
    if (action.indicator[0] == '\0' || !action.is_relevant()) continue;
    if (!first) ImGui::SameLine();
    first = false;
    const bool on = action.on && action.on();
    const std::string state = on ? Tr("on") : Tr("off");
    if (Indicator(ui, action.id.c_str(), fmt::format("{}: {}", Tr(action.indicator), state), on,
                  ShowShortcut(action.shortcut), action.tip[0] == '\0' ? Tr(action.label) : Tr(action.tip))) {
      chosen_.push_back(i);
    }
    ui.Note(fmt::format("indicator {}", action.id));
  }
}

void ActionList::RunChosen() {
  for (const std::size_t i : std::exchange(chosen_, {})) {
    if (actions_[i].is_enabled()) actions_[i].run();
  }
}

}  // namespace kerf
