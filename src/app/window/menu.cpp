#include "app/window/menu.h"

#include <algorithm>
#include <utility>

namespace kerf {

Menu::Menu(std::string title, std::vector<MenuItem> items, std::string footer)
    : title_(std::move(title)), items_(std::move(items)), footer_(std::move(footer)) {
  if (!items_.empty() && !items_.front().enabled) Step(1);
}

void Menu::Step(int by) {
  const int count = static_cast<int>(items_.size());
  for (int tried = 0; tried < count; ++tried) {
    selected_ = (selected_ + by + count) % count;
    if (items_[static_cast<std::size_t>(selected_)].enabled) return;
  }
}

Menu::State Menu::Pick(int row) {
  if (row < 0 || row >= static_cast<int>(items_.size()) || !items_[static_cast<std::size_t>(row)].enabled) {
    return State::kOpen;
  }
  selected_ = row;
  return State::kChosen;
}

Menu::State Menu::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (event.kind != Kind::kKeyDown) return State::kOpen;
  switch (event.key) {
    case Key::kEscape:
      return State::kCancelled;
    case Key::kEnter:
      return items_.empty() ? State::kCancelled : Pick(selected_);
    case Key::kUp:
      Step(-1);
      return State::kOpen;
    case Key::kDown:
      Step(1);
      return State::kOpen;
    default:
      if (event.key >= Key::k1 && event.key <= Key::k9) {
        return Pick(static_cast<int>(event.key) - static_cast<int>(Key::k1));
      }
      return State::kOpen;
  }
}

HudMenu Menu::Show() const {
  HudMenu menu;
  menu.title = title_;
  for (const MenuItem& item : items_) {
    menu.rows.push_back({.name = item.name, .detail = item.detail, .enabled = item.enabled});
  }
  menu.selected = selected_;
  menu.footer = footer_;
  return menu;
}

}  // namespace kerf
