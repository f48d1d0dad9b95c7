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

Menu::State Menu::Take(const WindowEvent& event, const std::function<std::optional<int>(double x, double y)>& row_at) {
  using Kind = WindowEvent::Kind;
  const auto pick = [&](int row) {
    if (row < 0 || row >= static_cast<int>(items_.size()) || !items_[static_cast<std::size_t>(row)].enabled) {
      return State::kOpen;
    }
    selected_ = row;
    return State::kChosen;
  };
  if (event.kind == Kind::kMouseDown && event.button == MouseButton::kLeft) {
    const std::optional<int> row = row_at(event.x, event.y);
    return row ? pick(*row) : State::kOpen;
  }
  if (event.kind != Kind::kKeyDown) return State::kOpen;
  switch (event.key) {
    case Key::kEscape:
      return State::kCancelled;
    case Key::kEnter:
      return items_.empty() ? State::kCancelled : pick(selected_);
    case Key::kUp:
      Step(-1);
      return State::kOpen;
    case Key::kDown:
      Step(1);
      return State::kOpen;
    default:
      if (event.key >= Key::k1 && event.key <= Key::k9) {
        return pick(static_cast<int>(event.key) - static_cast<int>(Key::k1));
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
