// Tests of lists to choose from.
#include <gtest/gtest.h>

#include <string>

#include "app/window/menu.h"

namespace kerf {
namespace {

using Kind = WindowEvent::Kind;

WindowEvent Press(Key key) {
  WindowEvent event;
  event.kind = Kind::kKeyDown;
  event.key = key;
  return event;
}

TEST(Menu, SkipsRowsThatCannotBeChosen) {
  std::string chosen;
  const auto item = [&](const std::string& name, bool enabled) {
    return MenuItem{.name = name, .detail = "", .enabled = enabled, .choose = [&chosen, name] { chosen = name; }};
  };
  Menu menu("Menu", {item("a", false), item("b", true), item("c", false), item("d", true)});
  EXPECT_EQ(menu.selected(), 1);
  EXPECT_EQ(menu.Take(Press(Key::kDown)), Menu::State::kOpen);
  EXPECT_EQ(menu.selected(), 3);
  menu.Take(Press(Key::kDown));  // wraps around
  EXPECT_EQ(menu.selected(), 1);
  menu.Take(Press(Key::kUp));
  EXPECT_EQ(menu.Take(Press(Key::kEnter)), Menu::State::kChosen);
  menu.chosen().choose();
  EXPECT_EQ(chosen, "d");
  EXPECT_EQ(menu.Take(Press(Key::k3)), Menu::State::kOpen);  // not selectable
  EXPECT_EQ(menu.Take(Press(Key::k2)), Menu::State::kChosen);
  EXPECT_EQ(menu.selected(), 1);
  EXPECT_EQ(menu.Take(Press(Key::k9)), Menu::State::kOpen);  // does not exist
  EXPECT_EQ(menu.Pick(2), Menu::State::kOpen);               // not selectable
  EXPECT_EQ(menu.Pick(3), Menu::State::kChosen);
  EXPECT_EQ(menu.selected(), 3);
  EXPECT_EQ(menu.Pick(9), Menu::State::kOpen);
  EXPECT_EQ(menu.Take(Press(Key::kEscape)), Menu::State::kCancelled);
  Menu none("Menu", {});
  EXPECT_EQ(none.Take(Press(Key::kEnter)), Menu::State::kCancelled);
}

}  // namespace
}  // namespace kerf
