// List with a selectable entry.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "view/ui/event.h"
#include "view/ui/hud.h"
#include "view/ui/translate.h"

namespace kerf {

struct MenuItem {
  std::string name;
  std::string detail;
  bool enabled = true;
  std::function<void()> choose;
};

/// Menu that is controlled with Up, Down, Enter, Escape, the digits and the mouse.
class Menu {
 public:
  Menu(std::string title, std::vector<MenuItem> items,
       std::string footer = Tr("Up, Down: move   Enter: select   Esc: close"));

  enum class State { kOpen, kChosen, kCancelled };
  /// Consumes every key. If it returns kChosen, the caller must close the menu and then call choose() of chosen().
  State Take(const WindowEvent& event);
  /// The same for a row that was clicked.
  State Pick(int row);
  const MenuItem& chosen() const { return items_[static_cast<std::size_t>(selected_)]; }
  HudMenu Show() const;
  const std::string& title() const { return title_; }
  int selected() const { return selected_; }

 private:
  void Step(int by);

  std::string title_;
  std::vector<MenuItem> items_;
  std::string footer_;
  int selected_ = 0;
};

}  // namespace kerf
