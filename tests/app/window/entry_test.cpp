// Tests of text input and of menus.
#include <gtest/gtest.h>

#include <string>

#include "app/window/menu.h"
#include "app/window/text_entry.h"

namespace kerf {
namespace {

using Kind = WindowEvent::Kind;

WindowEvent Press(Key key) {
  WindowEvent event;
  event.kind = Kind::kKeyDown;
  event.key = key;
  return event;
}

WindowEvent Type(char32_t character) {
  WindowEvent event;
  event.kind = Kind::kText;
  event.character = character;
  return event;
}

TEST(TextEntry, KeepsPrintableTextAsUtf8AndDeletesWholeCharacters) {
  TextEntry entry("Name:", "a");
  for (const char32_t c : {U'ß', U'☃', U'\U0001F9B7', U'\n', U'\x1b', U'\x7f', U'\x85'}) entry.Take(Type(c));
  EXPECT_EQ(entry.text(), "a\xC3\x9F\xE2\x98\x83\xF0\x9F\xA6\xB7");
  entry.Take(Press(Key::kBackspace));
  entry.Take(Press(Key::kBackspace));
  EXPECT_EQ(entry.text(), "a\xC3\x9F");
  for (int i = 0; i < 5; ++i) entry.Take(Press(Key::kBackspace));
  EXPECT_EQ(entry.text(), "");
  for (int i = 0; i < 1000; ++i) entry.Take(Type(U'ä'));
  EXPECT_EQ(entry.text().size(), 120u);  // 60 characters of two bytes
  EXPECT_EQ(entry.Take(Press(Key::kF5)), TextEntry::State::kOpen);
  EXPECT_EQ(entry.Take(Press(Key::kEscape)), TextEntry::State::kCancelled);
  EXPECT_EQ(entry.Take(Press(Key::kEnter)), TextEntry::State::kDone);
}

TEST(Menu, SkipsRowsThatCannotBeChosen) {
  std::string chosen;
  const auto item = [&](const std::string& name, bool enabled) {
    return MenuItem{.name = name, .detail = "", .enabled = enabled, .choose = [&chosen, name] { chosen = name; }};
  };
  Menu menu("Menu", {item("a", false), item("b", true), item("c", false), item("d", true)});
  const auto no_mouse = [](double, double) { return std::optional<int>(); };
  EXPECT_EQ(menu.selected(), 1);
  EXPECT_EQ(menu.Take(Press(Key::kDown), no_mouse), Menu::State::kOpen);
  EXPECT_EQ(menu.selected(), 3);
  menu.Take(Press(Key::kDown), no_mouse);  // wraps around
  EXPECT_EQ(menu.selected(), 1);
  menu.Take(Press(Key::kUp), no_mouse);
  EXPECT_EQ(menu.Take(Press(Key::kEnter), no_mouse), Menu::State::kChosen);
  menu.chosen().choose();
  EXPECT_EQ(chosen, "d");
  EXPECT_EQ(menu.Take(Press(Key::k3), no_mouse), Menu::State::kOpen);  // not selectable
  EXPECT_EQ(menu.Take(Press(Key::k2), no_mouse), Menu::State::kChosen);
  EXPECT_EQ(menu.selected(), 1);
  EXPECT_EQ(menu.Take(Press(Key::k9), no_mouse), Menu::State::kOpen);  // does not exist
  WindowEvent click;
  click.kind = Kind::kMouseDown;
  EXPECT_EQ(menu.Take(click, no_mouse), Menu::State::kOpen);
  EXPECT_EQ(menu.Take(click, [](double, double) { return std::optional(3); }), Menu::State::kChosen);
  EXPECT_EQ(menu.Take(Press(Key::kEscape), no_mouse), Menu::State::kCancelled);
  Menu none("Menu", {});
  EXPECT_EQ(none.Take(Press(Key::kEnter), no_mouse), Menu::State::kCancelled);
}

}  // namespace
}  // namespace kerf
